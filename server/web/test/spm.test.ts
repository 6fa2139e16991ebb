import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { placesOfLevel } from "../src/partition.ts";
import { DecodeError } from "../src/decode_error.ts";
import { loadModelDecoder, ProgressiveModel } from "../src/progressive_model.ts";

await loadModelDecoder();

const decodeModel = (...file: ConstructorParameters<typeof ProgressiveModel>) => new ProgressiveModel(...file).mesh;

// What was decoded of it when it was written stands beside it.
const GOLDEN = "../../codec/golden/open_torus";
const BYTES = readFileSync(`${GOLDEN}.spm`);

test("the levels of a model in space are those that were recorded, byte for byte", () => {
  const { positions, representatives, corners, levels } = decodeModel(BYTES);
  const ends = Uint32Array.from(levels.flatMap(({ vertexEnd, triangleEnd }) => [vertexEnd, triangleEnd]));
  const bytes = [positions, representatives, corners, ends].map(({ buffer }) => Buffer.from(buffer));
  assert.ok(Buffer.concat(bytes).equals(readFileSync(`${GOLDEN}.arrays`)));
});

/** Triangles in any order, each from the first of its corners, as sorted; coordinates to the last bit. */
const sorted = (triangles: readonly (readonly string[])[]) =>
  triangles.map((corners) => corners.indexOf([...corners].sort()[0]!)).map((at, n) => [...triangles[n]!.slice(at), ...triangles[n]!.slice(0, at)].join(" | ")).sort();

/** The triangles of a PLY file of doubles, as `terrain-ingest mesh` writes them. */
function trianglesOf(bytes: Buffer): string[][] {
  const start = bytes.indexOf("end_header\n") + 11;
  const [vertices, faces] = ["vertex", "face"].map((name) => Number(new RegExp(`element ${name} (\\d+)`).exec(bytes.toString("latin1", 0, start))![1])) as [number, number];
  const place = (vertex: number) => [0, 8, 16].map((offset) => bytes.readDoubleLE(start + 24 * vertex + offset)).join(" ");
  const corner = (face: number, at: number) => bytes.readUInt32LE(start + 24 * vertices + 13 * face + 1 + 4 * at);
  return Array.from({ length: faces }, (_, face) => [0, 1, 2].map((at) => place(corner(face, at))));
}

test("a coarser level has the triangles that Rust extracted, to the last bit", () => {
  const { positions, corners, levels, ...rest } = decodeModel(BYTES);
  const level = levels.length - 1 - 4;
  const places = placesOfLevel({ levels, ...rest }, level);
  const placeOf = (vertex: number) => positions.subarray(3 * places[vertex]!, 3 * places[vertex]! + 3).join(" ");
  const drawn = corners.subarray(0, 3 * levels[level]!.triangleEnd);
  const triangles = Array.from({ length: drawn.length / 3 }, (_, at) => [...drawn.subarray(3 * at, 3 * at + 3)].map(placeOf));
  const ply = readFileSync(`${GOLDEN}_level4.ply`);
  assert.deepEqual(sorted(triangles), sorted(trianglesOf(ply)));
  assert.equal(levels[level]!.error, Number(/distance from the model at most ([\d.e-]+)/.exec(ply.toString("latin1"))![1]));
});

test("errors never grow from level to level, and the finest has all vertices", () => {
  const { levels, representatives, corners } = decodeModel(BYTES);
  assert.ok(levels.every(({ error }, at) => error > 0 && (at === 0 || error <= levels[at - 1]!.error)));
  assert.deepEqual([levels.at(-1)!.vertexEnd, levels.at(-1)!.triangleEnd], [770, 1516]);
  assert.deepEqual([representatives.length, corners.length], [770, 3 * 1516]);
});

test("bytes that are cut, changed or more than the limits are refused, and nothing else is thrown", () => {
  for (const length of [0, 3, 53, 60, 100, BYTES.length - 1]) assert.throws(() => decodeModel(BYTES.subarray(0, length)), DecodeError, `${length} bytes`);
  assert.throws(() => decodeModel(Uint8Array.of(...BYTES, 0)), /after the last level/);
  assert.throws(() => decodeModel(readFileSync("../../codec/golden/small_v3.spt")), /not a progressive mesh file/);
  const limits = { levels: 1024, vertices: 1000, triangles: 2000 };
  assert.equal(decodeModel(BYTES, limits).levels.length, 8);
  for (const [name, limit] of Object.entries({ levels: 7, vertices: 769, triangles: 1515 })) {
    assert.throws(() => decodeModel(BYTES, { ...limits, [name]: limit }), DecodeError, name);
  }
  let refused = 0;
  for (let at = 0; at < BYTES.length; at += 3) {
    const bytes = Uint8Array.from(BYTES);
    bytes[at] = bytes[at]! ^ (1 << (at % 8));
    try {
      new ProgressiveModel(bytes).refine({ eye: [0, 0, 0], frustum: [], focalLength: 1000, within: 1 });
    } catch (error) {
      assert.ok(error instanceof DecodeError && error.message !== "unreachable", String(error));
      refused++;
    }
  }
  assert.ok(refused > 1000, `${refused} of ${Math.ceil(BYTES.length / 3)} were refused`);
});
