import assert from "node:assert/strict";
import { test } from "node:test";
import { colourScaleOf, commonScale } from "../src/colour_scale.ts";
import type { Metadata } from "../src/tileset.ts";

/** An archive with samples between two heights, and coarse surfaces a kilometre beyond them. */
function scaleOf(heights: readonly [number, number], heights_above = "EGM96", local = false) {
  const metadata: Metadata = {
    format: "", scheme: "", bounds: [0, 0, 1, 1], heights: [heights[0] - 1000, heights[1] + 1000], max_zoom: 0, zooms: [],
    asked: { reading: { local } }, source: { heights_above, heights },
  };
  return colourScaleOf(metadata);
}

test("land below the sea is land: no height alone makes water of it", () => {
  assert.equal(scaleOf([-86, 3368]).seaLevel, undefined, "Death Valley");
  assert.equal(scaleOf([-732, 1020]).seaLevel, undefined, "the Dead Sea with its bed: its shore is at −430 m");
  assert.equal(scaleOf([-7, 320]).seaLevel, undefined, "the Netherlands");
  assert.equal(scaleOf([-30, 80], "WGS 84 ellipsoid").seaLevel, undefined, "a coast where the geoid is below the ellipsoid");
  assert.equal(scaleOf([-8000, 9000], "EGM96", true).seaLevel, undefined, "the Moon has no sea");
});

test("where samples are deeper than any land, all below the sea level is sea", () => {
  assert.equal(scaleOf([-10_376, 7833]).seaLevel, 0);
  assert.equal(scaleOf([-5000, -3000]).seaLevel, 0);
  assert.equal(scaleOf([-10_376, 7833], "WGS 84 ellipsoid").seaLevel, -107, "only what is below the geoid wherever it is");
});

test("the scale is that of the samples, and of the surfaces in archives that tell no more", () => {
  assert.deepEqual(scaleOf([-40, 2600]).ends, [-40, 2600]);
  const older: Metadata = { format: "", scheme: "", bounds: [0, 0, 1, 1], heights: [-4000, 900], max_zoom: 0, zooms: [] };
  assert.deepEqual(colourScaleOf(older), { ends: [-4000, 900], seaLevel: undefined });
});

test("one scale serves several archives", () => {
  const scales = [{ ends: [200, 1100], seaLevel: undefined }, { ends: [-4000, 900], seaLevel: 0 }] as const;
  assert.deepEqual(commonScale(scales), { ends: [-4000, 1100], seaLevel: 0 });
  assert.equal(commonScale(scales.slice(0, 1)).seaLevel, undefined);
});
