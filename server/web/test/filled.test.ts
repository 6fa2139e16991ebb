import assert from "node:assert/strict";
import { test } from "node:test";
import { FILLED_CELLS, filledTexels, isFilled } from "../src/filled.ts";

const BITS = new Uint8Array((FILLED_CELLS * FILLED_CELLS) / 8);
// Column 9 of row 2, the lowest bit of a byte first.
BITS[(2 * FILLED_CELLS) / 8 + 1] = 2;

test("a cell is filled where its bit is, rows from the south and columns from the west", () => {
  const filled = Array.from({ length: 16 }, (_, at) => isFilled(BITS, (at + 0.5) / FILLED_CELLS, 2.5 / FILLED_CELLS));
  assert.equal(filled.indexOf(true), 9);
  assert.equal(filled.lastIndexOf(true), 9);
  assert.ok(!isFilled(BITS, 9.5 / FILLED_CELLS, 1.5 / FILLED_CELLS));
  assert.equal(filledTexels(BITS).indexOf(255), 2 * FILLED_CELLS + 9);
});

test("what is beside the square is in the cells at its sides", async () => {
  const corner = BITS.map((_, at) => (at === BITS.length - 1 ? 128 : 0));
  assert.ok(isFilled(corner, 1, 1) && isFilled(corner, 1.1, 2) && !isFilled(corner, -1, 1));
});
