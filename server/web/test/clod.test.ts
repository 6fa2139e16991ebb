import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { CURVES, patchesOf, readCurvedLevels } from "../src/curved/clod.ts";
import { factor, Factors } from "../src/curved/factors.ts";

// A torus around z, radii 3 and 1, of 576 triangles; written by the program.
const FILE = readFileSync("test/torus.clod");
const bytes = FILE.buffer.slice(FILE.byteOffset, FILE.byteOffset + FILE.byteLength) as ArrayBuffer;
const levels = readCurvedLevels(bytes);

/** A patch's control points, in the model's units. */
const pointsOf = (patch: number) =>
  Array.from({ length: 10 }, (_, point) =>
    levels.origin.map((origin, axis) => origin + levels.points[30 * patch + 3 * point + axis]!),
  );

test("corners of every level are on the torus", () => {
  assert.equal(patchesOf(levels, 0).patches.length, 576);
  const last = patchesOf(levels, levels.levelCount - 1);
  assert.ok(last.patches.length < 200 && last.error > patchesOf(levels, 1).error, `${last.patches.length}`);
  for (const patch of [...patchesOf(levels, 0).patches, ...last.patches]) {
    for (const corner of [0, 6, 9]) {
      const [x, y, z] = pointsOf(patch)[corner]! as [number, number, number];
      assert.ok(Math.abs(Math.hypot(Math.hypot(x, y) - 3, z) - 1) < 1e-4);
    }
  }
});

test("each curve of a level belongs to two patches, with the same points", () => {
  for (const level of [0, levels.levelCount - 1]) {
    const seen = new Map<number, number[][]>();
    for (const patch of patchesOf(levels, level).patches) {
      for (const [curve, four] of CURVES.entries()) {
        const use = levels.curves[3 * patch + curve]!;
        const points = four.map((point) => pointsOf(patch)[point]!);
        if (use % 2 === 1) points.reverse();
        const other = seen.get(Math.floor(use / 2));
        if (other === undefined) seen.set(Math.floor(use / 2), points);
        else assert.deepEqual(points, other);
        if (other !== undefined) seen.set(Math.floor(use / 2), []);
      }
    }
    assert.ok([...seen.values()].every((points) => points.length === 0), "a closed surface");
  }
});

test("a factor is the same from both patches, and grows as the eye comes near", () => {
  const { patches } = patchesOf(levels, levels.levelCount - 1);
  const factors = new Factors(levels);
  const finest = (distance: number) => {
    const eye = levels.origin.map((origin) => -origin + distance / Math.sqrt(3)) as [number, number, number];
    const sight = { eye, pixels: 800, maxPixels: 0.5 };
    const sorted = factors.sorted(patches, sight);
    for (const [patch, curve] of [...patches].flatMap((patch) => [0, 1, 2].map((curve) => [patch, curve] as const))) {
      const four = CURVES[curve]!.map((point) => 30 * patch + 3 * point);
      if (levels.curves[3 * patch + curve]! % 2 === 1) four.reverse();
      assert.equal(factors.ofCurves[3 * patch + curve], factor(levels.points, four, sight));
    }
    return Math.max(...sorted.keys());
  };
  assert.ok(finest(10) >= 4 * finest(1000), `${finest(10)} ${finest(1000)}`);
});

test("what is no file of curved levels is refused in a sentence", () => {
  assert.throws(() => readCurvedLevels(new ArrayBuffer(8)), /no \.clod file/);
  for (const length of [5, 30, 200, bytes.byteLength - 1]) {
    assert.throws(() => readCurvedLevels(bytes.slice(0, length)), Error);
  }
});
