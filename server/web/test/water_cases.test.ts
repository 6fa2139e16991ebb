// The recorded masks of water, which Rust gives alike.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { tileBounds } from "../src/frame.ts";
import { Water, WATER_CELLS, type WaterPolygon } from "../src/water.ts";

interface Case {
  polygons: WaterPolygon[];
  /** Zoom, column and row; lengths of runs of land, water, land, …, rows from the north. */
  masks: { tile: [number, number, number]; runs: number[] }[];
}

const cases = JSON.parse(readFileSync("../../tests/water/cases.json", "utf8")) as Case[];

test("masks of water are the recorded ones", () => {
  for (const { polygons, masks } of cases) {
    const water = new Water(polygons);
    for (const { tile: [zoom, x, y], runs } of masks) {
      const expected = runs.flatMap((length, at) => Array<number>(length).fill(at % 2 === 0 ? 0 : 255));
      const texels = water.texels(tileBounds({ zoom, x, y })) ?? new Uint8Array(WATER_CELLS ** 2);
      const fromNorth = expected.map((_, at) => texels[(WATER_CELLS - 1 - Math.floor(at / WATER_CELLS)) * WATER_CELLS + (at % WATER_CELLS)]!);
      assert.equal(fromNorth.filter((texel, at) => texel !== expected[at]).length, 0, `${zoom}/${x}/${y}`);
    }
  }
});
