import assert from "node:assert/strict";
import { test } from "node:test";
import { wayTo } from "../src/elsewhere.ts";

const VANCOUVER = [-124, 49, -123, 50] as const;

test("the way to data is told by the distance to their middle, and the direction in which it begins", () => {
  // The great circle on a sphere of 6,371 km is 3,471 km long and begins at 307 degrees; the Earth is no more than 0.6 % off that.
  const [, number, direction] = /^([\d,]+) km to the (.*)$/.exec(wayTo(VANCOUVER, { longitude: -84.2, latitude: 36.3 }))!;
  assert.ok(Math.abs(Number(number!.replace(",", "")) / 3471 - 1) < 0.006, number);
  assert.equal(direction, "north-west");
  assert.equal(wayTo(VANCOUVER, { longitude: -123.5, latitude: 50.05 }), "61 km to the south");
  assert.equal(wayTo(VANCOUVER, { longitude: -125, latitude: 49.5 }), "109 km to the east");
});

test("from above data they are below, also across the antimeridian", () => {
  assert.equal(wayTo(VANCOUVER, { longitude: -123.5, latitude: 49.5 }), "straight below");
  assert.equal(wayTo([178, -20, 182, -15], { longitude: -179, latitude: -17 }), "straight below");
  assert.match(wayTo([178, -20, 182, -15], { longitude: -177, latitude: -17.5 }), /^\d+ km to the west$/);
});
