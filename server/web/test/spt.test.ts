import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { deflateRawSync } from "node:zlib";
import { DecodeError, HeaderCut } from "../src/decode_error.ts";
import { loadDecoder } from "../src/decoder.ts";
import { decodeTile, decodeTilePrefix, TileDecoder } from "../src/spt.ts";

// What was decoded of them when they were written stands beside them.
const GOLDEN = "../../codec/golden/";
const SMALL = readFileSync(`${GOLDEN}small_v3.spt`);

test("before the decoder is loaded it says so", () => assert.throws(() => decodeTile(SMALL), /loadDecoder/));

test("the decoder is loaded, and another time, too", async () => {
  await loadDecoder();
  await loadDecoder();
});

test("a tile of the encoder comes back, heights in metres", () => {
  const tile = decodeTile(SMALL);
  assert.deepEqual(tile.address, { zoom: 3, x: 5, y: 2 });
  assert.deepEqual(tile.levels.map(({ vertexEnd }) => vertexEnd), [14, 15, 16, 16, 16, 16]);
  assert.deepEqual(tile.levels.map(({ triangleEnd }) => triangleEnd), [15, 17, 18, 18, 18, 18]);
  assert.deepEqual(tile.levels.map(({ error }) => error), [2, 1.5, 1, 1, 1, 1]);
  assert.deepEqual([...tile.positions.subarray(42, 45)], [16, 16, 1], "vertex 14, inside");
  assert.deepEqual([...tile.positions.subarray(45, 48)], [0, 16, 0.5], "vertex 15, on the west side");
});

test("the levels of a real tile are those that were recorded, byte for byte", () => {
  const { positions, representatives, corners } = decodeTile(readFileSync(`${GOLDEN}jacksboro_v3.spt`));
  const bytes = [positions, representatives, corners].map(({ buffer }) => Buffer.from(buffer));
  assert.ok(Buffer.concat(bytes).equals(readFileSync(`${GOLDEN}jacksboro_v3.arrays`)));
});

test("the levels of a tile whose holes open are those that were recorded, byte for byte", () => {
  const { positions, representatives, corners } = decodeTile(readFileSync(`${GOLDEN}holes_v4.spt`));
  const bytes = [positions, representatives, corners].map(({ buffer }) => Buffer.from(buffer));
  assert.ok(Buffer.concat(bytes).equals(readFileSync(`${GOLDEN}holes_v4.arrays`)));
});

test("edges along breaklines are passed over", () => {
  // What stands before the directory takes 52 bytes; two edges of four numbers each come after.
  const breaklines = [2, 6, 80, 122, 79, 0, 0, 113, 14];
  const bytes = Uint8Array.of(...SMALL.subarray(0, 52), ...breaklines, ...SMALL.subarray(52));
  bytes[4] = 5;
  assert.deepEqual(decodeTile(bytes), decodeTile(SMALL));
  bytes[52] = 200;
  assert.throws(() => decodeTile(bytes), DecodeError);
});

/** The small tile with bytes that tell of filled ground. */
function withFilled(filled: Uint8Array): Uint8Array {
  // No edge along a breakline; then a length of two digits of seven bits.
  const length = [(filled.length % 128) + 128, filled.length >> 7];
  const bytes = Uint8Array.of(...SMALL.subarray(0, 52), 0, ...length, ...filled, ...SMALL.subarray(52));
  bytes[4] = 6;
  return bytes;
}

test("filled ground is told by a bit a cell, and a header that ends in it is cut", () => {
  const cells = Uint8Array.from({ length: 256 * 32 }, (_, at) => at % 251);
  const bytes = withFilled(deflateRawSync(cells));
  const decoder = new TileDecoder(bytes);
  assert.deepEqual(decoder.filled, cells);
  assert.deepEqual(decoder.last(), decodeTile(SMALL));
  assert.equal(new TileDecoder(SMALL).filled, undefined);
  assert.throws(() => new TileDecoder(bytes.subarray(0, 100)), HeaderCut);
});

