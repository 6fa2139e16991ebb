import assert from "node:assert/strict";
import { test } from "node:test";
import { along, area, csvOf, geoJsonOf, lengths, type ProfilePoint } from "../src/path.ts";

const JFK = { longitude: -73.8, latitude: 40.6 };
const HEATHROW = { longitude: -0.5, latitude: 51.6 };

test("lengths are geodesics on WGS84", () => {
  // GeographicLib's own example.
  assert.ok(Math.abs(lengths([JFK, HEATHROW])[0]! - 5551759.4) < 0.001);
  assert.deepEqual(lengths([JFK]), []);
});

test("a degree at the equator has the area that an integral over the ellipsoid has, whichever way round", () => {
  const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([longitude = 0, latitude = 0]) => ({ longitude, latitude }));
  // The authalic integral of a degree square, less the sliver that its northern geodesic cuts off or adds: below 0.01 %.
  assert.ok(Math.abs(area(corners) / 12308.778e6 - 1) < 1e-4, String(area(corners)));
  assert.equal(area(corners), area([...corners].reverse()));
});

test("places along a path begin and end at its ends, hold its corners, and go over the antimeridian", () => {
  const corners = [{ longitude: 179, latitude: 10 }, { longitude: -179, latitude: 10 }, { longitude: -179, latitude: 11 }];
  const places = along(corners, 100);
  const [first, second] = lengths(corners) as [number, number];
  assert.ok(Math.abs(places.at(-1)!.distance - first - second) < 1e-6);
  assert.ok(places.some(({ distance, longitude }) => Math.abs(distance - first) < 1e-6 && Math.abs(longitude + 179) < 1e-9));
  assert.ok(places.every(({ longitude }) => Math.abs(longitude) >= 179 - 1e-9));
  const steps = places.slice(1).map(({ distance }, at) => distance - places[at]!.distance);
  assert.ok(Math.max(...steps) < 1.05 * Math.min(...steps), "steps are about equal");
});

test("files tell what is known, errors rounded up, and leave out what is not", () => {
  const profile: ProfilePoint[] = [
    { distance: 0, longitude: 7, latitude: 46, height: 812.346, error: 1.231 },
    { distance: 10, longitude: 7.1, latitude: 46, height: undefined, error: undefined },
    { distance: 20, longitude: 7.2, latitude: 46, height: 0, error: 0.5 },
  ];
  const rows = csvOf(profile).split("\r\n");
  assert.deepEqual(rows.slice(1, 4), ["0.00,7.0000000,46.0000000,812.35,1.24,measured", "10.00,7.1000000,46.0000000,,,void", "20.00,7.2000000,46.0000000,0.00,0.50,measured"]);
  const filled = csvOf([{ ...profile[0]!, error: undefined }]).split("\r\n");
  assert.equal(filled[1], "0.00,7.0000000,46.0000000,812.35,,filled");
  const { features } = JSON.parse(geoJsonOf(profile, [JFK, HEATHROW], "the sea"));
  assert.deepEqual(features[0].geometry.coordinates, [[7, 46, 812.35], [7.2, 46, 0]]);
  assert.deepEqual(features[0].properties, { length_m: 20, heights_above: "the sea", certified_errors_m: [1.24, 0.5] });
});
