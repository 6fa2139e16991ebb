import assert from "node:assert/strict";
import { test } from "node:test";
import { keyOf } from "../src/address.ts";
import { squareForLight } from "../src/normals.ts";

test("light comes from a square above as long as a cell of its raster covers two pixels at most", () => {
  const tile = { zoom: 5, x: 11, y: 7 };
  const of = (pixels: number) => keyOf(squareForLight(tile, pixels));
  assert.equal(of(2000), "5/11/7");
  assert.equal(of(257), "5/11/7", "the parent's would cover 2.01 pixels");
  assert.equal(of(256), "4/5/3");
  assert.equal(of(65), "3/2/1");
  assert.equal(of(64), "2/1/0");
  assert.equal(of(0), "0/0/0", "nothing is above a root");
});
