// Models are decoded in a worker, beside what draws: large ones take seconds.

import { DecodeError } from "../decode_error.ts";
import { decoderModule } from "../decoder_module.ts";
import type { Surface } from "../tile.ts";

/** What decodes, and a file's bytes. */
export interface Job {
  readonly module: WebAssembly.Module;
  readonly bytes: ArrayBuffer;
}

/** What came of a file's bytes: they are decoded, or at fault. */
export type Outcome = { readonly mesh: Surface } | { readonly fault: string };

/** Decodes a whole file, whose bytes are given away; what is wrong with it is a {@link DecodeError}. */
export async function decodeInWorker(bytes: ArrayBuffer): Promise<Surface> {
  const module = await decoderModule();
  const worker = new Worker(new URL("./decode_worker.js", import.meta.url), { type: "module" });
  try {
    const outcome = await new Promise<Outcome>((resolve, reject) => {
      worker.addEventListener("message", ({ data }: MessageEvent<Outcome>) => resolve(data));
      worker.addEventListener("error", () => reject(new Error("the worker that decodes it does not run")));
      worker.postMessage({ module, bytes } satisfies Job, [bytes]);
    });
    if ("mesh" in outcome) return outcome.mesh;
    throw new DecodeError(outcome.fault);
  } finally {
    worker.terminate();
  }
}
