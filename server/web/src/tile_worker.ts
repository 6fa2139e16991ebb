// What runs in a worker: decodes tiles, and gives their arrays away.

import { startDecoder } from "./decoder.ts";
import { TileDesk, type Job } from "./tile_desk.ts";

const desk = new TileDesk();

/** First the decoder, then jobs. */
self.addEventListener("message", ({ data }: MessageEvent<WebAssembly.Module | Job>) => {
  if (data instanceof WebAssembly.Module) return startDecoder(data);
  const outcome = desk.do(data);
  if (outcome === undefined) return;
  const tile = "decoded" in outcome ? outcome.decoded.tile : undefined;
  const arrays = tile === undefined ? [] : [tile.positions.buffer, tile.representatives.buffer, tile.corners.buffer];
  postMessage(outcome, { transfer: arrays });
});
