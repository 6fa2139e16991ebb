// Tiles are decoded in workers, beside what draws. Where there are none (outside browsers, or for a page of another site), here.

import { DecodeError, HeaderCut } from "./decode_error.ts";
import { decoderModule } from "./decoder_module.ts";
import type { Decoded, Job, Outcome, TileDesk } from "./tile_desk.ts";

/** More would only take memory: tiles come one after the other over one line. */
const MOST_WORKERS = 3;
const BROKEN = "the worker that decodes it does not run";

/** A tile as far as it is decoded, and who goes on with it. */
export interface Decoding extends Decoded {
  readonly number: number;
  readonly desk: Desk;
}

/** Does jobs, sooner or later. */
interface Desk {
  /** How many jobs are not done yet. */
  readonly waiting: number;
  /** Whether it does none any more. */
  readonly isBroken: boolean;
  do(job: Job): Promise<Outcome>;
  forget(number: number): void;
}

/** Where no worker is. */
class OwnDesk implements Desk {
  readonly waiting = 0;
  readonly isBroken = false;
  private desk: Promise<TileDesk> | undefined;

  async do(job: Job): Promise<Outcome> {
    this.desk ??= ownDesk();
    return (await this.desk).do(job)!;
  }

  forget(number: number): void {
    void this.desk?.then((desk) => desk.do({ number, bytes: undefined }));
  }
}

/** Loaded only where it is needed. */
async function ownDesk(): Promise<TileDesk> {
  const [{ loadDecoder }, { TileDesk }] = await Promise.all([import("./decoder.ts"), import("./tile_desk.ts")]);
  await loadDecoder();
  return new TileDesk();
}

/** In a worker, which answers jobs of one tile in their order. */
class WorkerDesk implements Desk {
  isBroken = false;
  private readonly answers = new Map<number, { resolve: (outcome: Outcome) => void; reject: (error: Error) => void }>();
  /** Done when it has been given the decoder. */
  private ready: Promise<void> | undefined;

  constructor(private readonly worker: Worker) {
    this.start().catch(() => {});
    worker.addEventListener("message", ({ data }: MessageEvent<Outcome>) => {
      this.answers.get(data.number)?.resolve(data);
      this.answers.delete(data.number);
    });
    worker.addEventListener("error", () => {
      this.isBroken = true;
      for (const { reject } of this.answers.values()) reject(new DecodeError(BROKEN));
      this.answers.clear();
    });
  }

  get waiting(): number {
    return this.answers.size;
  }

  do({ number, bytes }: Job): Promise<Outcome> {
    if (this.isBroken) return Promise.reject(new DecodeError(BROKEN));
    // Whoever got the bytes may keep them.
    const own = bytes!.slice();
    return new Promise((resolve, reject) => {
      this.answers.set(number, { resolve, reject });
      this.send({ number, bytes: own }, [own.buffer]).catch((error: Error) => {
        this.answers.delete(number);
        reject(error);
      });
    });
  }

  forget(number: number): void {
    this.send({ number, bytes: undefined }).catch(() => {});
  }

  private async send(job: Job, transfer: ArrayBuffer[] = []): Promise<void> {
    await this.start();
    this.worker.postMessage(job, transfer);
  }

  private start(): Promise<void> {
    this.ready ??= decoderModule().then((module) => this.worker.postMessage(module));
    // Where it could not be loaded, it is tried again with the next job.
    return this.ready.catch((error: unknown) => {
      this.ready = undefined;
      throw error;
    });
  }
}

/** Gives each tile to the worker that has least to do. */
export class TileDecoders {
  private desks: Desk[] | undefined;
  private begun = 0;

  /** Starts what decodes before there is a tile: it loads and compiles while others wait. */
  prepare(): void {
    this.start();
  }

  /** Decodes a tile's first bytes; if its header is cut, the error is a {@link HeaderCut}. */
  async begin(bytes: Uint8Array): Promise<Decoding> {
    const desk = this.start().reduce((idlest, other) => (other.waiting < idlest.waiting ? other : idlest));
    try {
      return await decodingOf(desk, { number: this.begun++, bytes });
    } catch (error) {
      if (!desk.isBroken) throw error;
      this.desks = [new OwnDesk()];
      return this.begin(bytes);
    }
  }

  /** Goes on with the bytes that come next. */
  goOn({ desk, number }: Decoding, bytes: Uint8Array): Promise<Decoding> {
    return decodingOf(desk, { number, bytes });
  }

  /** A tile that is not whole will not be gone on with. */
  forget({ desk, number }: Decoding): void {
    desk.forget(number);
  }

  private start(): readonly Desk[] {
    return (this.desks ??= typeof Worker === "undefined" ? [new OwnDesk()] : this.workerDesks());
  }

  private workerDesks(): Desk[] {
    const count = Math.min(MOST_WORKERS, Math.max(1, navigator.hardwareConcurrency - 1));
    try {
      return Array.from({ length: count }, () => new WorkerDesk(new Worker(new URL("./tile_worker.js", import.meta.url), { type: "module" })));
    } catch {
      return [new OwnDesk()];
    }
  }
}

async function decodingOf(desk: Desk, job: Job): Promise<Decoding> {
  const outcome = await desk.do(job);
  if ("decoded" in outcome) return { ...outcome.decoded, number: job.number, desk };
  throw outcome.isHeaderCut ? new HeaderCut(outcome.fault) : new DecodeError(outcome.fault);
}

/** Those of all that is drawn. */
export const tileDecoders = new TileDecoders();
