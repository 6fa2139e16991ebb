import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { degreesOf, keyOf, type Address } from "../src/address.ts";
import { drawnPrefix, placesOf } from "../src/partition.ts";
import { distanceTo, type OrientedBox } from "../src/oriented_box.ts";
import { select, type Choice, type Hierarchy, type Selection } from "../src/select.ts";
import { screenSpaceError, Sight } from "../src/sight.ts";
import { interiorLevels, type Tile } from "../src/tile.ts";
import { AXES, flatEarth, PYRAMID, viewFrom, type View } from "./flat_earth.ts";
import { gridTile } from "./grid_pyramid.ts";

function selected(tiles: Hierarchy, { camera, demand }: View): Selection {
  return select(tiles, camera, demand, []);
}

const chance = ({ zoom, x, y }: Address, of: number) => (zoom * 31 + x * 17 + y * 7) % of;
/** How many levels of a tile there are: all coarse tiles whole, and of the finer ones most, by fixed rules that look like chance. */
const LOADED = {
  "all tiles": () => Infinity,
  "some tiles": (tile: Address) => (tile.zoom < 4 || chance(tile, 13) !== 0 ? Infinity : 0),
  "some levels of all tiles": (tile: Address) => (tile.zoom < 4 ? Infinity : 1 + chance(tile, 7)),
  "some levels of some tiles": (tile: Address) => (tile.zoom < 4 ? 4 + chance(tile, 4) : chance(tile, 8)),
} as const;

test("a metre at a hundred metres is as large as half the field of view says", () => {
  const { camera } = viewFrom(0, 0, 0);
  assert.equal(screenSpaceError(1, 100, camera), 0.1);
  assert.equal(screenSpaceError(1, 0, camera), Infinity);
  assert.equal(screenSpaceError(1, 100, { ...camera, farthest: 50 }), 0.2);
  assert.equal(screenSpaceError(0, 0, camera), 0);
});

test("everything drawn is within the limit where the pyramid is deep enough", () => {
  const [tiles, view] = [flatEarth(), viewFrom(100, 60, 8)];
  const { choices, requests } = selected(tiles, view);
  assert.deepEqual(requests, []);
  for (const { address, error } of choices) {
    const pixels = screenSpaceError(error, distanceTo(tiles.bounds(address), view.camera.eye), view.camera);
    assert.ok(pixels <= view.demand.tolerance || address.zoom === PYRAMID.leafZoom, `${keyOf(address)}: ${pixels} pixels`);
  }
  assert.equal(Math.max(...choices.map(({ address }) => address.zoom)), PYRAMID.leafZoom);
});

test("from far away the coarsest level of the roots is enough", () => {
  const { choices } = selected(flatEarth(), viewFrom(180, 90, 1e5));
  assert.deepEqual(choices.map(({ address, interior }) => [keyOf(address), interior]), [["0/0/0", 0], ["0/1/0", 0]]);
});

test("less error allowed never draws fewer tiles", () => {
  const counts = [16, 8, 4, 2, 1].map((pixels) => selected(flatEarth(), viewFrom(100, 60, 20, pixels)).choices.length);
  assert.deepEqual(counts, [...counts].sort((a, b) => a - b));
  assert.ok(counts[0]! < counts[4]!, String(counts));
});

test("what is out of sight is not refined beyond what its neighbours need", () => {
  const view = viewFrom(100, 60, 8);
  const eastOf90 = { ...view.camera, frustum: [{ normal: new Vector3(1, 0, 0), constant: -90 }] };
  const inSight = selected(flatEarth(), { ...view, camera: eastOf90 });
  assert.ok(inSight.choices.length < selected(flatEarth(), view).choices.length);
});

for (const [name, levelsThere] of Object.entries(LOADED)) {
  for (const [x, y, z] of [[100, 60, 2], [0.5, 90, 3], [359, 3, 1]] as const) {
    test(`with ${name} loaded, the view from ${x}, ${y}, ${z} covers the Earth once, without a gap`, async () => {
      const { choices, requests } = selected(flatEarth(1, levelsThere), viewFrom(x, y, z));
      assert.equal(requests.length > 0, name !== "all tiles");
      assert.ok(new Set(choices.map(({ address }) => address.zoom)).size > 1, "several zooms are on show");
      const area = choices.reduce((sum, { address }) => sum + degreesOf(address.zoom) ** 2, 0);
      assert.equal(area, 360 * 180);
      for (const choice of choices) assert.ok(levelsOf(choice) <= levelsThere(choice.address), `${keyOf(choice.address)}: levels that are not there`);
      assert.deepEqual(await openEdges(choices), []);
    });
  }
}

/** How many levels of a tile, of which three are interior, a choice needs. */
const levelsOf = ({ interior, fineSides }: Choice) => (fineSides.includes(true) ? 4 + fineSides.lastIndexOf(true) : interior + 1);

