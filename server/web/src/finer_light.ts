// Light that is finer than the squares of the tiles that are drawn: ground that errs little is drawn with large tiles, whose rasters of
// normals have cells of many pixels. Once a view rests, rasters of the smaller squares below them come, for what is in sight:
//
//        tile that is drawn            patch of the squares in sight
//     ┌───────────────────┐            ┌────┬────┐
//     │      ┌────┬────┐  │            │    │    │   one texture a tile; outside is the light of the tile's own raster,
//     │      │    │    │  │     ─▶     ├────┼────┤   and towards the inside of the tile it fades out
//     │      ├────┼────┤  │            │    │    │
//     │      │    │    │  │            └────┴────┘
//     └──────┴────┴────┴──┘
//
// While the view moves no squares are added, and those that there are stay, in patches of whatever tiles are drawn then.

import * as THREE from "three";
import { childrenOf, keyOf, type Address } from "./address.ts";
import { CELLS, normalsTexture, rasterBytes, squareForLight } from "./normals.ts";
import { SquareRasters, type RasterOrder, type RasterPlace, type SquareRaster } from "./square_rasters.ts";

/** What a cell may cover on the screen, if there are not too many. */
const MOST_PIXELS = 1;
/** Squares of all patches together, and along a side of one. */
export const MOST_SQUARES = 64;
const MOST_ALONG = 8;
const FADE_MILLISECONDS = 250;

/** Squares of one zoom, both ends inclusive. */
interface Area {
  readonly zoom: number;
  readonly west: number;
  readonly south: number;
  readonly east: number;
  readonly north: number;
}

/** Finer light of a tile. */
export interface LightPatch {
  readonly texture: THREE.Texture;
  /** From the tile's square to the patch: how wide the tile is in it, and where the tile's south-west corner is. */
  readonly size: THREE.Vector2;
  readonly corner: THREE.Vector2;
  /** Of the west, south, east and north side: 1 where the patch ends at the tile's side, 0 where it fades out. */
  readonly ends: THREE.Vector4;
  /** From 0 to 1 as it comes in. */
  readonly share: { value: number };
}

/** A patch, and what it was made of. */
interface Made {
  readonly area: Area;
  readonly of: string;
  readonly patch: LightPatch;
  dispose(): void;
}

/** What is known of a view. */
export interface Seen {
  /** Pixels that a square covers across. */
  pixels(square: Address): number;
  isInSight(square: Address): boolean;
  exists(square: Address): boolean;
}

/** Of one tileset. */
export class FinerLight {
  private readonly rasters: SquareRasters<SquareRaster>;
  private areas: readonly Area[] = [];
  /** By the tile, with what it was made of. */
  private patches = new Map<string, Made>();

  /** `load` gets the raster of a square; `normals` are those of tiles as they are drawn. */
  constructor(
    load: (order: RasterOrder) => Promise<SquareRaster | undefined>,
    private readonly normals: SquareRasters<SquareRaster>,
    onLoad: () => void,
  ) {
    this.rasters = new SquareRasters({ load, parallelSquares: 2, parallelRequests: 2, mostBytes: rasterBytes(MOST_SQUARES) }, onLoad);
  }

  get isLoading(): boolean {
    return this.rasters.isLoading;
  }

  get bytesLoaded(): number {
    return this.rasters.bytesLoaded;
  }

  /** Loads what a view that rests wants; tells whether all that can be had now is there, which {@link place} then makes patches of. */
  load(tiles: readonly Address[], seen: Seen): boolean {
    const areas = areasFor(tiles, seen);
    const squares = new Map(areas.flatMap(squaresOf).filter((square) => seen.exists(square) && seen.isInSight(square)).map((square) => [keyOf(square), square]));
    this.rasters.request([...squares.values()].map((address) => ({ address, detail: 0 })));
    if (this.isLoading) return false;
    this.areas = areas;
    return true;
  }

  /** Makes patches of the tiles that are drawn. What is new in a view that rests fades in; in one that moves it is in the place of others. */
  place(tiles: readonly Address[], isAtRest: boolean): void {
    const before = this.patches;
    this.patches = new Map();
    let squares = 0;
    for (const tile of tiles) {
      const parts = this.areas.flatMap((area) => overlap(area, tile) ?? []);
      // A square that holds all of the tile is another tile's matter if there are smaller ones.
      const smaller = parts.filter(({ zoom }) => zoom > tile.zoom);
      const area = smaller.length > 0 ? fitting(areaAround(smaller)) : undefined;
      squares += area === undefined ? 0 : squaresIn(area);
      if (area !== undefined && squares > MOST_SQUARES) continue;
      const known = before.get(keyOf(tile));
      const share = known?.patch.share ?? { value: isAtRest ? 0 : 1 };
      const made = area === undefined ? this.shared(tile, parts, share) : this.composed(tile, area, share, known, isAtRest);
      if (made !== undefined) this.patches.set(keyOf(tile), made);
    }
    for (const [key, made] of before) if (this.patches.get(key) !== made) made.dispose();
  }

