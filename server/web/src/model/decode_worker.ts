// What runs in a worker: decodes a model, and gives its arrays away.

import { DecodeError } from "../progressive/decode_error.ts";
import { decodeModel } from "../spm.ts";
import type { Outcome } from "./decode.ts";

self.addEventListener("message", ({ data }: MessageEvent<ArrayBuffer>) => {
  try {
    const mesh = decodeModel(new Uint8Array(data));
    postMessage({ mesh } satisfies Outcome, { transfer: [mesh.positions.buffer, mesh.representatives.buffer, mesh.corners.buffer] });
  } catch (error) {
    if (!(error instanceof DecodeError)) throw error;
    postMessage({ fault: error.message } satisfies Outcome);
  }
});
