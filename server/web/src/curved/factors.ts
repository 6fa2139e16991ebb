// Into how many chords each curve is cut, as seen from the camera.

import { CURVES, type CurvedLevels } from "./clod.ts";

/** Factors are powers of two up to this one. */
export const MOST = 64;

/** What the camera sees: its place in the model's frame, and how many pixels one unit across is at distance one. */
export interface Sight {
  readonly eye: readonly [number, number, number];
  readonly pixels: number;
  readonly maxPixels: number;
}

/**
 * The least power of two with which a curve's chords are within `maxPixels` of it: a cubic of which control points bend by `bend`
 * is no farther than 3/4 · bend / n² from n chords. A function of the curve alone, so that both of its patches are told the same.
 */
export function factor(points: Float32Array, four: readonly number[], sight: Sight): number {
  let [bend, nearest] = [0, Infinity];
  for (const [place, point] of four.entries()) {
    let [second, distance] = [0, 0];
    for (let axis = 0; axis < 3; axis++) {
      const at = points[point + axis]!;
      distance += (at - sight.eye[axis]!) ** 2;
      if (place < 2) second += (at - 2 * points[four[place + 1]! + axis]! + points[four[place + 2]! + axis]!) ** 2;
    }
    bend = Math.max(bend, second);
    nearest = Math.min(nearest, distance);
  }
  const wanted = Math.sqrt((0.75 * Math.sqrt(bend) * sight.pixels) / (sight.maxPixels * Math.sqrt(Math.max(nearest, 1e-12))));
  return Math.min(2 ** Math.max(0, Math.ceil(Math.log2(wanted))), MOST);
}

/** For each patch its finest factor, and those of its curves; a curve is looked at once. */
export class Factors {
  private readonly known: Uint8Array;
  readonly ofCurves: Uint8Array;

  constructor(private readonly levels: CurvedLevels) {
    this.known = new Uint8Array(levels.curveCount);
    this.ofCurves = new Uint8Array(3 * levels.patchCount);
  }

  /** Patches by their finest factor. */
  sorted(patches: Uint32Array, sight: Sight): Map<number, number[]> {
    this.known.fill(0);
    const byFactor = new Map<number, number[]>();
    for (const patch of patches) {
      const finest = Math.max(this.inside(patch, sight), ...CURVES.map((_, curve) => this.ofCurve(patch, curve, sight)));
      const same = byFactor.get(finest);
      if (same === undefined) byFactor.set(finest, [patch]);
      else same.push(patch);
    }
    return byFactor;
  }

  private ofCurve(patch: number, curve: number, sight: Sight): number {
    const use = this.levels.curves[3 * patch + curve]!;
    const number = Math.floor(use / 2);
    if (this.known[number] === 0) {
      const four = CURVES[curve]!.map((point) => 30 * patch + 3 * point);
      if (use % 2 === 1) four.reverse();
      this.known[number] = factor(this.levels.points, four, sight);
    }
    this.ofCurves[3 * patch + curve] = this.known[number]!;
    return this.known[number]!;
  }

  /** That of the lines through a patch's centre from one curve to another. */
  private inside(patch: number, sight: Sight): number {
    const rows = [
      [1, 4, 8],
      [2, 4, 7],
      [3, 4, 5],
    ];
    const lines = rows.map((row) => row.map((point) => 30 * patch + 3 * point));
    return Math.max(...lines.map(([a, b, c]) => factor(this.levels.points, [a!, b!, c!, c!], sight)));
  }
}
