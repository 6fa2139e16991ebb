// What the decoders in Rust answer: arrays out of their memory, or that bytes are at fault.

import { DecodeError } from "./decode_error.ts";
import type { Level, Surface } from "./tile.ts";

/** A surface in a decoder's memory. */
export interface SurfaceInMemory {
  /** Three numbers a level. */
  levels(): Float64Array;
  positions(): Float64Array;
  representatives(): Uint32Array;
  corners(): Uint32Array;
}

/** What a call answers; what it throws is a {@link DecodeError}. */
export function orDecodeError<T>(call: () => T): T {
  try {
    return call();
  } catch (error) {
    throw new DecodeError(error instanceof Error ? error.message : String(error));
  }
}

export function arraysOf(surface: SurfaceInMemory): Surface {
  return {
    levels: levelsOf(surface.levels()),
    positions: surface.positions(),
    representatives: surface.representatives(),
    corners: surface.corners(),
  };
}

/** Three numbers a level. */
export function levelsOf(numbers: Float64Array): Level[] {
  return Array.from({ length: numbers.length / 3 }, (_, level) => {
    const [vertexEnd, triangleEnd, error] = numbers.subarray(3 * level) as unknown as [number, number, number];
    return { vertexEnd, triangleEnd, error };
  });
}
