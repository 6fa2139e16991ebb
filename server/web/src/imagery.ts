// Imagery in tiles of the web mercator scheme, as a picture for each square of the terrain.
//
// A square of zoom z is as wide as 2^k mercator tiles of zoom z + 1 + k, and those that it touches are put together row by row:
//
//        ┌───┬───┐  top of the picture
//      ┌─┼───┼───┼─┐  north of the square
//      │ ├───┼───┤ │
//      │ ├───┼───┤ │  so the picture's rows are mercator's; the shader finds the row of a latitude
//      └─┼───┼───┼─┘  south of the square
//        └───┴───┘
//
// Where the server has no tile, the nearest one above it that there is fills its place, enlarged. Where it has none of all that a
// square touches, coarser ones are taken, down to those of zoom z + 1; after these, the square above does.

import * as THREE from "three";
import type { Address } from "./address.ts";
import { tileBounds } from "./frame.ts";
import { ImageryTiles, nearestAbove, TilesOfPicture } from "./imagery_tiles.ts";
import { SquareRasters, type RasterDemand, type RasterOrder, type SquareRaster } from "./square_rasters.ts";

/** Where imagery comes from. */
export interface Imagery {
  /** An address with `{z}`, `{x}` and `{y}`, rows from the north. */
  readonly template: string;
  /** Whose it is, to be shown beside it. */
  readonly attribution: string;
}

/** A picture and which part of the Earth it shows. */
export interface Picture extends SquareRaster {
  /** Latitude that mercator rows are told from, radians: the square's south, or the end of the scheme. */
  readonly base: number;
  /** Mercator units of the picture's bottom above the base, and of its height. */
  readonly bottom: number;
  readonly height: number;
}

/** The scheme's square ends at this latitude, in degrees and in radians. */
const END = 85.0511287;
export const MERCATOR_END = THREE.MathUtils.degToRad(END);
const MOST_BYTES = 384 * 2 ** 20;
const TILE_PIXELS = 256;
/** Of 2^k tiles across. */
const FINEST_DETAIL = 2;
const FINEST_ZOOM = 22;

/** The pictures of an imagery. */
export function picturesOf({ template }: Imagery, onLoad: () => void): SquareRasters<Picture> {
  const tiles = new ImageryTiles(template);
  const load = (order: RasterOrder) => pictureOf(tiles, order);
  return new SquareRasters({ load, parallelSquares: 4, parallelRequests: 8, mostBytes: MOST_BYTES }, onLoad);
}

/** Why there is none to be seen, or not all, in a line. */
export function imageryFault({ failure, isBlank, isEmpty }: SquareRasters<Picture>): string | undefined {
  if (failure !== undefined) return `${isBlank ? "No imagery" : "Some imagery is missing"}: ${failure}.`;
  return isEmpty ? "No imagery: its server has no tiles here." : undefined;
}

/** How fine a picture a square needs that is so many pixels wide on the screen. */
export function detailFor(pixels: number, { zoom }: Address): number {
  const finest = Math.min(FINEST_DETAIL, FINEST_ZOOM - zoom - 1);
  return THREE.MathUtils.clamp(Math.ceil(Math.log2(pixels / TILE_PIXELS)), 0, Math.max(0, finest));
}

/** The finest picture that there is, up to the detail that is asked for; undefined where there is none that is not known. */
async function pictureOf(all: ImageryTiles, order: RasterOrder): Promise<Picture | undefined> {
  const [, south, , north] = tileBounds(order.address);
  if (south >= END || north <= -END) return undefined;
  const tiles = new TilesOfPicture(all, order);
  try {
    for (let detail = order.detail; detail >= 0 && detail > order.known; detail--) {
      const picture = await pictureOfDetail(tiles, { address: order.address, detail });
      if (picture !== undefined) return picture;
    }
    return undefined;
  } finally {
    tiles.close();
  }
}

/** Undefined where there are no tiles of this detail. */
async function pictureOfDetail(tiles: TilesOfPicture, { address, detail }: RasterDemand): Promise<Picture | undefined> {
  const zoom = address.zoom + 1 + detail;
  const [, south, , north] = tileBounds(address);
  const size = (2 * Math.PI) / 2 ** zoom;
  const rowAt = (latitude: number) => (Math.PI - mercator(latitude)) / size;
  const first = Math.max(0, Math.floor(rowAt(Math.min(north, END)) + 1e-9));
  const last = Math.min(2 ** zoom, Math.ceil(rowAt(Math.max(south, -END)) - 1e-9));
  const columns = 2 ** detail;
  const places = Array.from({ length: columns * (last - first) }, (_, at) => [at % columns, Math.floor(at / columns)] as const);
  const addresses = places.map(([column, row]) => ({ zoom, x: address.x * columns + column, y: first + row }));
  const own = await Promise.all(addresses.map(tiles.get));
  if (own.every((tile) => tile === undefined)) return undefined;
  const parts = await Promise.all(addresses.map((tile) => nearestAbove(tile, tiles.get)));
  const canvas = new OffscreenCanvas(columns * TILE_PIXELS, (last - first) * TILE_PIXELS);
  const context = canvas.getContext("2d")!;
  for (const [at, [column, row]] of places.entries()) {
    const part = parts[at];
    if (part === undefined) continue;
    const { image } = part.tile;
    const source = [part.x * image.width, part.y * image.height, part.size * image.width, part.size * image.height] as const;
    context.drawImage(image, ...source, column * TILE_PIXELS, row * TILE_PIXELS, TILE_PIXELS, TILE_PIXELS);
  }
  const base = Math.max(south, -END);
  return {
    texture: textureOf(canvas),
    bytesLoaded: [...new Set(parts.map((part) => part?.tile))].reduce((sum, tile) => sum + (tile?.bytes ?? 0), 0),
    bytesKept: (canvas.width * canvas.height * 4 * 4) / 3,
    base: THREE.MathUtils.degToRad(base),
    bottom: Math.PI - last * size - mercator(base),
    height: (last - first) * size,
  };
}

function textureOf(canvas: OffscreenCanvas): THREE.Texture {
  const texture = new THREE.CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = THREE.ClampToEdgeWrapping;
  texture.anisotropy = 8;
  return texture;
}

function mercator(latitude: number): number {
  return Math.asinh(Math.tan(THREE.MathUtils.degToRad(latitude)));
}

/** What is wrong with a template, in a line. */
export function templateFault(template: string): string | undefined {
  const missing = ["{z}", "{x}", "{y}"].filter((part) => !template.includes(part));
  return missing.length === 0 ? undefined : `The address of imagery has to have ${missing.join(" and ")} in it.`;
}
