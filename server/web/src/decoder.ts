// The decoder of tiles in Rust, which decodes here once it is loaded; docs/formats/spt.md is the definition.

import { orDecodeError } from "./decoded.ts";
import { initSync } from "./decoder/terrain_decoder.js";
import { decoderModule } from "./decoder_module.ts";

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

/** What a call of the decoder answers; what it throws is a DecodeError. */
export function answerOf<T>(call: () => T): T {
  if (!isLoaded) throw new Error("the decoder is not loaded: await loadDecoder() first");
  return orDecodeError(call);
}
