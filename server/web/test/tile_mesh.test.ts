// A tile's mesh without a graphics card: what rays find of it.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Frame } from "../src/frame.ts";
import { COARSEST_DETAIL } from "../src/partition.ts";
import { placed } from "../src/spots.ts";
import { TileMesh, type SharedUniforms } from "../src/tile_mesh.ts";
import { PYRAMID } from "./flat_earth.ts";
import { gridTile } from "./grid_pyramid.ts";

test("while a tile moves to a surface below its own places, its box holds both", () => {
  const address = { zoom: 3, x: 9, y: 4 };
  const frame = new Frame(30, 10);
  const tile = placed(gridTile(PYRAMID, address), frame);
  const mesh = new TileMesh(tile, { filled: undefined, water: undefined }, frame, {} as SharedUniforms);
  const { representatives } = tile.tile;
  const from = tile.spots.slice(0, representatives.length);
  const to = from.map(({ longitude, latitude, height }) => {
    const lower = height - 100_000;
    return { longitude, latitude, height: lower, position: frame.position(longitude, latitude, lower), own: undefined };
  });
  const shown = { address, ...COARSEST_DETAIL };
  const isHeld = () => [from, to].map((spots) => spots.every(({ position }) => mesh.box.containsPoint(position)));
  assert.deepEqual(isHeld(), [true, false]);
  mesh.move({ address, from, to, before: shown, after: shown });
  assert.deepEqual(isHeld(), [true, true]);
  mesh.show(COARSEST_DETAIL);
  assert.deepEqual(isHeld(), [true, false]);
});
