// What runs in a worker: decodes tiles, and gives their arrays away.

import { TileDesk, type Job } from "./tile_desk.ts";

const desk = new TileDesk();

self.addEventListener("message", async ({ data }: MessageEvent<Job>) => {
  const outcome = await desk.do(data);
  if (outcome === undefined) return;
  const tile = "decoded" in outcome ? outcome.decoded.tile : undefined;
  const arrays = tile === undefined ? [] : [tile.positions.buffer, tile.representatives.buffer, tile.corners.buffer];
  postMessage(outcome, { transfer: arrays });
});