  patchOf(tile: Address): LightPatch | undefined {
    return this.patches.get(keyOf(tile))?.patch;
  }

  get isFading(): boolean {
    return [...this.patches.values()].some(({ patch }) => patch.share.value < 1);
  }

  fade(milliseconds: number): void {
    for (const { patch: { share } } of this.patches.values()) share.value = Math.min(1, share.value + milliseconds / FADE_MILLISECONDS);
  }

  close(): void {
    this.rasters.close();
    for (const made of this.patches.values()) made.dispose();
    this.patches.clear();
  }

  /** Of several squares, in a texture of its own; the one that is known if nothing else is there, or the view moves. */
  private composed(tile: Address, area: Area, share: LightPatch["share"], known: Made | undefined, isAtRest: boolean): Made | undefined {
    const rasters = squaresOf(area).map((square) => this.finest(square));
    const isFiner = rasters.some((raster) => (raster?.of.zoom ?? 0) > tile.zoom);
    if (!isFiner) return undefined;
    const of = rasters.map((raster) => raster?.of.zoom).join();
    if (known !== undefined && nameOf(known.area) === nameOf(area) && (known.of === of || !isAtRest)) return known;
    const texture = textureOf(area, rasters);
    return { area, of, patch: { ...placed(tile, area), texture, share }, dispose: () => texture.dispose() };
  }

  /** The raster of the smallest of squares that hold the tile, if it is finer than the tile's own light. */
  private shared(tile: Address, holders: readonly Area[], share: LightPatch["share"]): Made | undefined {
    const [area] = [...holders].sort((a, b) => b.zoom - a.zoom);
    if (area === undefined) return undefined;
    const found = this.rasters.finest({ zoom: area.zoom, x: area.west, y: area.south });
    if (found === undefined || found.of.zoom <= (this.normals.finest(tile)?.of.zoom ?? Infinity)) return undefined;
    return { area, of: keyOf(found.of), patch: { ...placed(tile, areaOfSquare(found.of)), texture: found.raster.texture, share }, dispose: () => {} };
  }

  private finest(square: Address): RasterPlace<SquareRaster> | undefined {
    const [finer, own] = [this.rasters.finest(square), this.normals.finest(square)];
    return (finer?.of.zoom ?? -1) > (own?.of.zoom ?? -1) ? finer : own;
  }
}

/** What tiles that are in sight should have: as fine as there are squares for. */
export function areasFor(tiles: readonly Address[], seen: Seen): Area[] {
  for (let pixels = MOST_PIXELS; ; pixels *= 2) {
    const areas = new Map(tiles.map((tile) => areaFor(tile, seen, pixels)).map((area) => [nameOf(area), area]));
    const squares = [...areas.values()].reduce((sum, area) => sum + squaresIn(area), 0);
    if (squares <= MOST_SQUARES || pixels > 64) return squares <= MOST_SQUARES ? [...areas.values()] : [];
  }
}

function areaFor(tile: Address, seen: Seen, pixels: number): Area {
  const least = squareForLight(tile, seen.pixels(tile), pixels);
  if (least.zoom < tile.zoom) return areaOfSquare(least);
  const squaresBelow = (square: Address): Address[] => {
    const isFine = seen.pixels(square) <= pixels * CELLS;
    const below = isFine ? [] : childrenOf(square).filter((child) => seen.exists(child) && seen.isInSight(child));
    return below.length === 0 ? [square] : below.flatMap(squaresBelow);
  };
  return fitting(areaAround(squaresBelow(tile).map(areaOfSquare)));
}

function nameOf({ zoom, west, south, east, north }: Area): string {
  return [zoom, west, south, east, north].join("/");
}

function areaOfSquare({ zoom, x, y }: Address): Area {
  return { zoom, west: x, south: y, east: x, north: y };
}

