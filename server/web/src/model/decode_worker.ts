// What runs in a worker: decodes a model, and gives its arrays away.

import { DecodeError } from "../decode_error.ts";
import { startDecoder } from "../decoder.ts";
import { decodeModel } from "../spm.ts";
import type { Job, Outcome } from "./decode.ts";

self.addEventListener("message", ({ data: { module, bytes } }: MessageEvent<Job>) => {
  startDecoder(module);
  try {
    const mesh = decodeModel(new Uint8Array(bytes));
    postMessage({ mesh } satisfies Outcome, { transfer: [mesh.positions.buffer, mesh.representatives.buffer, mesh.corners.buffer] });
  } catch (error) {
    if (!(error instanceof DecodeError)) throw error;
    postMessage({ fault: error.message } satisfies Outcome);
  }
});
