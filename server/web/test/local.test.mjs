// Ground that is nowhere on the Earth. TERRAIN_URL: address of a terrain-server that has an archive whose name ends in "local", of 403 by 344
// samples 90 m from each other.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launch, placeText, quietPage } from "./browser.mjs";

const complaints = [];
let browser, page, name;

before(async () => {
  const tilesets = await fetch(new URL("tilesets", process.env.TERRAIN_URL)).then((answer) => answer.json());
  ({ name } = tilesets.find((tileset) => tileset.name.endsWith("local")));
  browser = await launch();
  page = await quietPage(browser, complaints);
  await page.goto(`${process.env.TERRAIN_URL}#${name}/18000,8000,12000,0,45,m`);
  await page.waitForFunction(() => window.terrain !== undefined);
  await page.evaluate(() => window.terrain.settled());
});

after(() => browser?.close());

test("the place under the pointer is told in metres of the plane, and no datum of the Earth", async () => {
  await page.mouse.move(400, 250);
  const text = await placeText(page);
  const [, x, y] = /^x (-?[\d.]+) m, y (-?[\d.]+) m: [\d.]+ ± [\d.]+ m$/.exec(text) ?? assert.fail(text);
  assert.ok(Number(x) > 15000 && Number(x) < 25000 && Number(y) > 12000 && Number(y) < 25000, text);
});

test("there is no north, no imagery and no geoid", async () => {
  assert.equal((await page.textContent("#needle")).trim(), "▲y");
  assert.equal(await page.getAttribute("#north", "aria-label"), "Turn y up");
  assert.ok(await page.isDisabled("#imagery"));
  assert.equal(await page.textContent("#heights"), "Metres on a plane that is nowhere on the Earth");
});

test("a link is in metres and leads to the same view", async () => {
  await page.waitForTimeout(600);
  const [, x, y] = new URL(page.url()).hash.match(/\/([-\d.]+),([-\d.]+),[-\d.,]+,m$/);
  assert.ok(Math.abs(Number(x) - 18000) < 1 && Math.abs(Number(y) - 8000) < 1, page.url());
});

test("what is measured is metres of the plane", async () => {
  await page.check("#measuring");
  for (const [x, y] of [[400, 180], [500, 180]]) await page.mouse.click(x, y);
  const ends = await page.evaluate(() => [[400, 180], [500, 180]].map(([x, y]) => window.terrain.groundAt(x / 320 - 1, 1 - y / 240)));
  const metres = Math.hypot(...["longitude", "latitude"].map((part) => (ends[1][part] - ends[0][part]) * 111000));
  const [, length, unit] = /^Length ([\d.]+) (k?m)/.exec(await page.textContent("#measured"));
  const measured = Number(length) * (unit === "km" ? 1000 : 1);
  assert.ok(Math.abs(measured / metres - 1) < 0.02, `${measured} and some ${metres} m`);
  const download = page.waitForEvent("download");
  await page.click("#path-csv");
  let text = "";
  for await (const chunk of await (await download).createReadStream()) text += chunk;
  assert.ok(text.startsWith("distance_m,x_m,y_m,height_m,"), text.slice(0, 100));
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
