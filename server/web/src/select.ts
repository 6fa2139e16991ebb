// Which tiles to draw, each at which level of detail: a restricted quadtree by screen-space error.
//
//   want:    from the roots down, refine what is visible and too coarse at its finest
//   close:   whoever is refined needs its neighbours on the map at its own zoom, so their parents are refined too
//   allow:   from the roots down, refine what is wanted, has its children loaded and its neighbours on the map
//   draw:    the leaves; a side is fine where the neighbour is refined, which needs the finest interior
//
// Hence drawn neighbours are at most one zoom apart and meet vertex to vertex whatever has been loaded so far.

import type { Box3, Vector3 } from "three";
import { childrenOf, keyOf, neighboursOf, parentOf, type Address } from "./address.ts";
import type { Detail } from "./partition.ts";

/** From where the terrain is seen, and how well it has to look. */
export interface View {
  readonly eye: Vector3;
  /** Viewport height / (2 · tan(fov / 2)): pixels per metre at a distance of one metre; times any exaggeration. */
  readonly pixelsPerRadian: number;
  /** Largest screen-space error allowed, pixels. */
  readonly maxPixels: number;
  isVisible(box: Box3): boolean;
}

/** What is known of the tiles. */
export interface Tiles {
  readonly roots: readonly Address[];
  exists(address: Address): boolean;
  /** Holds the tile; metres. */
  box(address: Address): Box3;
  /** Certified errors of a loaded tile's interior levels, coarsest first; undefined while it is not loaded. */
  errors(address: Address): readonly number[] | undefined;
  /** Largest certified error of the finest surfaces of a zoom, metres. */
  finestError(zoom: number): number;
}

/** A tile to draw. */
export interface Choice extends Detail {
  readonly address: Address;
  /** Certified error of what is drawn, metres. */
  readonly error: number;
}

/** What to draw now, and what to load, most urgent first. */
export interface Selection {
  readonly choices: Choice[];
  readonly missing: Address[];
}

type TileMap = Map<string, Address>;

/** Pixels that an error in metres covers at most at a distance in metres. */
export function screenSpaceError(error: number, distance: number, view: View): number {
  return error === 0 ? 0 : (error * view.pixelsPerRadian) / distance;
}

/** Chooses tiles and levels for a view. */
export function select(tiles: Tiles, view: View): Selection {
  const wanted = wantedRefinements(tiles, view);
  closeOverNeighbours(tiles, wanted);
  const refined = allowedRefinements(tiles, wanted);
  const choices = leaves(tiles, refined)
    .filter((leaf) => tiles.errors(leaf) !== undefined)
    .map((leaf) => chooseDetail(tiles, view, refined, leaf));
  return { choices, missing: missingTiles(tiles, view, wanted) };
}

/** The tiles that are too coarse for the view even at their finest, by zoom. */
function wantedRefinements(tiles: Tiles, view: View): TileMap[] {
  const wanted: TileMap[] = [];
  const visit = (tile: Address): void => {
    const error = tiles.errors(tile)?.at(-1) ?? tiles.finestError(tile.zoom);
    const pixels = screenSpaceError(error, tiles.box(tile).distanceToPoint(view.eye), view);
    if (pixels <= view.maxPixels || !view.isVisible(tiles.box(tile))) return;
    const children = existingChildren(tiles, tile);
    if (children.length === 0) return;
    (wanted[tile.zoom] ??= new Map()).set(keyOf(tile), tile);
    children.forEach(visit);
  };
  tiles.roots.forEach(visit);
  return wanted;
}

function closeOverNeighbours(tiles: Tiles, wanted: TileMap[]): void {
  for (let zoom = wanted.length - 1; zoom > 0; zoom--) {
    for (const tile of wanted[zoom]!.values()) {
      for (const near of [tile, ...existingNeighbours(tiles, tile)]) {
        const parent = parentOf(near);
        wanted[zoom - 1]!.set(keyOf(parent), parent);
      }
    }
  }
}

/** The wanted refinements that what is loaded permits, coarse before fine, since a finer one may lean on a coarser. */
function allowedRefinements(tiles: Tiles, wanted: readonly TileMap[]): TileMap {
  const refined: TileMap = new Map();
  const isOnMap = (tile: Address) => tile.zoom === 0 || refined.has(keyOf(parentOf(tile)));
  for (const tile of wanted.flatMap((ofZoom) => [...ofZoom.values()])) {
    const isLoaded = existingChildren(tiles, tile).every((child) => tiles.errors(child) !== undefined);
    if (isLoaded && [tile, ...existingNeighbours(tiles, tile)].every(isOnMap)) refined.set(keyOf(tile), tile);
  }
  return refined;
}

function leaves(tiles: Tiles, refined: TileMap): Address[] {
  const visit = (tile: Address): Address[] =>
    refined.has(keyOf(tile)) ? existingChildren(tiles, tile).flatMap(visit) : [tile];
  return tiles.roots.flatMap(visit);
}

function chooseDetail(tiles: Tiles, view: View, refined: TileMap, address: Address): Choice {
  const fineSides = neighboursOf(address).map((near) => near !== undefined && refined.has(keyOf(near)));
  const errors = tiles.errors(address) ?? [];
  const distance = tiles.box(address).distanceToPoint(view.eye);
  const isGoodEnough = (error: number) => screenSpaceError(error, distance, view) <= view.maxPixels;
  const coarsest = fineSides.includes(true) ? -1 : errors.findIndex(isGoodEnough);
  const interior = coarsest < 0 ? errors.length - 1 : coarsest;
  return { address, interior, fineSides, error: errors[interior] ?? Infinity };
}

/** Coarse zooms first, for nothing finer can be shown without them; then what looks worst. */
function missingTiles(tiles: Tiles, view: View, wanted: readonly TileMap[]): Address[] {
  const parents = wanted.flatMap((ofZoom) => [...ofZoom.values()]);
  const needed = [...tiles.roots, ...parents.flatMap((tile) => existingChildren(tiles, tile))];
  return needed
    .filter((tile) => tiles.errors(tile) === undefined)
    .map((tile) => ({ tile, distance: tiles.box(tile).distanceToPoint(view.eye) }))
    .sort((a, b) => a.tile.zoom - b.tile.zoom || a.distance - b.distance)
    .map(({ tile }) => tile);
}

function existingChildren(tiles: Tiles, tile: Address): Address[] {
  return childrenOf(tile).filter((child) => tiles.exists(child));
}

function existingNeighbours(tiles: Tiles, tile: Address): Address[] {
  return neighboursOf(tile).filter((near) => near !== undefined && tiles.exists(near)) as Address[];
}
