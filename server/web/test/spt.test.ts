import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeTile, TileError } from "../src/spt.ts";
import { encode } from "./encode.ts";
import { SMALL } from "./small_tile.ts";

test("a tile comes back as it was written, heights in metres", async () => {
  const tile = await decodeTile(encode(SMALL));
  assert.deepEqual(tile.address, { zoom: 3, x: 4, y: 5 });
  assert.deepEqual(tile.levels.map(({ vertexEnd }) => vertexEnd), [4, 5, 5, 5, 5, 5]);
  assert.deepEqual(tile.levels.map(({ triangleEnd }) => triangleEnd), [2, 4, 4, 4, 4, 4]);
  assert.deepEqual(tile.levels.map(({ error }) => error), [8, 2, 2, 2, 2, 2]);
  assert.deepEqual([...tile.positions.slice(0, 6)], [10, 20, -1.25, 2 ** 40, 0, 1.5]);
  assert.deepEqual([...tile.positions.slice(12, 15)], [300, 200, 1], "vertex 4");
  assert.deepEqual([...tile.positions.slice(27)], [0, 0, -1], "vertex 0, put back");
  assert.deepEqual([...tile.representatives], [0, 1, 2, 3, 0]);
  assert.deepEqual([...tile.corners], [4, 1, 2, 4, 2, 3, 0, 1, 4, 0, 4, 3]);
});

test("a tile cut off anywhere is refused", async () => {
  const bytes = encode(SMALL);
  for (let length = 0; length < bytes.length; length++) {
    await assert.rejects(decodeTile(bytes.slice(0, length)), TileError, `${length} bytes`);
  }
});

test("bytes changed at random never give anything but a tile or a clear error", async () => {
  let [state, refused] = [1, 0];
  const random = (below: number) => (state = (state * 48271) % 2147483647) % below;
  for (let round = 0; round < 500; round++) {
    const bytes = encode(SMALL);
    bytes[random(bytes.length)] = random(256);
    await decodeTile(bytes).catch((error: unknown) => {
      assert.ok(error instanceof TileError, String(error));
      refused++;
    });
  }
  assert.ok(refused > 200, `only ${refused} of 500 were refused`);
});

/** The small tile with one thing wrong in level 1. */
function broken(change: object): Uint8Array {
  return encode({ ...SMALL, levels: SMALL.levels.map((level, n) => (n === 1 ? { ...level, ...change } : level)) });
}

/** The small tile with level 1 said to inflate to more or fewer bytes than it does. */
function misannounced(difference: number): Uint8Array {
  const bytes = Buffer.from(encode(SMALL));
  const at = 32 + 32 + 28;
  bytes.writeUInt32LE(bytes.readUInt32LE(at) + difference, at);
  return bytes;
}

const faults: [string, Uint8Array, RegExp][] = [
  ["another magic", Uint8Array.from(encode(SMALL), (byte, at) => (at === 0 ? 0 : byte)), /magic/],
  ["an error that grows", broken({ error: 9 }), /bad error/],
  ["an error that is no number", broken({ error: NaN }), /bad error/],
  ["a side among the interior levels", broken({ kind: 2 }), /kind 2/],
  ["a corner that is no vertex", broken({ triangles: [[0, 1, 5]] }), /corner out of range/],
  ["a place outside the tile", broken({ vertices: [{ position: [-1, 0, 0], representative: 0 }] }), /outside the tile/],
  ["a vertex that represents itself", broken({ vertices: [{ position: [1, 1, 0], representative: 4 }] }), /before it/],
  ["a level longer than announced", misannounced(-1), /level 1 is longer/],
  ["a level shorter than announced", misannounced(1), /level 1 is shorter/],
  ["an address off the Earth", encode({ ...SMALL, address: { zoom: 3, x: 16, y: 0 } }), /off the Earth/],
];
for (const [name, bytes, message] of faults) {
  test(`${name} is refused`, async () => {
    await assert.rejects(decodeTile(bytes), (error: Error) => error instanceof TileError && message.test(error.message));
  });
}
