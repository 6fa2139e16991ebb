import assert from "node:assert/strict";
import { test } from "node:test";
import { DataTexture, DataUtils } from "three";
import { keyOf, type Address } from "../src/address.ts";
import { areasFor, FinerLight, MOST_SQUARES, type Seen } from "../src/finer_light.ts";
import { CELLS, normalsTexture, rasterBytes } from "../src/normals.ts";
import { SquareRasters, type SquareRaster } from "../src/square_rasters.ts";

const TILE = { zoom: 5, x: 11, y: 7 };
const DEEPEST = 11;

/** A tile so many pixels wide of which a part is in sight: from the west and from the south, in shares of it. */
function seen(pixels: number, share = 1): Seen {
  const from = ({ zoom, x, y }: Address) => [x / 2 ** (zoom - TILE.zoom) - TILE.x, y / 2 ** (zoom - TILE.zoom) - TILE.y] as const;
  return {
    pixels: ({ zoom }) => pixels / 2 ** (zoom - TILE.zoom),
    isInSight: (square) => from(square).every((at) => at < share),
    exists: ({ zoom }) => zoom <= DEEPEST,
  };
}

test("squares have a cell a pixel, or the least more, and are those in sight", () => {
  assert.deepEqual(areasFor([TILE], seen(256)), [{ zoom: 5, west: 11, south: 7, east: 11, north: 7 }]);
  assert.deepEqual(areasFor([TILE], seen(1000)), [{ zoom: 7, west: 44, south: 28, east: 47, north: 31 }]);
  assert.deepEqual(areasFor([TILE], seen(8000, 0.1)), [{ zoom: 10, west: 352, south: 224, east: 355, north: 227 }]);
  assert.deepEqual(areasFor([TILE], seen(1e6, 0.001)), [{ zoom: DEEPEST, west: 704, south: 448, east: 704, north: 448 }], "as deep as tiles are");
  assert.deepEqual(areasFor([TILE], seen(60)), [{ zoom: 3, west: 2, south: 1, east: 2, north: 1 }], "far away one of a square above does");
});

test("there are never more squares than fit", () => {
  const tiles = Array.from({ length: 12 }, (_, at) => ({ ...TILE, x: TILE.x + at }));
  for (const pixels of [256, 1000, 4000, 50_000]) {
    const near = { ...seen(pixels), isInSight: () => true };
    const areas = areasFor(tiles, near);
    const squares = areas.reduce((sum, { west, south, east, north }) => sum + (east - west + 1) * (north - south + 1), 0);
    assert.ok(squares > 0 && squares <= MOST_SQUARES, `${pixels}: ${squares}`);
  }
});

/** A raster of parts of normals to the east. */
function rasterOf(east: (column: number, row: number) => number): SquareRaster {
  const side = CELLS + 1;
  const texels = Uint16Array.from({ length: 2 * side ** 2 }, (_, at) => DataUtils.toHalfFloat(east((at >> 1) % side, Math.floor((at >> 1) / side))));
  return { texture: normalsTexture(texels, side, side), bytesLoaded: 1, bytesKept: rasterBytes(1) };
}

/** A tile's own light, which is there already and leans more to the north-east, and finer one, the same all over a square. */
async function lightOf(ask: (address: Address) => void) {
  const load = () => Promise.resolve(rasterOf((column, row) => (column + 2 * row) / 1024));
  const normals = new SquareRasters({ load, parallelSquares: 2, parallelRequests: 2, mostBytes: rasterBytes(9) }, () => {});
  normals.request([{ address: TILE, detail: 0 }]);
  await promises();
  const finer = async ({ address }: { address: Address }) => {
    ask(address);
    await undefined;
    return rasterOf(() => -address.zoom);
  };
  return new FinerLight(finer, normals, () => {});
}

const promises = () => new Promise((resolve) => setImmediate(resolve));