test("filled ground that is not the bits of all cells is refused", () => {
  for (const length of [256 * 32 - 1, 256 * 32 + 1]) {
    assert.throws(() => decodeTile(withFilled(deflateRawSync(new Uint8Array(length).fill(1)))), /filled ground/);
  }
  assert.throws(() => decodeTile(withFilled(Uint8Array.of(7, 7, 7))), DecodeError);
});

test("the first tenth of a tile is what was recorded, byte for byte", () => {
  const whole = readFileSync(`${GOLDEN}square_v3.spt`);
  const { positions, representatives, corners, levels } = decodeTilePrefix(whole.subarray(0, Math.floor(whole.length / 10)));
  const bytes = [positions, representatives, corners].map(({ buffer }) => Buffer.from(buffer));
  assert.ok(Buffer.concat(bytes).equals(readFileSync(`${GOLDEN}square_v3_tenth.arrays`)));
  assert.equal(levels[0]!.error, Infinity, "no level is whole");
  assert.deepEqual(decodeTilePrefix(whole).levels, decodeTile(whole).levels);
});

test("a tile that comes in pieces is decoded on from level to level, to the same as a whole one", () => {
  const whole = readFileSync(`${GOLDEN}square_v3.spt`);
  const first = new TileDecoder(whole.subarray(0, 300));
  const { ends } = first;
  assert.equal(ends.at(-1), whole.length);
  assert.deepEqual(first.levels, decodeTile(whole).levels);
  for (const [level, end] of ends.entries()) {
    // A byte short of the level, then it and the beginning of the next one.
    if (first.bytesThere < end - 1) first.add(whole.subarray(first.bytesThere, end - 1));
    if (first.bytesThere < end) assert.equal(first.levelsThere, level);
    first.add(whole.subarray(first.bytesThere, end + 5));
    assert.ok(first.levelsThere > level);
    if (first.levelsThere !== level + 1) continue;
    assert.deepEqual(first.tile(), decodeTilePrefix(whole.subarray(0, end)));
  }
  assert.deepEqual(first.tile(), decodeTile(whole));
});

test("a header that is cut is told from one that is wrong", () => {
  for (const length of [0, 48, 60]) assert.throws(() => new TileDecoder(SMALL.subarray(0, length)), HeaderCut, `${length} bytes`);
  const wrong = Uint8Array.from(SMALL);
  wrong[0] = 0;
  assert.throws(() => new TileDecoder(wrong), (error: Error) => error instanceof DecodeError && !(error instanceof HeaderCut));
});

test("a tile cut off anywhere is refused", () => {
  for (let length = 0; length < SMALL.length; length++) {
    assert.throws(() => decodeTile(SMALL.subarray(0, length)), DecodeError, `${length} bytes`);
  }
});

test("bytes changed at random never give anything but a tile or a clear error", () => {
  let [state, refused] = [1, 0];
  const random = (below: number) => (state = (state * 48271) % 2147483647) % below;
  for (let round = 0; round < 2000; round++) {
    const bytes = Uint8Array.from(SMALL);
    bytes[random(bytes.length)] = random(256);
    try {
      decodeTile(bytes);
    } catch (error) {
      assert.ok(error instanceof DecodeError, String(error));
      refused++;
    }
  }
  assert.ok(refused > 800, `only ${refused} of 2000 were refused`);
});

test("what contradicts the header or the directory is refused by name", () => {
  const cases: [number, number, RegExp][] = [
    [0, 0x54, /not a progressive terrain tile/],
    [4, 1, /version 1/],
    [5, 63, /tile address/],
    [6, 41, /lattice extent/],
    [9, 255, /tile address/],
    [19, 127, /lattice/],
    [49, 4, /number of levels/],
    [50, 100, /level 0/],
    [52, 127, /cut off/],
    [54, 100, /vertices or triangles/],
    [55, 0x81, /error/],
  ];
  for (const [at, value, message] of cases) {
    const bytes = Uint8Array.from(SMALL);
    bytes[at] = value;
    assert.throws(() => decodeTile(bytes), (error: Error) => error instanceof DecodeError && message.test(error.message), `byte ${at}`);
  }
});
