import assert from "node:assert/strict";
import { test } from "node:test";
import { Ray, Vector3 } from "three";
import { firstHit, type DrawnSurface } from "../src/ground.ts";

/** Two triangles over the square from 0 to 10, as high as they tell: 2 x + y; the second hangs 100 m below the first's plane. */
const SURFACE: DrawnSurface = {
  corners: Uint32Array.of(0, 1, 2, 3, 4, 5),
  texels: Float32Array.of(0, 0, 0, 0, 10, 0, 20, 20, 10, 10, 30, 30, 0, 0, -100, -100, 10, 10, -70, -70, 0, 10, -90, -90),
  places: Uint32Array.of(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5),
  vertexCount: 6,
  triangleCount: 2,
};
const asItIs = (place: Vector3) => place;
const down = (x: number, y: number) => new Ray(new Vector3(x, y, 500), new Vector3(0, 0, -1));

test("a ray meets the first triangle on its way, at its height there", () => {
  const met = firstHit(down(6, 3), SURFACE, asItIs, Infinity, 0)!;
  assert.ok(Math.abs(met.height - 15) < 1e-9 && Math.abs(met.distance - 485) < 1e-9, JSON.stringify(met));
  const below = firstHit(down(3, 6), SURFACE, asItIs, Infinity, 0)!;
  assert.ok(Math.abs(below.height + 88) < 1e-9 && Math.abs(below.distance - 588) < 1e-9, JSON.stringify(below));
  const slanted = firstHit(new Ray(new Vector3(-100, 3, 14), new Vector3(1, 0, 0)), SURFACE, asItIs, Infinity, 0)!;
  assert.ok(Math.abs(slanted.height - 14) < 1e-9 && Math.abs(slanted.distance - 105.5) < 1e-9, JSON.stringify(slanted));
});

test("what is behind, beside, too far or not drawn is not met", () => {
  assert.equal(firstHit(new Ray(new Vector3(6, 3, -500), new Vector3(0, 0, -1)), SURFACE, asItIs, Infinity, 0), undefined);
  assert.equal(firstHit(down(11, 3), SURFACE, asItIs, Infinity, 0), undefined);
  assert.equal(firstHit(down(6, 3), SURFACE, asItIs, 485, 0), undefined);
  assert.equal(firstHit(down(3, 6), { ...SURFACE, triangleCount: 1 }, asItIs, Infinity, 0), undefined);
});

test("a place that is raised is met higher, and still told as high as it is", () => {
  const raise = (place: Vector3, height: number) => place.setZ(place.z + 2 * height);
  const met = firstHit(down(6, 3), SURFACE, raise, Infinity, 0)!;
  assert.ok(Math.abs(met.height - 15) < 1e-9 && Math.abs(met.distance - 455) < 1e-9, JSON.stringify(met));
});

test("a ray just beside a triangle meets it only where that has some slack", () => {
  assert.equal(firstHit(down(10.0005, 3), SURFACE, asItIs, Infinity, 0), undefined);
  const met = firstHit(down(10.0005, 3), SURFACE, asItIs, Infinity, 1e-4)!;
  assert.ok(Math.abs(met.height - 23.001) < 1e-9, JSON.stringify(met));
  assert.equal(firstHit(down(10.002, 3), SURFACE, asItIs, Infinity, 1e-4), undefined);
  const first = { ...SURFACE, triangleCount: 1 };
  for (const ray of [down(5, -0.0005), down(5, 5.0005)]) {
    assert.equal(firstHit(ray, first, asItIs, Infinity, 0), undefined);
    assert.ok(firstHit(ray, first, asItIs, Infinity, 1e-4) !== undefined);
  }
});

test("of many triangles a ray meets the one that looking at each of them finds, raised or not", () => {
  const side = 12;
  const noise = (seed: number) => Math.abs(Math.sin(seed * 127.1) * 43758.5453) % 1;
  const vertices = Array.from({ length: side * side }, (_, at) => [at % side, Math.floor(at / side), 3 * noise(at)] as const);
  const cells = vertices.flatMap((_, at) => (at % side < side - 1 && at < side * (side - 1) ? [at] : []));
  const surface: DrawnSurface = {
    corners: Uint32Array.from(cells.flatMap((at) => [at, at + 1, at + side, at + 1, at + side + 1, at + side])),
    texels: Float32Array.from(vertices.flatMap(([x, y, z]) => [x, y, z, z])),
    places: Uint32Array.from(vertices.flatMap((_, at) => [at, at])),
    vertexCount: vertices.length,
    triangleCount: 2 * cells.length,
  };
  let met = 0;
  for (let turn = 0; turn < 600; turn++) {
    const raise = (place: Vector3, height: number) => place.setZ(place.z + (turn % 2) * height);
    const origin = new Vector3(side * noise(turn + 0.1), side * noise(turn + 0.2), turn % 3 === 0 ? 2 : 20);
    const to = new Vector3(side * noise(turn + 0.3), side * noise(turn + 0.4), turn % 5 === 0 ? 2 : 0);
    const ray = new Ray(origin, to.sub(origin).normalize());
    const corner = (at: number) => raise(new Vector3().fromArray(surface.texels, 4 * surface.corners[at]!), surface.texels[4 * surface.corners[at]! + 3]!);
    const distances = cells.flatMap((_, cell) => [6 * cell, 6 * cell + 3]).flatMap((at) => {
      const place = ray.intersectTriangle(corner(at), corner(at + 1), corner(at + 2), false, new Vector3());
      return place === null ? [] : [place.distanceTo(origin)];
    });
    const found = firstHit(ray, surface, raise, Infinity, 0);
    assert.equal(found !== undefined, distances.length > 0, `ray ${turn}`);
    if (found !== undefined) assert.ok(Math.abs(found.distance - Math.min(...distances)) < 1e-9, `ray ${turn}`);
    met += distances.length > 0 ? 1 : 0;
  }
  assert.ok(met > 300 && met < 600, `${met} of the rays meet something`);
});
