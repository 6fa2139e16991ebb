// The decoder of models as a compiled module of WebAssembly.

import { compiledOnce } from "./wasm_module.ts";

export const modelDecoderModule = compiledOnce(new URL("./model_decoder/terrain_model_decoder_bg.wasm", import.meta.url));