/** Loads until all is there. */
async function loaded(light: FinerLight, view: Seen, tiles: readonly Address[] = [TILE]): Promise<void> {
  for (let times = 0; !light.load(tiles, view); times++) {
    assert.ok(times < 100, "it comes");
    await promises();
  }
}

test("finer light comes in when the view rests, fades in, and stays on whatever tile is drawn there then", async () => {
  const asked: string[] = [];
  const light = await lightOf((address) => asked.push(keyOf(address)));
  light.place([TILE], true);
  assert.equal(light.patchOf(TILE), undefined);
  await loaded(light, seen(1000, 0.3));
  assert.deepEqual(asked.sort(), ["7/44/28", "7/44/29", "7/45/28", "7/45/29"]);
  light.place([TILE], true);
  const patch = light.patchOf(TILE)!;
  assert.deepEqual([patch.size.toArray(), patch.corner.toArray(), patch.ends.toArray()], [[2, 2], [0, 0], [1, 1, 0, 0]]);
  assert.equal((patch.texture as DataTexture).image.width, 2 * CELLS + 1);
  assert.deepEqual([light.isFading, patch.share.value], [true, 0]);
  light.fade(1000);
  assert.deepEqual([light.isFading, patch.share.value], [false, 1]);
  light.place([TILE], false);
  assert.equal(light.patchOf(TILE), patch, "nothing is made anew");
  // The view moves: its child is drawn in its place, and then that one's.
  const child = { zoom: 6, x: 22, y: 14 };
  const [inside, outside] = [{ zoom: 8, x: 90, y: 57 }, { zoom: 6, x: 23, y: 15 }];
  light.place([child, inside, outside], false);
  assert.equal(light.patchOf(TILE), undefined);
  const [ofChild, ofInside] = [light.patchOf(child)!, light.patchOf(inside)!];
  assert.ok(ofChild.share.value === 1 && ofInside.share.value === 1, "at once");
  assert.deepEqual([ofChild.size.toArray(), ofChild.corner.toArray(), ofChild.ends.toArray()], [[1, 1], [0, 0], [1, 1, 1, 1]]);
  assert.deepEqual([ofInside.size.toArray(), ofInside.corner.toArray()], [[0.5, 0.5], [0, 0.5]]);
  assert.equal(light.patchOf(outside), undefined);
  assert.equal(asked.length, 4);
  light.close();
});

test("what is coarser than a tile's own light is not its, though it is another tile's", async () => {
  const light = await lightOf(() => {});
  await loaded(light, seen(60));
  light.place([TILE], true);
  assert.equal(light.patchOf(TILE), undefined);
  const beside = { ...TILE, x: TILE.x - 1 };
  const near = seen(600);
  const view = { ...near, pixels: (square: Address) => (square.zoom === beside.zoom && square.x === beside.x ? 100 : near.pixels(square)) };
  await loaded(light, view, [beside, TILE]);
  light.place([TILE], true);
  const { size, corner, texture } = light.patchOf(TILE)!;
  assert.deepEqual([size.toArray(), corner.toArray(), (texture as DataTexture).image.width], [[1, 1], [0, 0], 4 * CELLS + 1]);
  light.close();
});

test("where a square has no raster, what lies above it is enlarged", async () => {
  const light = await lightOf(() => {});
  // One of the four is no tile.
  const view = { ...seen(512), exists: (square: Address) => keyOf(square) !== "6/23/15" && square.zoom <= DEEPEST };
  await loaded(light, view);
  light.place([TILE], true);
  const { data, width } = (light.patchOf(TILE)!.texture as DataTexture).image as { data: Uint16Array; width: number };
  const at = (column: number, row: number) => DataUtils.fromHalfFloat(data[2 * (row * width + column)]!);
  assert.equal(at(10, 10), -6);
  for (const [column, row] of [[300, 400], [301, 511]] as const) assert.ok(Math.abs(at(column, row) - (column / 2 + row) / 1024) < 1e-3, `${column}, ${row}`);
  light.close();
});
