import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { keyOf, type Address } from "../src/address.ts";
import { Frame } from "../src/frame.ts";
import { Morph, movingPrefix, type Moving, type ShownTile } from "../src/morph.ts";
import { select, type Choice } from "../src/select.ts";
import { placed, type PlacedTile } from "../src/spots.ts";
import type { Tile } from "../src/tile.ts";
import { flatEarth, PYRAMID, viewFrom } from "./flat_earth.ts";
import { gridTile } from "./grid_pyramid.ts";

const frame = new Frame(10, 20);
let tiles = new Map<string, Tile>();
/** How many levels of tiles are there. */
let levelsThere: (address: Address) => number = () => Infinity;
function tileAt(address: Address): Tile {
  const key = keyOf(address);
  const tile = tiles.get(key) ?? cut(gridTile(PYRAMID, address), levelsThere(address));
  tiles.set(key, tile);
  return tile;
}

const placedTiles = new Map<Tile, PlacedTile>();
function placedAt(address: Address): PlacedTile {
  const tile = tileAt(address);
  const found = placedTiles.get(tile) ?? placed(tile, frame);
  placedTiles.set(tile, found);
  return found;
}

/** A tile of which so many levels are there. */
function cut(tile: Tile, count: number): Tile {
  const last = tile.levels[Math.min(count, tile.levels.length) - 1]!;
  const vertices = tile.representatives.length;
  const corner = (vertex: number): number => (vertex < last.vertexEnd ? vertex : corner(tile.representatives[vertex]!));
  return {
    ...tile,
    levels: tile.levels.map((level, index) => (index < count ? level : last)),
    positions: Float64Array.of(...tile.positions.subarray(0, 3 * last.vertexEnd), ...tile.positions.subarray(3 * vertices, 3 * (vertices + last.vertexEnd))),
    representatives: tile.representatives.slice(0, last.vertexEnd),
    corners: tile.corners.slice(0, 3 * last.triangleEnd).map(corner),
  };
}

function loadedAre(levels: (address: Address) => number): void {
  [tiles, levelsThere] = [new Map(), levels];
}

function pictureFrom(x: number, y: number, z: number, tolerance = 2): Map<string, Choice> {
  const { camera, demand } = viewFrom(x, y, z, tolerance);
  const { choices } = select(flatEarth(1, levelsThere), camera, demand, []);
  return new Map(choices.map((choice) => [keyOf(choice.address), choice]));
}

/** Every tile that is drawn on the way: those that move, and those of the second picture that are in both as they are. */
function allMoving(before: ReadonlyMap<string, ShownTile>, after: ReadonlyMap<string, ShownTile>): Moving<ShownTile>[] {
  const moving = new Morph<ShownTile>(placedAt).between(before, after);
  const resting = [...after.values()].filter((shown) => before.has(keyOf(shown.address)));
  const known = new Set(moving.map(({ address }) => keyOf(address)));
  const still = resting.filter(({ address }) => !known.has(keyOf(address)));
  // As if from a picture of another level of detail, so that there are spots to look at; their ends count.
  const others = still.flatMap((shown) => {
    const other = { ...shown, interior: shown.interior === 0 ? 1 : 0, fineSides: [false, false, false, false] };
    const [found] = new Morph<ShownTile>(placedAt).between(new Map([[keyOf(shown.address), other]]), new Map([[keyOf(shown.address), shown]]));
    return [{ ...found!, from: found!.to }];
  });
  return [...moving, ...others];
}

/** Names of the edges that are drawn at a moment, by the bits of their ends, from which no other triangle's edge comes back. */
function openEdges(moving: readonly Moving<ShownTile>[], blend: number): string[] {
  const edges = new Map<string, number>();
  for (const moved of moving) {
    const { address, from, to } = moved;
    const tile = tileAt(address);
    const triangles = movingPrefix(tile, moved);
    const name = (corner: number) => {
      const { x, y, z } = from[corner]!.position.clone().lerp(to[corner]!.position, blend);
      return `${x},${y},${z}`;
    };
    for (let at = 0; at < 3 * triangles; at += 3) {
      const [a, b, c] = [...tile.corners.subarray(at, at + 3)].map(name) as [string, string, string];
      if (a === b || b === c || c === a) continue;
      for (const edge of [`${a} ${b}`, `${b} ${c}`, `${c} ${a}`]) edges.set(edge, (edges.get(edge) ?? 0) + 1);
    }
  }
  const reversed = (edge: string) => edge.split(" ").reverse().join(" ");
  return [...edges].filter(([edge, count]) => count !== (edges.get(reversed(edge)) ?? 0)).map(([edge]) => edge);
}

