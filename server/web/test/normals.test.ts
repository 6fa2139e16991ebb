import assert from "node:assert/strict";
import { test } from "node:test";
import { DataUtils } from "three";
import { keyOf } from "../src/address.ts";
import { normalTexels, squareForLight } from "../src/normals.ts";

test("light comes from a square above as long as a cell of its raster covers two pixels at most", () => {
  const tile = { zoom: 5, x: 11, y: 7 };
  const of = (pixels: number) => keyOf(squareForLight(tile, pixels));
  assert.equal(of(2000), "5/11/7");
  assert.equal(of(257), "5/11/7", "the parent's would cover 2.01 pixels");
  assert.equal(of(256), "4/5/3");
  assert.equal(of(65), "3/2/1");
  assert.equal(of(64), "2/1/0");
  assert.equal(of(0), "0/0/0", "nothing is above a root");
});

/** Two squares of greys, one above the other, rows from the north, of parts of normals at a column and a row from the south. */
function greysOf(side: number, parts: readonly ((column: number, row: number) => number)[]): Uint8Array {
  return Uint8Array.from({ length: 2 * side * side }, (_, pixel) => {
    const [row, column] = [Math.floor(pixel / side) % side, pixel % side];
    const part = parts[Math.floor(pixel / side / side)]!(column, side - 1 - row);
    return Math.round(128 + 127 * Math.sign(part) * Math.sqrt(Math.abs(part)));
  });
}

test("normals are those that were told, and those of a smooth surface between them", () => {
  const side = 9;
  // Both are their own sign throughout, since greys are fine about 0 only.
  const east = (column: number, row: number) => 0.2 + 0.004 * column * row + 0.005 * column ** 2;
  const north = (column: number, row: number) => -0.1 - 0.02 * row - 0.003 * column ** 2;
  const texels = normalTexels(greysOf(side, [east, north]), side);
  assert.equal(texels.length, 2 * 17 * 17);
  let worst = 0;
  for (let texel = 0; texel < 17 * 17; texel++) {
    const [column, row] = [(texel % 17) / 2, Math.floor(texel / 17) / 2];
    const [toEast, toNorth] = [0, 1].map((part) => DataUtils.fromHalfFloat(texels[2 * texel + part]!)) as [number, number];
    worst = Math.max(worst, Math.abs(toEast - east(column, row)), Math.abs(toNorth - north(column, row)));
  }
  // Half a grey where the normal's part is 0.8, and what a cubic makes of it.
  assert.ok(worst < 0.01, String(worst));
});

test("squares beside each other have the same normals along their common side", () => {
  const side = 7;
  // Noise, the same for the same corner.
  const corner = (column: number, row: number) => Math.sin(12.9898 * column + 78.233 * row);
  const of = (x: number, y: number) =>
    normalTexels(greysOf(side, [(column, row) => corner(column + x, row + y), (column, row) => corner(row + y, column + x)]), side);
  const [here, east, north] = [of(0, 0), of(side - 1, 0), of(0, side - 1)];
  const fine = 2 * side - 1;
  for (let along = 0; along < fine; along++) {
    for (const part of [0, 1]) {
      assert.equal(here[2 * (along * fine + fine - 1) + part], east[2 * along * fine + part]);
      assert.equal(here[2 * ((fine - 1) * fine + along) + part], north[2 * along + part]);
    }
  }
});
