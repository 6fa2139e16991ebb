// Ground that was filled, told apart. TERRAIN_URL: address of a terrain-server that has an archive whose name ends in "filled".

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { changedShare, launch, pixelsOf, placeText, quietPage } from "./browser.mjs";

const CLIP = { x: 240, y: 60, width: 390, height: 380 };
/** Places that are looked at along each axis. */
const GRID = 24;
const complaints = [];
let browser, page, name, places;

before(async () => {
  const tilesets = await fetch(new URL("tilesets", process.env.TERRAIN_URL)).then((answer) => answer.json());
  const { name: found, metadata } = tilesets.find((tileset) => tileset.name.endsWith("filled"));
  name = found;
  places = await askedFor(metadata.bounds);
  browser = await launch();
  page = await quietPage(browser, complaints);
  const { longitude, latitude } = places.find(({ status }) => status === "filled");
  await page.goto(`${process.env.TERRAIN_URL}?pixels=0.5#${name}/${latitude - 0.004},${longitude},1500,0,60`);
  await page.waitForFunction(() => window.terrain !== undefined);
});

after(() => browser?.close());

/** What the server says of places over an archive. */
async function askedFor([west, south, east, north]) {
  const at = (low, high, step) => low + ((high - low) * (step + 0.5)) / GRID;
  const asked = Array.from({ length: GRID * GRID }, async (_, cell) => {
    const query = `longitude=${at(west, east, cell % GRID)}&latitude=${at(south, north, Math.floor(cell / GRID))}`;
    return (await fetch(new URL(`${name}/height?${query}`, process.env.TERRAIN_URL)).then((answer) => answer.json())).points[0];
  });
  return Promise.all(asked);
}

/** What the page says of a place once it is drawn in the middle of the view. */
async function saidOf({ longitude, latitude, height }) {
  await page.evaluate(([x, y, z]) => window.terrain.flyTo(x, y, z, 1500, 0, 80), [longitude, latitude, height]);
  await page.evaluate(() => window.terrain.settled());
  await page.mouse.move(0, 0);
  await page.mouse.move(320, 240);
  return placeText(page);
}

test("the pointer's height says where the ground was filled, and shows no error there", async () => {
  assert.match(await saidOf(places.find(({ status }) => status === "filled")), /: [\d.]+ m \(filled\) above /);
  assert.equal(await page.textContent("#error"), "filled");
  assert.match(await saidOf(places.find(({ status }) => status === "measured")), /: [\d.]+ ± [\d.]+ m above /);
});

test("filled ground is told apart by a switch, and always among certified errors, with its legend", async () => {
  await saidOf(places.find(({ status }) => status === "filled"));
  assert.ok(await page.isHidden("#legend-filled"));
  const plain = await pixelsOf(page, CLIP);
  await page.check("#filled");
  await page.evaluate(() => window.terrain.settled());
  assert.ok(await page.isVisible("#legend-filled"));
  const share = changedShare(plain, await pixelsOf(page, CLIP));
  assert.ok(share > 0.005 && share < 0.5, `${share} of the picture`);
  await page.uncheck("#filled");
  await page.selectOption("#style", "Certified error");
  await page.evaluate(() => window.terrain.settled());
  assert.ok(await page.isVisible("#legend-filled"));
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
