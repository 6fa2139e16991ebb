import assert from "node:assert/strict";
import { test } from "node:test";
import { commonScale, DataHeights } from "../src/colour_scale.ts";
import type { Metadata } from "../src/tileset.ts";

interface Archive {
  readonly heights: [number, number];
  /** Of the coarsest surface, metres. */
  readonly error: number;
  readonly datum?: string;
  readonly local?: boolean;
}

function dataHeights({ heights, error, datum = "EGM96", local = false }: Archive): DataHeights {
  const zoom = { zoom: 0, tiles: 1, triangles: 2, finest_error: 1, coarsest_error: error, available: [] };
  const metadata: Metadata = {
    format: "", scheme: "", bounds: [0, 0, 1, 1], heights, max_zoom: 0, zooms: [zoom], asked: { reading: { local } }, source: { heights_above: datum },
  };
  return new DataHeights(metadata);
}

const seaLevelOf = (archive: Archive) => dataHeights(archive).scale.seaLevel;

test("land below the sea is land: no height alone makes water of it", () => {
  assert.equal(seaLevelOf({ heights: [-86, 3368], error: 2100 }), undefined, "Death Valley");
  assert.equal(seaLevelOf({ heights: [-432, 1020], error: 10 }), undefined, "the Dead Sea's shore");
  assert.equal(seaLevelOf({ heights: [-732, 1020], error: 2 }), undefined, "the Dead Sea with its bed: its shore is at −430 m");
  assert.equal(seaLevelOf({ heights: [-7, 320], error: 100 }), undefined, "the Netherlands");
  assert.equal(seaLevelOf({ heights: [-30, 80], error: 20, datum: "WGS 84 ellipsoid" }), undefined, "a coast where the geoid is below the ellipsoid");
  assert.equal(seaLevelOf({ heights: [-1076, 2544], error: 2056 }), undefined, "a coarse surface hangs below the Alps");
  assert.equal(seaLevelOf({ heights: [-8000, 9000], error: 10, local: true }), undefined, "the Moon has no sea");
});

test("where data surely go deeper than any land, all below the sea level is sea", () => {
  assert.equal(seaLevelOf({ heights: [-8642, 6706], error: 3468 }), 0);
  assert.equal(seaLevelOf({ heights: [-5000, -3000], error: 4900 }), 0, "all of it is below the lowest land");
});

test("above the ellipsoid, sea is only what is below the geoid wherever it is", () => {
  assert.equal(seaLevelOf({ heights: [-8642, 6706], error: 3468, datum: "WGS 84 ellipsoid" }), -107);
});

test("the scale narrows to the data as tiles tell them, and a sea is known then", () => {
  const alps = dataHeights({ heights: [-698, 2838], error: 2145 });
  assert.deepEqual(alps.scale.ends, [-698, 2838]);
  alps.learn([{ lowest: -40, highest: 900, error: 160 }, { lowest: 300, highest: 2600, error: 20 }]);
  assert.deepEqual(alps.scale.ends, [-40, 2600]);
  const mediterranean = dataHeights({ heights: [-5200, 4700], error: 4800 });
  assert.equal(mediterranean.scale.seaLevel, undefined);
  mediterranean.learn([{ lowest: -4900, highest: 4400, error: 300 }]);
  assert.equal(mediterranean.scale.seaLevel, 0);
});

test("the first picture tells more than coarse surfaces, however coarse it is", () => {
  const earth = dataHeights({ heights: [-11_000, 14_568], error: 7500 });
  earth.learn([{ lowest: -9000, highest: 9000, error: 5000 }]);
  assert.deepEqual(earth.scale, { ends: [-9000, 9000], seaLevel: 0 });
  const hill = dataHeights({ heights: [-500, 2000], error: 1000 });
  hill.learn([{ lowest: 700, highest: 800, error: 1000 }]);
  assert.deepEqual(hill.scale.ends, [500, 1000], "as far as it may be by what the archive says");
});

test("coarser pictures leave the scale as it is, and slightly finer ones, too", () => {
  const heights = dataHeights({ heights: [-698, 2838], error: 2145 });
  heights.learn([{ lowest: 0, highest: 2600, error: 100 }]);
  heights.learn([{ lowest: -300, highest: 2300, error: 400 }]);
  heights.learn([{ lowest: 10, highest: 2580, error: 60 }]);
  assert.deepEqual(heights.scale.ends, [0, 2600]);
  heights.learn([{ lowest: 12, highest: 2612, error: 5 }]);
  assert.deepEqual(heights.scale.ends, [12, 2612]);
});

test("one scale serves several archives", () => {
  const scales = [{ ends: [200, 1100], seaLevel: undefined }, { ends: [-4000, 900], seaLevel: 0 }] as const;
  assert.deepEqual(commonScale(scales), { ends: [-4000, 1100], seaLevel: 0 });
  assert.equal(commonScale(scales.slice(0, 1)).seaLevel, undefined);
});
