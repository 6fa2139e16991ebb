import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { keyOf } from "../src/address.ts";
import { loadDecoder } from "../src/decoder.ts";
import { Frame, tileBounds } from "../src/frame.ts";
import { decodeTile } from "../src/spt.ts";
import type { SharedUniforms } from "../src/tile_mesh.ts";
import { TileStore } from "../src/tile_store.ts";

await loadDecoder();

const BYTES = readFileSync("../../codec/golden/jacksboro_v3.spt");
const { address, levels } = decodeTile(BYTES);

/** A store over an archive of one tile, and what resolves when its next tile has come in. */
function storeOfOne() {
  const bounds = tileBounds(address);
  const zooms = [{ zoom: address.zoom, tiles: 1, triangles: 1, finest_error: 1, coarsest_error: 1, available: [[address.x, address.y, address.x, address.y]] as const }];
  const metadata = { format: "", scheme: "geographic-tms", bounds, heights: [0, 2000] as const, max_zoom: address.zoom, zooms };
  const tile = async (_: unknown, from: number, count: number) => Uint8Array.from(BYTES.subarray(from, from + count));
  let isIn = () => {};
  const shared = { exaggeration: { value: 1 } } as SharedUniforms;
  const store = new TileStore({ name: keyOf(address), metadata, source: { tile, normals: undefined } }, new Frame(bounds[0], bounds[1]), shared, () => isIn());
  return { store, load: (count: number) => new Promise<void>((resolve) => ((isIn = resolve), store.request([{ address, levels: count }]))) };
}

test("levels that come in of a tile that is drawn are more until they are taken up", async () => {
  const { store, load } = storeOfOne();
  await load(1);
  const first = store.levelsThere(address);
  assert.ok(first >= 1 && first < levels.length && !store.hasMore, `${first} of ${levels.length} levels`);
  await load(levels.length);
  assert.ok(store.hasMore);
  assert.equal(store.levelsThere(address), first);
  store.takeUp();
  assert.ok(!store.hasMore);
  assert.equal(store.levelsThere(address), levels.length);
});

test("a store that is closed has no more", async () => {
  const { store, load } = storeOfOne();
  await load(1);
  await load(levels.length);
  store.close();
  assert.ok(!store.hasMore);
  store.takeUp();
});
