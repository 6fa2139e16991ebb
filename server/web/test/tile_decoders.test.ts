import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { DecodeError, HeaderCut } from "../src/decode_error.ts";
import { loadDecoder } from "../src/decoder.ts";
import { decodeTile } from "../src/spt.ts";
import { TileDecoders } from "../src/tile_decoders.ts";

await loadDecoder();

const TILE = readFileSync("../../codec/golden/jacksboro_v3.spt");
const OTHER = readFileSync("../../codec/golden/small_v3.spt");
/** Its bytes before its levels. */
const HEADER = 103;

test("tiles that come in turns, in pieces, are each decoded on where they stopped", async () => {
  const decoders = new TileDecoders();
  const [first, other] = await Promise.all([decoders.begin(TILE.subarray(0, 500)), decoders.begin(OTHER.subarray(0, HEADER))]);
  assert.ok(first.levelsThere < first.ends.length && other.levelsThere < other.ends.length);
  const [rest, otherRest] = await Promise.all([decoders.goOn(first, TILE.subarray(500)), decoders.goOn(other, OTHER.subarray(HEADER))]);
  assert.deepEqual(rest.tile, decodeTile(TILE));
  assert.deepEqual(otherRest.tile, decodeTile(OTHER));
  assert.equal(rest.bytesThere, TILE.length);
});

test("before a level is whole there is no tile, and a cut header is told apart", async () => {
  const decoders = new TileDecoders();
  const begun = await decoders.begin(OTHER.subarray(0, HEADER));
  assert.equal(begun.tile, undefined);
  assert.deepEqual((await decoders.goOn(begun, OTHER.subarray(HEADER))).tile, decodeTile(OTHER));
  await assert.rejects(decoders.begin(OTHER.subarray(0, 50)), HeaderCut);
});

test("a tile that was forgotten, or is broken, has to begin anew", async () => {
  const decoders = new TileDecoders();
  const begun = await decoders.begin(TILE.subarray(0, 500));
  decoders.forget(begun);
  await assert.rejects(decoders.goOn(begun, TILE.subarray(500)), DecodeError);
  const again = await decoders.begin(TILE.subarray(0, 500));
  const broken = Uint8Array.from(TILE.subarray(500), (byte) => byte ^ 0x55);
  await assert.rejects(decoders.goOn(again, broken), DecodeError);
});
