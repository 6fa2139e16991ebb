// A tile as it is decoded: its levels of detail in flat arrays.

import type { Address } from "./address.ts";

const SIDES = 4;

/** How far the arrays reach for one level, and what its surface is good for. */
export interface Level {
  /** Vertices of this level and all before it. */
  readonly vertexEnd: number;
  /** Triangles of this level and all before it. */
  readonly triangleEnd: number;
  /** Certified error of the surface so far: vertical, in metres; of a model a distance, in its units. */
  readonly error: number;
}

/** A surface and its levels of detail, coarsest first. */
export interface Surface {
  readonly levels: readonly Level[];
  /**
   * Three coordinates for each of n vertices as stored, then n times where each vertex's representative goes when the vertex comes in
   * (its own place in level 0).
   */
  readonly positions: Float64Array;
  /** Vertex that each one is drawn at until its level comes in; itself in level 0. */
  readonly representatives: Uint32Array;
  /** Three corners a triangle, in the numbering of the finest surface. */
  readonly corners: Uint32Array;
}

/**
 * A decoded tile. Its positions are x, y in lattice units from the south-west corner and height in metres. The last four levels are the
 * sides west, south, east and north.
 */
export interface Tile extends Surface {
  readonly address: Address;
  /** The tile's side is 2^extentBits lattice units. */
  readonly extentBits: number;
}

/** How many levels come before the sides. */
export function interiorLevels({ levels }: Pick<Tile, "levels">): number {
  return levels.length - SIDES;
}