test("whatever is asked for, level by level, the picture becomes that of all tiles, and never coarser on the way", () => {
  const [view, there] = [viewFrom(100, 60, 2), new Map<string, number>()];
  const tiles = flatEarth(1, (tile) => there.get(keyOf(tile)) ?? 0);
  const pixelsOf = ({ address, error }: Choice) => screenSpaceError(error, distanceTo(tiles.bounds(address), view.camera.eye), view.camera);
  let [before, worst, bytes] = [[] as readonly Choice[], Infinity, 0];
  for (let step = 0; ; step++) {
    const { choices, requests } = select(tiles, view.camera, view.demand, before);
    const now = choices.length === 0 ? Infinity : Math.max(...choices.map(pixelsOf));
    assert.ok(now <= worst, `step ${step}: ${worst} → ${now} pixels`);
    [before, worst] = [choices, now];
    const [first] = requests;
    if (first === undefined) break;
    there.set(keyOf(first.address), first.levels);
    bytes += first.levels;
    assert.ok(step < 2000);
  }
  assert.deepEqual(before, selected(flatEarth(), view).choices);
  assert.ok(bytes < 0.7 * 7 * there.size, `${bytes} levels of ${there.size} tiles`);
});

test("of tiles out of sight one level is asked for, of those in sight as many as are good enough", () => {
  const view = viewFrom(100, 60, 8);
  const camera = { ...view.camera, frustum: [{ normal: new Vector3(1, 0, 0), constant: -90 }] };
  const there = new Set<string>();
  const tiles = flatEarth(1, (tile) => (there.has(keyOf(tile)) ? 1 : 0));
  for (let round = 0; round < 10; round++) {
    for (const { address } of select(tiles, camera, view.demand, []).requests) there.add(keyOf(address));
  }
  const requests = select(tiles, camera, view.demand, []).requests;
  assert.ok(requests.length > 0 && requests.every(({ levels }) => levels > 1));
  const sight = new Sight(camera);
  const outOfSight = requests.filter(({ address }) => !sight.sees(tiles.bounds(address)));
  assert.ok(outOfSight.every(({ levels }) => levels > 3), "but for their sides");
});

test("rough ground beside calm ground: calm tiles stay coarse inside, but not where a side must be fine", async () => {
  const { choices } = selected(flatEarth(1 / 64), viewFrom(185, 60, 2));
  const calm = choices.filter(({ address }) => address.x < 2 ** address.zoom);
  const withFineSide = calm.filter(({ fineSides }) => fineSides.includes(true));
  assert.ok(withFineSide.length > 3 && withFineSide.every(({ interior }) => interior === 2));
  assert.ok(calm.some(({ interior }) => interior === 0));
  assert.deepEqual(await openEdges(choices), []);
});

test("the ball hides what is behind it and nothing else", () => {
  const ground = { centre: new Vector3(), axis: AXES[2], equatorial: 1, polar: 0.5 };
  const sight = new Sight({ eye: new Vector3(2, 0, 0), pixelsPerRadian: 1, farthest: Infinity, frustum: [], ground });
  const cube = (x: number, y: number, z: number): OrientedBox => ({ centre: new Vector3(x, y, z), axes: AXES, halfSizes: [0.1, 0.1, 0.1] });
  assert.ok(!sight.sees(cube(-1.5, 0, 0)));
  // Beside the flattened ball, though a round one would hide it.
  assert.ok(sight.sees(cube(-1.5, 0, 1.2)));
  assert.ok(!sight.sees(cube(-1.5, 1.2, 0)));
  assert.ok(sight.sees(cube(0.9, 0, 0)));
  assert.ok(sight.sees(cube(-10, 6.8, 0)));
});

test("too small a budget makes everything coarser, not one part", () => {
  const view = viewFrom(100, 60, 8);
  const whole = selected(flatEarth(), view);
  const half = selected(flatEarth(), { ...view, demand: { ...view.demand, bytes: 500 * whole.choices.length } });
  assert.ok(half.choices.length <= whole.choices.length / 2);
  assert.deepEqual(half.choices, selected(flatEarth(), viewFrom(100, 60, 8, half.tolerance)).choices);
});

/** Edges of the drawn surface, in lattice coordinates of the Earth, that no other triangle has in reverse. */
async function openEdges(choices: readonly Choice[]): Promise<string[]> {
  const edges = new Set<string>();
  for (const choice of choices) {
    const tile = gridTile(PYRAMID, choice.address);
    assert.equal(interiorLevels(tile), 3);
    for (const edge of edgesOf(tile, choice)) {
      assert.ok(!edges.has(edge), `edge ${edge} is used twice`);
      edges.add(edge);
    }
  }
  const reversed = (edge: string) => edge.split(" ").reverse().join(" ");
  return [...edges].filter((edge) => !edges.has(reversed(edge)) && !isAtPole(edge));
}

function edgesOf(tile: Tile, choice: Choice): string[] {
  const places = placesOf(tile, choice);
  const units = 2 ** tile.extentBits;
  const around = units * 2 ** (tile.address.zoom + 1);
  const name = (corner: number) => {
    const [x = 0, y = 0, height = 0] = tile.positions.subarray(3 * places[corner]!, 3 * places[corner]! + 3);
    return `${(tile.address.x * units + x) % around},${tile.address.y * units + y},${height}`;
  };
  return Array.from({ length: drawnPrefix(tile, choice) }, (_, triangle) => {
    const [a, b, c] = [0, 1, 2].map((n) => name(tile.corners[3 * triangle + n]!));
    return a === b || b === c || c === a ? [] : [`${a} ${b}`, `${b} ${c}`, `${c} ${a}`];
  }).flat();
}

/** The lattice ends at the poles; what lies there has nothing beyond it. */
function isAtPole(edge: string): boolean {
  const rows = edge.split(" ").map((vertex) => vertex.split(",")[1]);
  return rows[0] === rows[1] && (rows[0] === "0" || rows[0] === String(2 ** (8 + PYRAMID.leafZoom)));
}