/** Holds areas of any zooms, in squares of the finest of them. */
function areaAround(areas: readonly Area[]): Area {
  const zoom = Math.max(...areas.map((area) => area.zoom));
  const first = (side: "west" | "south") => Math.min(...areas.map((area) => area[side] * 2 ** (zoom - area.zoom)));
  const last = (side: "east" | "north") => Math.max(...areas.map((area) => (area[side] + 1) * 2 ** (zoom - area.zoom) - 1));
  return { zoom, west: first("west"), south: first("south"), east: last("east"), north: last("north") };
}

/** The area in squares that are as large as they have to be. */
function fitting(area: Area): Area {
  if (Math.max(area.east - area.west, area.north - area.south) < MOST_ALONG) return area;
  const [west, south, east, north] = [area.west, area.south, area.east, area.north].map((at) => at >> 1) as [number, number, number, number];
  return fitting({ zoom: area.zoom - 1, west, south, east, north });
}

/** What of an area's squares are a tile's, or hold the tile. */
function overlap(area: Area, tile: Address): Area | undefined {
  const scale = 2 ** (area.zoom - tile.zoom);
  const west = Math.max(area.west, Math.floor(tile.x * scale));
  const south = Math.max(area.south, Math.floor(tile.y * scale));
  const east = Math.min(area.east, Math.ceil((tile.x + 1) * scale) - 1);
  const north = Math.min(area.north, Math.ceil((tile.y + 1) * scale) - 1);
  return west <= east && south <= north ? { zoom: area.zoom, west, south, east, north } : undefined;
}

function squaresIn({ west, south, east, north }: Area): number {
  return (east - west + 1) * (north - south + 1);
}

/** Row by row from the south. */
function squaresOf({ zoom, west, south, east, north }: Area): Address[] {
  const columns = east - west + 1;
  return Array.from({ length: columns * (north - south + 1) }, (_, at) => ({ zoom, x: west + (at % columns), y: south + Math.floor(at / columns) }));
}

function placed(tile: Address, { zoom, west, south, east, north }: Area): Pick<LightPatch, "size" | "corner" | "ends"> {
  const [columns, rows, scale] = [east - west + 1, north - south + 1, 2 ** (zoom - tile.zoom)];
  const size = new THREE.Vector2(scale / columns, scale / rows);
  const corner = new THREE.Vector2((tile.x * scale - west) / columns, (tile.y * scale - south) / rows);
  const ends = [corner.x >= 0, corner.y >= 0, corner.x + size.x <= 1, corner.y + size.y <= 1].map(Number) as [number, number, number, number];
  return { size, corner, ends: new THREE.Vector4(...ends) };
}

/** Of the squares of an area, or what there is of those above them. */
function textureOf(area: Area, parts: readonly (RasterPlace<SquareRaster> | undefined)[]): THREE.DataTexture {
  const columns = area.east - area.west + 1;
  const [width, height] = [columns * CELLS + 1, (parts.length / columns) * CELLS + 1];
  const texels = new Uint16Array(2 * width * height);
  for (const [at, part] of parts.entries()) {
    if (part === undefined) continue;
    const first = CELLS * (Math.floor(at / columns) * width + (at % columns));
    for (let row = 0; row <= CELLS; row++) texels.set(rowOf(part, row), 2 * (first + row * width));
  }
  return normalsTexture(texels, width, height);
}

/** From west to east, the parts to the east and to the north: those that are there, or what is between them. */
function rowOf({ raster, size, x, y }: RasterPlace<SquareRaster>, row: number): Uint16Array {
  const texels = (raster.texture as THREE.DataTexture).image.data as Uint16Array;
  const side = CELLS + 1;
  if (size === 1) return texels.subarray(2 * row * side, 2 * (row + 1) * side);
  const [fromSouth, first] = [y * CELLS + row * size, x * CELLS];
  const south = Math.min(Math.floor(fromSouth), CELLS - 1);
  const between = new Uint16Array(2 * side);
  for (let column = 0; column < side; column++) {
    const fromWest = first + column * size;
    const west = Math.min(Math.floor(fromWest), CELLS - 1);
    const at = (part: number, right: number, up: number) => THREE.DataUtils.fromHalfFloat(texels[2 * ((south + up) * side + west + right) + part]!);
    for (const part of [0, 1]) {
      const [low, high] = [0, 1].map((up) => THREE.MathUtils.lerp(at(part, 0, up), at(part, 1, up), fromWest - west)) as [number, number];
      between[2 * column + part] = THREE.DataUtils.toHalfFloat(THREE.MathUtils.lerp(low, high, fromSouth - south));
    }
  }
  return between;
}
