// The decoder of tiles as a compiled module of WebAssembly.

import { compiledOnce } from "./wasm_module.ts";

export const decoderModule = compiledOnce(new URL("./decoder/terrain_decoder_bg.wasm", import.meta.url));
