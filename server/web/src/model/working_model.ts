// A model in a worker, beside what draws: to decode a large one takes seconds, to refine it milliseconds a view.

import { DecodeError } from "../decode_error.ts";
import { modelDecoderModule } from "../model_decoder_module.ts";
import type { ModelView, Redrawn } from "../progressive_model.ts";
import type { Surface } from "../tile.ts";

/** What decodes and a file's bytes; then views, one after another. */
export type Job = { readonly module: WebAssembly.Module; readonly bytes: ArrayBuffer } | { readonly view: ModelView };

/** What came of a job. */
export type Outcome = { readonly mesh: Surface } | { readonly redrawn: Redrawn } | { readonly fault: string };

/** Its worker runs until it is closed. */
export class WorkingModel {
  private constructor(
    private readonly worker: Worker,
    readonly mesh: Surface,
  ) {}

  /** Decodes a whole file, whose bytes are given away; what is wrong with it is a {@link DecodeError}. */
  static async decode(bytes: ArrayBuffer): Promise<WorkingModel> {
    const module = await modelDecoderModule();
    const worker = new Worker(new URL("./model_worker.js", import.meta.url), { type: "module" });
    try {
      const outcome = await outcomeOf(worker, { module, bytes }, [bytes]);
      if ("mesh" in outcome) return new WorkingModel(worker, outcome.mesh);
      throw new Error("a worker that is to decode refines");
    } catch (error) {
      worker.terminate();
      throw error;
    }
  }

  /** What a view changes in what is drawn, once the view before is answered; a {@link DecodeError} where the surface cannot be refined. */
  async refine(view: ModelView): Promise<Redrawn> {
    const outcome = await outcomeOf(this.worker, { view });
    if ("redrawn" in outcome) return outcome.redrawn;
    throw new Error("a worker that is to refine decodes");
  }

  close(): void {
    this.worker.terminate();
  }
}

async function outcomeOf(worker: Worker, job: Job, given: Transferable[] = []): Promise<Exclude<Outcome, { fault: string }>> {
  const outcome = await new Promise<Outcome>((resolve, reject) => {
    worker.onmessage = ({ data }: MessageEvent<Outcome>) => resolve(data);
    worker.onerror = () => reject(new Error("the worker that decodes it does not run"));
    worker.postMessage(job, given);
  });
  if ("fault" in outcome) throw new DecodeError(outcome.fault);
  return outcome;
}
