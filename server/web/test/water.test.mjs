// Water that an archive knows. TERRAIN_URL: address of a terrain-server that has an archive whose name ends in "water".

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launch, pixelsOf, quietPage } from "./browser.mjs";

const complaints = [];
let browser, page, lake;

before(async () => {
  const tilesets = await fetch(new URL("tilesets", process.env.TERRAIN_URL)).then((answer) => answer.json());
  const { name, metadata } = tilesets.find((tileset) => tileset.name.endsWith("water"));
  const ring = metadata.water[0][0];
  const [longitudes, latitudes] = [0, 1].map((axis) => ring.map((place) => place[axis]));
  lake = { west: Math.min(...longitudes), east: Math.max(...longitudes), south: Math.min(...latitudes), north: Math.max(...latitudes) };
  browser = await launch();
  page = await quietPage(browser, complaints);
  await page.goto(`${process.env.TERRAIN_URL}#${name}`);
  await page.waitForFunction(() => window.terrain !== undefined);
});

after(() => browser?.close());

/** Red, green and blue of the ground at a place, seen from above. */
async function colourAt(longitude, latitude) {
  await page.evaluate(([x, y]) => window.terrain.flyTo(x, y, 400, 3000, 0, 85), [longitude, latitude]);
  await page.evaluate(() => window.terrain.settled());
  return [...(await pixelsOf(page, { x: 320, y: 240, width: 1, height: 1 }))].slice(0, 3);
}

const isBlue = ([red, green, blue]) => blue > 1.1 * green && blue > 1.5 * red;

test("a lake is blue inside of its shore, whatever its height, and the ground around it is not", async () => {
  const [middleX, middleY] = [(lake.west + lake.east) / 2, (lake.south + lake.north) / 2];
  const [dx, dy] = [0.004, 0.003];
  const wet = [[middleX, middleY], [lake.west + dx, middleY], [lake.east - dx, middleY], [middleX, lake.south + dy], [middleX, lake.north - dy]];
  const dry = [[lake.west - dx, middleY], [lake.east + dx, middleY], [middleX, lake.south - dy], [middleX, lake.north + dy]];
  for (const place of wet) assert.ok(isBlue(await colourAt(...place)), `${place} is water`);
  for (const place of dry) assert.ok(!isBlue(await colourAt(...place)), `${place} is land`);
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
