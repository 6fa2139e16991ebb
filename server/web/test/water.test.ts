import assert from "node:assert/strict";
import { test } from "node:test";
import type { Bounds } from "../src/frame.ts";
import { Water, WATER_CELLS, type WaterPolygon } from "../src/water.ts";

const square = (west: number, south: number, east: number, north: number) =>
  [[west, south], [east, south], [east, north], [west, north], [west, south]] as const;

/** Whether there is water in the cell of a place, from 0 to 1 eastwards and northwards through the tile. */
function isWater(polygons: readonly WaterPolygon[], tile: Bounds, x: number, y: number): boolean {
  const texels = new Water(polygons).texels(tile);
  return texels?.[Math.floor(y * WATER_CELLS) * WATER_CELLS + Math.floor(x * WATER_CELLS)] === 255;
}

test("a lake is water, its island and what is around it are not", () => {
  const lake: WaterPolygon = [square(10.2, 45.2, 10.8, 45.6), square(10.4, 45.3, 10.5, 45.5)];
  const at = (x: number, y: number) => isWater([lake], [10, 45, 11, 46], x, y);
  assert.ok(at(0.21, 0.21) && at(0.79, 0.59) && at(0.6, 0.4));
  assert.ok(!at(0.19, 0.4) && !at(0.5, 0.61) && !at(0.5, 0.19) && !at(0.45, 0.4));
  const cells = new Water([lake]).texels([10, 45, 11, 46])!.filter((texel) => texel === 255).length;
  assert.ok(Math.abs(cells / WATER_CELLS ** 2 - (0.24 - 0.02)) < 0.004, `${cells} cells`);
});

test("lakes that overlap are water where they do", () => {
  const lakes = [[square(0.1, 0.1, 0.6, 0.6)], [square(0.4, 0.4, 0.9, 0.9)]];
  assert.ok(isWater(lakes, [0, 0, 1, 1], 0.5, 0.5));
});

test("a tile within the water is all water, one beside it has none", () => {
  const sea = [[square(-20, -20, 20, 20)]];
  assert.ok(new Water(sea).texels([0, 0, 1, 1])!.every((texel) => texel === 255));
  assert.equal(new Water(sea).texels([21, 0, 22, 1]), undefined);
  assert.equal(new Water([]).texels([0, 0, 1, 1]), undefined);
});

test("water across the antimeridian is on both sides of it", () => {
  const sea = [[square(179.5, 0, 180.5, 1)]];
  assert.ok(isWater(sea, [179, 0, 180, 1], 0.75, 0.5) && !isWater(sea, [179, 0, 180, 1], 0.25, 0.5));
  assert.ok(isWater(sea, [-180, 0, -179, 1], 0.25, 0.5) && !isWater(sea, [-180, 0, -179, 1], 0.75, 0.5));
});

test("a slanting shore is where its line is", () => {
  const lake = [[[[0, 0], [1, 0], [0, 1]]]] as const;
  assert.ok(isWater(lake, [0, 0, 1, 1], 0.49, 0.49) && !isWater(lake, [0, 0, 1, 1], 0.51, 0.51));
});
