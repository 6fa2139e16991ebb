import assert from "node:assert/strict";
import { test } from "node:test";
import { EARTH } from "../src/earth.ts";
import { PLANE_METRES } from "../src/local_ground.ts";
import { linkOf, readLink } from "../src/share.ts";
import { along, csvOf, geoJsonOf, lengthOf, type ProfilePoint } from "../src/path.ts";

const JFK = { longitude: -73.8, latitude: 40.6 };
const HEATHROW = { longitude: -0.5, latitude: 51.6 };

test("lengths are geodesics on WGS84", () => {
  // GeographicLib's own example.
  assert.ok(Math.abs(lengthOf([JFK, HEATHROW], EARTH) - 5551759.4) < 0.001);
  assert.equal(lengthOf([JFK], EARTH), 0);
});

test("a degree at the equator has the area that an integral over the ellipsoid has, whichever way round", () => {
  const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([longitude = 0, latitude = 0]) => ({ longitude, latitude }));
  // The authalic integral of a degree square, less the sliver that its northern geodesic cuts off or adds: below 0.01 %.
  assert.ok(Math.abs(EARTH.area(corners) / 12308.778e6 - 1) < 1e-4, String(EARTH.area(corners)));
  assert.equal(EARTH.area(corners), EARTH.area([...corners].reverse()));
});

test("places along a path begin and end at its ends, hold its corners, and go over the antimeridian", () => {
  const corners = [{ longitude: 179, latitude: 10 }, { longitude: -179, latitude: 10 }, { longitude: -179, latitude: 11 }];
  const places = along(corners, 100, EARTH);
  const [first, second] = [lengthOf(corners.slice(0, 2), EARTH), lengthOf(corners.slice(1), EARTH)];
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
  const rows = csvOf(profile, EARTH).split("\r\n");
  assert.deepEqual(rows.slice(1, 4), ["0.00,7.0000000,46.0000000,812.35,1.24,measured", "10.00,7.1000000,46.0000000,,,void", "20.00,7.2000000,46.0000000,0.00,0.50,measured"]);
  const filled = csvOf([{ ...profile[0]!, error: undefined }], EARTH).split("\r\n");
  assert.equal(filled[1], "0.00,7.0000000,46.0000000,812.35,,filled");
  const { features } = JSON.parse(geoJsonOf(profile, [JFK, HEATHROW], "the sea", EARTH));
  assert.deepEqual(features[0].geometry.coordinates, [[7, 46, 812.35], [7.2, 46, 0]]);
  assert.deepEqual(features[0].properties, { length_m: 20, heights_above: "the sea", certified_errors_m: [1.24, 0.5] });
});

test("of ground that is nowhere on the Earth, places, lengths, areas and files are in metres of its plane", () => {
  const corners = [[0, 0], [3000, 4000], [0, 4000]].map(([x = 0, y = 0]) => PLANE_METRES.placeOf([x, y]));
  const [x, y] = PLANE_METRES.numbersOf(corners[1]!);
  assert.ok(Math.hypot(x - 3000, y - 4000) < 1e-6, `${x}, ${y}`);
  // A degree of longitude at the equator is 111,319.49 m of the ellipsoid.
  assert.ok(Math.abs(corners[1]!.longitude - 3000 / 111319.49) < 1e-7, String(corners[1]!.longitude));
  assert.ok(Math.abs(lengthOf(corners, PLANE_METRES) - 8000) < 1e-6);
  assert.ok(Math.abs(PLANE_METRES.area(corners) - 6e6) < 1e-3);
  const profile = along(corners, 8, PLANE_METRES).map((place) => ({ ...place, height: 1, error: 0.5 }));
  const rows = csvOf(profile, PLANE_METRES).split("\r\n");
  assert.equal(rows[0], "distance_m,x_m,y_m,height_m,certified_error_m,status");
  assert.match(rows[6]!, /^5000.00,3000.000,4000.000,1.00,0.50,measured$/);
  assert.deepEqual(JSON.parse(geoJsonOf(profile, corners, "", PLANE_METRES)).features[0].properties.coordinates, "metres on a plane");
});

test("a link to ground that is nowhere on the Earth is in metres, too", () => {
  const { longitude, latitude } = PLANE_METRES.placeOf([18000, 200000]);
  const pose = { longitude, latitude, height: 5000, azimuth: 10, down: 30, roll: -1.5 };
  const link = linkOf("a game", pose, true);
  assert.equal(link, "#a%20game/18000.00,200000.00,5000.00,10.00,30.00,-1.50,m");
  const back = readLink(link)!;
  assert.equal(back.name, "a game");
  for (const part of ["longitude", "latitude", "height", "azimuth", "down", "roll"] as const) assert.ok(Math.abs(back.pose![part]! - pose[part]) < 1e-6, part);
  assert.deepEqual(readLink("#alps/46.5,7.25,3000,0,45")!.pose, { longitude: 7.25, latitude: 46.5, height: 3000, azimuth: 0, down: 45 });
});

test("a link that only names an archive, or has a pose that is none, says its name", () => {
  for (const hash of ["#alps", "#alps/", "#alps/95,7.25,3000,0,45", "#alps/1,2,3", "#alps/here"]) {
    assert.deepEqual(readLink(hash), { name: "alps", pose: undefined }, hash);
  }
  assert.equal(readLink("#100%")!.name, "100%");
  for (const hash of ["", "#", "#/46.5,7.25,3000,0,45"]) assert.equal(readLink(hash), undefined, hash);
});
