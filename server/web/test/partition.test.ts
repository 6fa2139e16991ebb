import assert from "node:assert/strict";
import { test } from "node:test";
import { COARSEST_DETAIL, drawnPrefix, finestDetail, placesOf, triangleCount, type Detail } from "../src/partition.ts";
import type { Tile } from "../src/tile.ts";
import { gridTile } from "./grid_pyramid.ts";
import { SMALL } from "./small_tile.ts";
import { tileOf } from "./written_tile.ts";

const PYRAMID = { leafZoom: 2, cells: 8, leafError: 1, height: () => 0 };

/** Twice the area of each triangle drawn, in lattice units. */
function doubledAreas(tile: Tile, detail: Detail): number[] {
  const places = placesOf(tile, detail);
  const corner = (index: number) => tile.positions.subarray(3 * places[tile.corners[index]!]!);
  return Array.from({ length: drawnPrefix(tile, detail) }, (_, triangle) => {
    const [a, b, c] = [0, 1, 2].map((n) => corner(3 * triangle + n)) as [Float64Array, Float64Array, Float64Array];
    return (b[0]! - a[0]!) * (c[1]! - a[1]!) - (b[1]! - a[1]!) * (c[0]! - a[0]!);
  });
}

test("a vertex that is not in yet is drawn where its representative was moved to", async () => {
  const tile = tileOf(SMALL);
  assert.deepEqual([...placesOf(tile, COARSEST_DETAIL)], [0, 1, 2, 3, 0]);
  assert.deepEqual([...placesOf(tile, finestDetail(tile))], [9, 1, 2, 3, 4], "place 9 is vertex 0, put back");
});

test("every level of detail covers the square once, with as many triangles as it says", async () => {
  const tile = gridTile(PYRAMID, { zoom: 2, x: 3, y: 1 });
  const square = 2 * (2 ** tile.extentBits) ** 2;
  const sides = [0, 1, 2, 3].map((side) => [0, 1, 2, 3].map((other) => other === side));
  const details = [0, 1, 2].map((interior) => ({ ...COARSEST_DETAIL, interior }));
  const counts: number[] = [];
  for (const detail of [...details, ...sides.map((fineSides) => ({ interior: 2, fineSides })), finestDetail(tile)]) {
    const areas = doubledAreas(tile, detail);
    assert.ok(areas.every((area) => area >= 0), "no triangle is turned over");
    assert.equal(areas.reduce((sum, area) => sum + area, 0), square);
    assert.equal(areas.filter((area) => area > 0).length, triangleCount(tile, detail));
    counts.push(triangleCount(tile, detail));
  }
  assert.deepEqual(counts, [32, 64, 112, 116, 116, 116, 116, 128]);
});
