import assert from "node:assert/strict";
import { test } from "node:test";
import { hasSeaFloor, type Metadata } from "../src/tileset.ts";

function metadata(heights: [number, number], coarsest_error: number, local = false): Metadata {
  const zoom = { zoom: 0, tiles: 1, triangles: 2, finest_error: 1, coarsest_error, available: [] };
  return { format: "", scheme: "", bounds: [0, 0, 1, 1], heights, max_zoom: 0, zooms: [zoom], asked: { reading: { local } } };
}

test("what is below 0 is sea where the data surely go deeper than any land", () => {
  assert.ok(hasSeaFloor(metadata([-8642, 6706], 3468)));
  assert.ok(!hasSeaFloor(metadata([-1076, 2544], 2056)), "a coarse surface hangs below the Alps");
  assert.ok(!hasSeaFloor(metadata([-430, 900], 10)), "the Dead Sea's shore");
  assert.ok(hasSeaFloor(metadata([-5000, -3000], 4900)), "all of it is below the lowest land");
  assert.ok(!hasSeaFloor(metadata([-8000, 9000], 10, true)), "the Moon has no sea");
});
