// Places that vertices are drawn at, and those on the sides of tiles, where tiles meet.

import type { Vector3 } from "three";
import { degreesOf } from "./address.ts";
import { tileBounds, type Frame } from "./frame.ts";
import { interiorLevels, type Tile } from "./tile.ts";

/** A place that a vertex is drawn at. */
export interface Spot {
  /** Degrees. */
  readonly longitude: number;
  readonly latitude: number;
  /** Metres. */
  readonly height: number;
  /** In the frame. */
  readonly position: Vector3;
  /** The tile that has it among its places, and which one it is; where it is none of a tile's, this is not said. */
  readonly own: { readonly tile: Tile; readonly place: number } | undefined;
}

/** A tile, and its places in a frame. */
export interface PlacedTile {
  readonly tile: Tile;
  readonly spots: readonly Spot[];
}

/** Longitudes and latitudes are exact, whichever tile they are told from: few bits of 45 degrees over a power of two. */
export function placed(tile: Tile, frame: Frame): PlacedTile {
  const [west, south] = tileBounds(tile.address);
  const degreesPerUnit = degreesOf(tile.address.zoom) / 2 ** tile.extentBits;
  const spots = Array.from({ length: tile.positions.length / 3 }, (_, place) => {
    const [longitude, latitude] = [west + tile.positions[3 * place]! * degreesPerUnit, south + tile.positions[3 * place + 1]! * degreesPerUnit];
    const height = tile.positions[3 * place + 2]!;
    return { longitude, latitude, height, position: frame.position(longitude, latitude, height), own: { tile, place } };
  });
  return { tile, spots };
}

/** So much of the way from one to the other. */
export function between(from: Spot, to: Spot, share: number): Spot {
  const mixed = (a: number, b: number) => a + (b - a) * share;
  return {
    longitude: mixed(from.longitude, to.longitude),
    latitude: mixed(from.latitude, to.latitude),
    height: mixed(from.height, to.height),
    position: from.position.clone().lerp(to.position, share),
    own: undefined,
  };
}

/** Where a place on a side is between two vertices of it: alike for the tiles on both sides, to the bit. */
export function onSide(spots: readonly Spot[], before: SideVertex, after: SideVertex, along: number): Spot {
  return between(spots[before.vertex]!, spots[after.vertex]!, (along - before.along) / (after.along - before.along));
}

/** A vertex on a side of a tile. */
export interface SideVertex {
  readonly vertex: number;
  /** Lattice units along the side, northwards or eastwards. */
  readonly along: number;
  /** Whether only the fine side shows it. */
  readonly isFine: boolean;
}

/** The vertices on the west, south, east and north side, in order along it. */
export function sideVertices(tile: Tile): SideVertex[][] {
  const extent = 2 ** tile.extentBits;
  const interiorEnd = tile.levels[interiorLevels(tile) - 1]!.vertexEnd;
  const sides: SideVertex[][] = [[], [], [], []];
  for (let vertex = 0; vertex < tile.representatives.length; vertex++) {
    const [x, y, isFine] = [tile.positions[3 * vertex]!, tile.positions[3 * vertex + 1]!, vertex >= interiorEnd];
    if (x === 0) sides[0]!.push({ vertex, along: y, isFine });
    if (y === 0) sides[1]!.push({ vertex, along: x, isFine });
    if (x === extent) sides[2]!.push({ vertex, along: y, isFine });
    if (y === extent) sides[3]!.push({ vertex, along: x, isFine });
  }
  return sides.map((vertices) => vertices.sort((a, b) => a.along - b.along));
}
