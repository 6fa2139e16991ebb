import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { placesOfLevel } from "../src/partition.ts";
import { loadModelDecoder, ProgressiveModel, type ModelView, type Redrawn } from "../src/progressive_model.ts";

await loadModelDecoder();

const BYTES = readFileSync("../../codec/golden/open_torus.spm");
const FAR: ModelView = { eye: [1e9, 0, 0], frustum: [], focalLength: 1000, within: 1 };

/** What a page draws that writes only what it is told to. */
class Drawing {
  readonly positions = new Map<number, string>();
  readonly corners: number[][] = [];

  patch({ triangles, places, corners, vertices, positions }: Redrawn): void {
    vertices.forEach((vertex, at) => this.positions.set(vertex, positions.subarray(3 * at, 3 * at + 3).join(" ")));
    places.forEach((place, at) => (this.corners[place] = [...corners.subarray(3 * at, 3 * at + 3)]));
    this.corners.length = triangles;
  }

  /** Corners as places, each triangle from its first one as sorted. */
  triangles(): string[] {
    return this.corners.map((corners) => fromFirst(corners.map((corner) => this.positions.get(corner)!))).sort();
  }

  /** Edges that have no triangle on the other side. */
  openEdges(): number {
    const edges = this.corners.flatMap(([a, b, c]) => [[a, b], [b, c], [c, a]]);
    const there = new Set(edges.map((edge) => edge.join()));
    assert.equal(there.size, edges.length, "no edge is used twice the same way");
    return edges.filter(([a, b]) => !there.has([b, a].join())).length;
  }
}

function fromFirst(corners: string[]): string {
  const at = corners.indexOf([...corners].sort()[0]!);
  return [...corners.slice(at), ...corners.slice(0, at)].join(" | ");
}

function levelOf({ mesh }: ProgressiveModel, level: number): string[] {
  const places = placesOfLevel(mesh, level);
  const placeOf = (corner: number) => mesh.positions.subarray(3 * places[corner]!, 3 * places[corner]! + 3).join(" ");
  const corners = [...mesh.corners.subarray(0, 3 * mesh.levels[level]!.triangleEnd)].map(placeOf);
  return Array.from({ length: corners.length / 3 }, (_, at) => fromFirst(corners.slice(3 * at, 3 * at + 3))).sort();
}

test("from afar the coarsest level is drawn, with no tolerance the finest, and from afar the coarsest again", () => {
  const model = new ProgressiveModel(BYTES);
  const drawing = new Drawing();
  const last = model.mesh.levels.length - 1;
  for (const [within, level] of [[1, 0], [0, last], [1, 0]] as const) {
    drawing.patch(model.refine({ ...FAR, within }));
    assert.deepEqual(drawing.triangles(), levelOf(model, level));
  }
});

test("from near the near side is fine, and every picture on the way is a surface without cracks", () => {
  const model = new ProgressiveModel(BYTES);
  const drawing = new Drawing();
  const { positions, levels, representatives } = model.mesh;
  const [minimum, maximum] = [Math.min, Math.max].map((end) => end(...positions.filter((_, at) => at % 3 === 0 && at < 3 * representatives.length)));
  const size = maximum! - minimum!;
  const open: number[] = [];
  let largest = 0;
  for (let step = 0; step <= 40; step++) {
    const focalLength = (0.05 * size) / levels[3]!.error;
    const { changes, places, triangles } = redrawn(model.refine({ eye: [maximum! + size * (1 - step / 40), 0, 0], frustum: [], focalLength, within: 1 }));
    assert.ok(step === 0 || changes > 0 || places.length === 0, "where nothing is split, nothing is drawn anew");
    open.push(drawing.openEdges());
    largest = Math.max(largest, triangles);
  }
  function redrawn(change: Redrawn): Redrawn {
    drawing.patch(change);
    return change;
  }
  assert.ok(open.every((edges) => edges > 0 && edges < 100), "the torus is open at its two ends alone");
  assert.ok(largest > 3 * levels[0]!.triangleEnd && largest < levels.at(-1)!.triangleEnd, `${largest} triangles`);
  const sides = drawing.corners.map(([corner]) => Number(drawing.positions.get(corner!)!.split(" ")[0]) > (minimum! + maximum!) / 2);
  const near = sides.filter((isNear) => isNear).length;
  assert.ok(near > 1.5 * (sides.length - near), `${near} of ${sides.length} triangles on the near half`);
});

test("what is beside the picture is not refined", () => {
  const model = new ProgressiveModel(BYTES);
  const view = { ...FAR, eye: [0, 0, 0], within: 1e-9 } as const;
  const all = model.refine(view).triangles;
  const half = model.refine({ ...view, frustum: [1, 0, 0, 0] }).triangles;
  const none = model.refine({ ...view, frustum: [1, 0, 0, -1e9] }).triangles;
  assert.ok(none === model.mesh.levels[0]!.triangleEnd && half > none && half < all, `${all}, ${half}, ${none}`);
});
