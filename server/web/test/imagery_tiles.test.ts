import assert from "node:assert/strict";
import { test } from "node:test";
import { keyOf, type Address } from "../src/address.ts";
import { ImageryTiles, nearestAbove } from "../src/imagery_tiles.ts";

/** The part of tiles of some names that shows an address. */
const partOf = (address: Address, ...names: string[]) =>
  nearestAbove(address, async (tile) => (names.includes(keyOf(tile)) ? keyOf(tile) : undefined));

test("a tile that is there shows itself", async () => {
  assert.deepEqual(await partOf({ zoom: 3, x: 5, y: 2 }, "3/5/2", "2/2/1"), { tile: "3/5/2", size: 1, x: 0, y: 0 });
});

test("in the place of a missing tile is the part of the nearest one above it, rows from the north", async () => {
  const tile = { zoom: 3, x: 5, y: 2 };
  assert.deepEqual(await partOf(tile, "2/2/1", "0/0/0"), { tile: "2/2/1", size: 0.5, x: 0.5, y: 0 });
  assert.deepEqual(await partOf(tile, "1/1/0", "0/0/0"), { tile: "1/1/0", size: 0.25, x: 0.25, y: 0.5 });
  assert.deepEqual(await partOf(tile, "0/0/0"), { tile: "0/0/0", size: 0.125, x: 0.625, y: 0.25 });
});

test("without any tile there is no part", async () => {
  assert.equal(await partOf({ zoom: 3, x: 5, y: 2 }, "3/5/3", "2/2/0"), undefined);
});

/** A server that answers every request alike, asked for the same tile again and again. */
async function askedTimes(status: number, times: number): Promise<{ readonly asked: string[]; readonly faults: string[]; readonly sizes: (number | undefined)[] }> {
  const [asked, faults, sizes]: [string[], string[], (number | undefined)[]] = [[], [], []];
  const before = { fetch: globalThis.fetch, createImageBitmap: globalThis.createImageBitmap };
  const isPicture = async (file: Blob) => (file.size > 1 ? {} : Promise.reject(new Error("no picture")));
  const answer = async (address: string) => {
    asked.push(address);
    if (status === 0) throw new TypeError("Failed to fetch");
    return new Response(status === 204 ? null : asked.length === 1 ? "?" : "tile", { status });
  };
  Object.assign(globalThis, { fetch: answer, createImageBitmap: isPicture });
  try {
    const tiles = new ImageryTiles("https://example.org/{z}/{y}/{x}.png?{x}");
    const order = { ask: <T>(get: () => Promise<T>) => get(), signal: new AbortController().signal };
    for (let time = 0; time < times; time++) {
      await tiles.get({ zoom: 3, x: 5, y: 2 }, order).then((tile) => sizes.push(tile?.bytes), (error: Error) => faults.push(error.message));
    }
  } finally {
    Object.assign(globalThis, before);
  }
  return { asked, faults, sizes };
}

test("a tile that the server has not is not asked for again, and no fault", async () => {
  for (const status of [204, 404]) {
    const { asked, faults, sizes } = await askedTimes(status, 3);
    assert.deepEqual([asked.length, faults, sizes], [1, [], [undefined, undefined, undefined]]);
  }
});

test("faults are told in plain words, and what failed may be asked for again", async () => {
  assert.deepEqual((await askedTimes(503, 2)).faults, ["its server answers 503", "its server answers 503"]);
  assert.deepEqual((await askedTimes(0, 1)).faults, ["its server cannot be reached, or allows no other pages to read it"]);
  const { asked, faults, sizes } = await askedTimes(200, 2);
  assert.deepEqual(faults, ["its server answers with what is no picture"]);
  assert.deepEqual(sizes, [4]);
  assert.equal(asked[1], "https://example.org/3/2/5.png?5");
});