/** Ends of open edges that are not at a pole or on the antimeridian, where the lattice of a flat picture ends. */
function gaps(moving: readonly Moving<ShownTile>[], blend: number): string[] {
  const isAtEnd = (edge: string) => {
    const ends = edge.split(" ").map((end) => end.split(",").map(Number));
    return ends.every(([x = 0, y = 0, z = 0]) => {
      const { x: X, y: Y } = frame.earthCentredOf(new Vector3(x, y, z));
      return Math.hypot(X, Y) < 1 || (Math.abs(Y) < 1 && X < 0);
    });
  };
  return openEdges(moving, blend).filter((edge) => !isAtEnd(edge));
}

const FLIGHT: (readonly [number, number, number, number?])[] = [
  [180, 90, 1e5], [100, 60, 60], [100, 60, 20], [101, 61, 5], [104, 63, 5], [104, 63, 5, 1], [200, 90, 6], [200, 90, 400], [100, 60, 8], [104, 63, 2],
];

for (const [at, view] of FLIGHT.entries()) {
  const earlier = FLIGHT.at(at - 1)!;
  test(`on the way from ${earlier} to ${view}, neighbours meet to the bit at every moment`, () => {
    const moving = allMoving(pictureFrom(...earlier), pictureFrom(...view));
    assert.ok(moving.length > 0);
    for (const blend of [0, 0.25, 0.5, 0.9, 1]) assert.deepEqual(gaps(moving, blend).slice(0, 3), [], `at ${blend}`);
  });
}

const chance = ({ zoom, x, y }: Address, of: number) => (zoom * 31 + x * 17 + y * 7) % of;

for (const [name, levels] of [
  ["some levels of each", (address: Address) => 1 + chance(address, 7)],
  ["one level of each", () => 1],
  ["some levels of some", (address: Address) => (address.zoom < 3 ? 7 : chance(address, 8))],
] as const) {
  test(`where ${name} tile are there, neighbours meet to the bit at every moment`, () => {
    loadedAre(levels);
    for (const [at, view] of FLIGHT.entries()) {
      const moving = allMoving(pictureFrom(...FLIGHT.at(at - 1)!), pictureFrom(...view));
      for (const blend of [0, 0.5, 1]) assert.deepEqual(gaps(moving, blend).slice(0, 3), [], `before ${view}, at ${blend}`);
    }
    loadedAre(() => Infinity);
  });
}

test("what a parent does not know begins on the surface that it shows, at its place in plan", () => {
  loadedAre(() => 1);
  const [before, after] = [pictureFrom(180, 90, 1e5), pictureFrom(100, 60, 60)];
  let moved = 0;
  for (const { from, to } of new Morph<ShownTile>(placedAt).between(before, after)) {
    for (const [vertex, spot] of from.entries()) {
      assert.ok(Math.abs(spot.longitude - to[vertex]!.longitude) < 1e-9 && Math.abs(spot.latitude - to[vertex]!.latitude) < 1e-9);
      if (Math.abs(spot.height - to[vertex]!.height) > 0.1) moved++;
    }
  }
  loadedAre(() => Infinity);
  assert.ok(moved > 20, `${moved} vertices`);
});

test("at both ends, the vertices that are drawn are those of the pictures", () => {
  for (const [earlier, later] of [[FLIGHT[2]!, FLIGHT[3]!], [FLIGHT[3]!, FLIGHT[7]!]] as const) {
    const [before, after] = [pictureFrom(...earlier), pictureFrom(...later)];
    for (const { address, from, to } of new Morph<ShownTile>(placedAt).between(before, after)) {
      for (const [spots, picture] of [[from, before], [to, after]] as const) {
        for (const { longitude, latitude, height, own } of spots) {
          if (own === undefined) continue;
          const zoom = own.tile.address.zoom;
          const shown = [...picture.values()].filter((choice) => choice.address.zoom <= address.zoom);
          assert.ok(shown.length > 0 && zoom <= address.zoom);
          assert.ok(Math.abs(height - PYRAMID.height(longitude, latitude)) <= 1 / 16);
        }
      }
    }
  }
});
