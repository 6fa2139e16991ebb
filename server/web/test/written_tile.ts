// Tiles as a decoder would give them, from lists that are easy to write.

import type { Address } from "../src/address.ts";
import type { Tile } from "../src/tile.ts";

export type Position = readonly [number, number, number];

/** A vertex; all but those of the coarsest level say whom they split from, and where that one then goes. */
export interface WrittenVertex {
  readonly position: Position;
  readonly representative?: number;
  readonly restored?: Position;
}

export interface WrittenLevel {
  readonly error: number;
  readonly vertices: readonly WrittenVertex[];
  readonly triangles: readonly (readonly number[])[];
}

export interface WrittenTile {
  readonly address: Address;
  readonly extentBits: number;
  readonly heightExponent: number;
  readonly levels: readonly WrittenLevel[];
}

/** The arrays of a tile. */
export function tileOf({ address, extentBits, heightExponent, levels }: WrittenTile): Tile {
  const vertices = levels.flatMap((level) => level.vertices);
  const current = vertices.map(({ position }) => position);
  const restored = vertices.map(({ position, representative, restored }) => {
    if (representative === undefined) return position;
    return (current[representative] = restored ?? current[representative]!);
  });
  const places = [...vertices.map(({ position }) => position), ...restored];
  let [vertexEnd, triangleEnd] = [0, 0];
  return {
    address,
    extentBits,
    levels: levels.map((level) => ({
      vertexEnd: (vertexEnd += level.vertices.length),
      triangleEnd: (triangleEnd += level.triangles.length),
      error: level.error,
    })),
    positions: Float64Array.from(places.flatMap(([x, y, height]) => [x, y, height * 2 ** heightExponent])),
    representatives: Uint32Array.from(vertices, ({ representative }, vertex) => representative ?? vertex),
    corners: Uint32Array.from(levels.flatMap((level) => level.triangles.flat())),
  };
}
