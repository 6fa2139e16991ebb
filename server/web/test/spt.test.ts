import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { DecodeError } from "../src/progressive/decode_error.ts";
import { HeaderCut } from "../src/progressive/fields.ts";
import { decodeTile, decodeTilePrefix, TileDecoder } from "../src/spt.ts";

// Written by the encoder in Rust; what its own decoder makes of the larger one stands beside it.
const GOLDEN = "../../tiles/golden/";
const SMALL = readFileSync(`${GOLDEN}small_v3.spt`);

test("a tile of the encoder comes back, heights in metres", () => {
  const tile = decodeTile(SMALL);
  assert.deepEqual(tile.address, { zoom: 3, x: 5, y: 2 });
  assert.deepEqual(tile.levels.map(({ vertexEnd }) => vertexEnd), [14, 15, 16, 16, 16, 16]);
  assert.deepEqual(tile.levels.map(({ triangleEnd }) => triangleEnd), [15, 17, 18, 18, 18, 18]);
  assert.deepEqual(tile.levels.map(({ error }) => error), [2, 1.5, 1, 1, 1, 1]);
  assert.deepEqual([...tile.positions.subarray(42, 45)], [16, 16, 1], "vertex 14, inside");
  assert.deepEqual([...tile.positions.subarray(45, 48)], [0, 16, 0.5], "vertex 15, on the west side");
});

test("the levels of a real tile are those that the decoder in Rust finds, byte for byte", () => {
  const { positions, representatives, corners } = decodeTile(readFileSync(`${GOLDEN}jacksboro_v3.spt`));
  const bytes = [positions, representatives, corners].map(({ buffer }) => Buffer.from(buffer));
  assert.ok(Buffer.concat(bytes).equals(readFileSync(`${GOLDEN}jacksboro_v3.arrays`)));
});

test("the levels of a tile whose holes open are those that the decoder in Rust finds, byte for byte", () => {
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

test("filled ground is passed over, and a header that ends in it is cut", () => {
  // No edge along a breakline; five bytes of filled ground.
  const filled = [0, 5, 1, 2, 3, 4, 5];
  const bytes = Uint8Array.of(...SMALL.subarray(0, 52), ...filled, ...SMALL.subarray(52));
  bytes[4] = 6;
  assert.deepEqual(decodeTile(bytes), decodeTile(SMALL));
  assert.throws(() => new TileDecoder(bytes.subarray(0, 57)), HeaderCut);
});

test("of the first tenth of a tile the decoder in Rust makes the same, byte for byte", () => {
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
    [0, 0x54, /magic/],
    [4, 1, /version 1 is not 3/],
    [5, 63, /zoom 63/],
    [6, 41, /2\^41/],
    [9, 255, /off the Earth/],
    [19, 127, /lowest height/],
    [49, 4, /4 levels/],
    [52, 127, /fill|cut off/],
    [50, 100, /base/],
    [54, 100, /triangle count/],
    [55, 0x81, /error/],
  ];
  for (const [at, value, message] of cases) {
    const bytes = Uint8Array.from(SMALL);
    bytes[at] = value;
    assert.throws(() => decodeTile(bytes), (error: Error) => error instanceof DecodeError && message.test(error.message), `byte ${at}`);
  }
});
