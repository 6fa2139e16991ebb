import assert from "node:assert/strict";
import { test } from "node:test";
import { Box3, Vector3 } from "three";
import { degreesOf, keyOf, type Address } from "../src/address.ts";
import { drawnPrefix, placesOf } from "../src/partition.ts";
import { screenSpaceError, select, type Choice, type Tiles, type View } from "../src/select.ts";
import { interiorLevels, type Tile } from "../src/spt.ts";
import { gridTile, type Pyramid } from "./grid_pyramid.ts";

const PYRAMID: Pyramid = {
  leafZoom: 6,
  cells: 4,
  leafError: 1,
  // The same at both ends of the antimeridian.
  height: (longitude, latitude) => 40 * Math.sin((longitude * Math.PI) / 20) * Math.cos(1.7 * latitude),
};

/**
 * A flat Earth of one metre a degree, all of whose tiles exist; those for which `isLoaded` holds are loaded. West of
 * the middle, errors are `calm` times those of the east.
 */
function flatEarth(isLoaded: (tile: Address) => boolean = () => true, calm = 1): Tiles {
  const roughness = ({ zoom, x }: Address) => (x < 2 ** zoom ? calm : 1);
  const finestError = (zoom: number) => 2 ** (PYRAMID.leafZoom - zoom);
  return {
    roots: [0, 1].map((x) => ({ zoom: 0, x, y: 0 })),
    exists: ({ zoom }) => zoom <= PYRAMID.leafZoom,
    box: ({ zoom, x, y }) => {
      const side = degreesOf(zoom);
      return new Box3(new Vector3(x * side, y * side, 0), new Vector3((x + 1) * side, (y + 1) * side, 0));
    },
    errors: (tile) => {
      const finest = roughness(tile) * finestError(tile.zoom);
      return isLoaded(tile) ? [2 * finest, 1.5 * finest, finest] : undefined;
    },
    finestError,
  };
}

function viewFrom(x: number, y: number, z: number, maxPixels = 2): View {
  return { eye: new Vector3(x, y, z), pixelsPerRadian: 10, maxPixels, isVisible: () => true };
}

/** All coarse tiles, and of the finer ones most, by a fixed rule that looks like chance. */
function isMostlyLoaded({ zoom, x, y }: Address): boolean {
  return zoom < 4 || (zoom * 31 + x * 17 + y * 7) % 13 !== 0;
}

test("a metre at a hundred metres is as large as half the field of view says", () => {
  assert.equal(screenSpaceError(1, 100, viewFrom(0, 0, 0)), 0.1);
  assert.equal(screenSpaceError(1, 0, viewFrom(0, 0, 0)), Infinity);
  assert.equal(screenSpaceError(0, 0, viewFrom(0, 0, 0)), 0);
});

test("everything drawn is within the limit where the pyramid is deep enough", () => {
  const [tiles, view] = [flatEarth(), viewFrom(100, 60, 8)];
  const { choices, missing } = select(tiles, view);
  assert.deepEqual(missing, []);
  for (const { address, error } of choices) {
    const pixels = screenSpaceError(error, tiles.box(address).distanceToPoint(view.eye), view);
    assert.ok(pixels <= view.maxPixels || address.zoom === PYRAMID.leafZoom, `${keyOf(address)}: ${pixels} pixels`);
  }
  assert.equal(Math.max(...choices.map(({ address }) => address.zoom)), PYRAMID.leafZoom);
});

test("from far away the coarsest level of the roots is enough", () => {
  const { choices } = select(flatEarth(), viewFrom(180, 90, 1e5));
  assert.deepEqual(choices.map(({ address, interior }) => [keyOf(address), interior]), [["0/0/0", 0], ["0/1/0", 0]]);
});

test("less error allowed never draws fewer tiles", () => {
  const counts = [16, 8, 4, 2, 1].map((pixels) => select(flatEarth(), viewFrom(100, 60, 20, pixels)).choices.length);
  assert.deepEqual(counts, [...counts].sort((a, b) => a - b));
  assert.ok(counts[0]! < counts[4]!, String(counts));
});

test("what is out of sight is not refined beyond what its neighbours need", () => {
  const view = { ...viewFrom(100, 60, 8), isVisible: (box: Box3) => box.max.x > 90 };
  assert.ok(select(flatEarth(), view).choices.length < select(flatEarth(), viewFrom(100, 60, 8)).choices.length);
});

for (const [name, isLoaded] of [["all", () => true], ["some", isMostlyLoaded]] as const) {
  for (const [x, y, z] of [[100, 60, 2], [0.5, 90, 3], [359, 3, 1]] as const) {
    test(`with ${name} tiles loaded, the view from ${x}, ${y}, ${z} covers the Earth once, without a gap`, async () => {
      const { choices, missing } = select(flatEarth(isLoaded), viewFrom(x, y, z));
      assert.equal(missing.length > 0, name === "some");
      assert.ok(new Set(choices.map(({ address }) => address.zoom)).size > 2, "several zooms are on show");
      const area = choices.reduce((sum, { address }) => sum + degreesOf(address.zoom) ** 2, 0);
      assert.equal(area, 360 * 180);
      assert.deepEqual(await openEdges(choices), []);
    });
  }
}

test("rough ground beside calm ground: calm tiles stay coarse inside, but not where a side must be fine", async () => {
  const { choices } = select(flatEarth(() => true, 1 / 64), viewFrom(185, 60, 2));
  const calm = choices.filter(({ address }) => address.x < 2 ** address.zoom);
  const withFineSide = calm.filter(({ fineSides }) => fineSides.includes(true));
  assert.ok(withFineSide.length > 3 && withFineSide.every(({ interior }) => interior === 2));
  assert.ok(calm.some(({ interior }) => interior === 0));
  assert.deepEqual(await openEdges(choices), []);
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
