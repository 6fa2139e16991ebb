// The recorded cases of the selection, which Rust answers alike.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Vector3 } from "three";
import { keyOf, type Address } from "../src/address.ts";
import type { OrientedBox } from "../src/oriented_box.ts";
import { select, type Choice, type Hierarchy, type Level } from "../src/select.ts";

type Triple = [number, number, number];
type Tile = { tile: Triple; centre: Triple; axes: [Triple, Triple, Triple]; half_sizes: Triple; levels: Triple[] };
/** Zoom, column, row, level, and the fine sides as bits, the west side the lowest. */
type RecordedChoice = [number, number, number, number, number];
interface Case {
  pyramid: number;
  eye: Triple;
  frustum: [number, number, number, number][];
  pixels_per_radian: number;
  farthest: number | null;
  ground: { centre: Triple; axis: Triple; equatorial: number; polar: number } | null;
  tolerance: number;
  keep: number;
  triangles: number;
  bytes: number;
  loaded: Triple[] | null;
  before: RecordedChoice[];
  answer: { choices: RecordedChoice[]; requests: Triple[]; tolerance: number | null };
}

const { pyramids, cases } = JSON.parse(readFileSync("../../tests/selection/cases.json", "utf8")) as {
  pyramids: Tile[][];
  cases: Case[];
};
const HIERARCHIES = pyramids.map(hierarchyOf);

/** In which all tiles are loaded. */
function hierarchyOf(tiles: readonly Tile[]): Hierarchy {
  const known = new Map(tiles.map((tile) => [tile.tile.join("/"), { box: boxOf(tile), levels: tile.levels.map(levelOf) }]));
  return {
    roots: tiles.map(({ tile }) => addressOf(tile)).filter(({ zoom }) => zoom === 0),
    exists: (address) => known.has(keyOf(address)),
    bounds: (address) => known.get(keyOf(address))!.box,
    levels: (address) => known.get(keyOf(address))!.levels,
    levelsThere: () => Infinity,
  };
}

function boxOf({ centre, axes, half_sizes }: Tile): OrientedBox {
  const [x, y, z] = axes;
  return { centre: vector(centre), axes: [vector(x), vector(y), vector(z)], halfSizes: half_sizes };
}

function levelOf([error, triangles, bytes]: Triple): Level {
  return { error, triangles, bytes };
}

function vector(numbers: Triple): Vector3 {
  return new Vector3(...numbers);
}

function addressOf([zoom, x, y]: readonly number[]): Address {
  return { zoom: zoom!, x: x!, y: y! };
}

function choiceOf(recorded: RecordedChoice): Choice {
  const [, , , interior, sides] = recorded;
  return { address: addressOf(recorded), interior, fineSides: [0, 1, 2, 3].map((side) => ((sides >> side) & 1) === 1), error: 0 };
}

function recordOf({ address: { zoom, x, y }, interior, fineSides }: Choice): RecordedChoice {
  return [zoom, x, y, interior, fineSides.reduce((bits, isFine, side) => bits + (isFine ? 2 ** side : 0), 0)];
}

function answerTo({ pyramid, eye, frustum, pixels_per_radian, farthest, ground, loaded, before, ...demand }: Case) {
  const keys = loaded && new Set(loaded.map((tile) => tile.join("/")));
  const camera = {
    eye: vector(eye),
    frustum: frustum.map(([x, y, z, constant]) => ({ normal: new Vector3(x, y, z), constant })),
    pixelsPerRadian: pixels_per_radian,
    farthest: farthest ?? Infinity,
    ground: ground === null ? undefined : { ...ground, centre: vector(ground.centre), axis: vector(ground.axis) },
  };
  const levelsThere = (address: Address) => (keys === null || keys.has(keyOf(address)) ? Infinity : 0);
  const { choices, requests, tolerance } = select({ ...HIERARCHIES[pyramid]!, levelsThere }, camera, demand, before.map(choiceOf));
  return {
    choices: choices.map(recordOf),
    requests: requests.map(({ address: { zoom, x, y } }) => [zoom, x, y]),
    tolerance: Number.isFinite(tolerance) ? tolerance : null,
  };
}

test("recorded cases are answered as in Rust", () => {
  assert.ok(cases.length >= 300);
  cases.forEach((recorded, index) => assert.deepEqual(answerTo(recorded), recorded.answer, `case ${index}`));
});
