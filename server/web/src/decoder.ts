// The decoder in Rust, which decodes here once it is loaded; docs/formats/spt.md and spm.md are the definitions.

import { DecodeError } from "./decode_error.ts";
import { initSync } from "./decoder/terrain_decoder.js";
import { decoderModule } from "./decoder_module.ts";
import type { Level, Surface } from "./tile.ts";

/** A surface in the decoder's memory; see `Surface` of `decoder/src/lib.rs`. */
interface SurfaceInMemory {
  /** Three numbers a level. */
  levels(): Float64Array;
  positions(): Float64Array;
  representatives(): Uint32Array;
  corners(): Uint32Array;
  free(): void;
}

let isLoaded = false;

/** Loads what decodes; before, nothing can be decoded. */
export async function loadDecoder(): Promise<void> {
  startDecoder(await decoderModule());
}

/** The same where the module is there already, as in a worker that it was given to. */
export function startDecoder(module: WebAssembly.Module): void {
  initSync({ module });
  isLoaded = true;
}

/** What a call of the decoder answers; what it throws is a {@link DecodeError}. */
export function answerOf<T>(call: () => T): T {
  if (!isLoaded) throw new Error("the decoder is not loaded: await loadDecoder() first");
  try {
    return call();
  } catch (error) {
    throw new DecodeError(error instanceof Error ? error.message : String(error));
  }
}

/** Takes the arrays of a surface out of the decoder's memory. */
export function taken(surface: SurfaceInMemory): Surface {
  const arrays = {
    levels: levelsOf(surface.levels()),
    positions: surface.positions(),
    representatives: surface.representatives(),
    corners: surface.corners(),
  };
  surface.free();
  return arrays;
}

/** Three numbers a level. */
export function levelsOf(numbers: Float64Array): Level[] {
  return Array.from({ length: numbers.length / 3 }, (_, level) => {
    const [vertexEnd, triangleEnd, error] = numbers.subarray(3 * level) as unknown as [number, number, number];
    return { vertexEnd, triangleEnd, error };
  });
}
