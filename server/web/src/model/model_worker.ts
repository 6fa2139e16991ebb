// What runs in a worker: decodes a model, refines it from view to view, and gives its arrays away.

import { DecodeError } from "../decode_error.ts";
import { ProgressiveModel, startModelDecoder } from "../progressive_model.ts";
import type { Job, Outcome } from "./working_model.ts";

let model: ProgressiveModel | undefined;

/** First a file, then views. */
self.addEventListener("message", ({ data }: MessageEvent<Job>) => {
  try {
    if ("view" in data) refine(data);
    else decode(data);
  } catch (error) {
    if (!(error instanceof DecodeError)) throw error;
    postMessage({ fault: error.message } satisfies Outcome);
  }
});

function decode({ module, bytes }: Extract<Job, { bytes: ArrayBuffer }>): void {
  startModelDecoder(module);
  model = new ProgressiveModel(new Uint8Array(bytes));
  const { mesh } = model;
  postMessage({ mesh } satisfies Outcome, { transfer: [mesh.positions.buffer, mesh.representatives.buffer, mesh.corners.buffer] });
}

function refine({ view }: Extract<Job, { view: unknown }>): void {
  if (model === undefined) throw new Error("no model was decoded");
  const redrawn = model.refine(view);
  const { places, corners, vertices, positions } = redrawn;
  postMessage({ redrawn } satisfies Outcome, { transfer: [places.buffer, corners.buffer, vertices.buffer, positions.buffer] });
}
