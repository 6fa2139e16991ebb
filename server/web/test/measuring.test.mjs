// A path clicked on the page, held against the heights of the server. TERRAIN_URL: address of a running terrain-server.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";
import { launch, quietPage } from "./browser.mjs";

const CLICKS = [[420, 260], [500, 220], [560, 300]];
const complaints = [];
let browser, page;

before(async () => {
  browser = await launch();
  page = await quietPage(browser, complaints, { width: 800, height: 560 });
  await page.goto(process.env.TERRAIN_URL);
  await page.waitForFunction(() => window.terrain !== undefined);
  await page.evaluate(() => window.terrain.settled());
});

after(() => browser?.close());

async function saved(button) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click(button)]);
  return { name: download.suggestedFilename(), text: await readFile(await download.path(), "utf8") };
}

test("clicks make a path with a length, an area and heights; drags do not", async () => {
  await page.check("#measuring");
  assert.equal(await page.textContent("#measured"), "Click places on the ground.");
  for (const [x, y] of CLICKS) await page.mouse.click(x, y);
  assert.match(await page.textContent("#measured"), /^Length [\d.]+ km · height difference [+−][\d.]+ ± [\d.]+ m · area [\d.]+ km²$/);
  assert.ok(await page.isVisible("#profile canvas"));
  const before = await page.textContent("#measured");
  await page.mouse.move(450, 300);
  await page.mouse.down();
  await page.mouse.move(470, 310, { steps: 3 });
  await page.mouse.up();
  assert.equal((await page.textContent("#measured")).split(" · ")[0], before.split(" · ")[0]);
});

test("the table has the heights of the server, within both errors", async () => {
  await page.evaluate(() => window.terrain.settled());
  await page.waitForTimeout(600);
  const { name, text } = await saved("#path-csv");
  assert.equal(name, "profile.csv");
  const [head, ...rows] = text.trim().split("\r\n").map((row) => row.split(","));
  assert.deepEqual(head, ["distance_m", "longitude", "latitude", "height_m", "certified_error_m", "status"]);
  assert.ok(rows.length > 200, `${rows.length} rows`);
  const [{ name: tileset }] = await page.evaluate(() => fetch("tilesets").then((answer) => answer.json()));
  let compared = 0;
  for (const [, longitude, latitude, height, error] of rows.filter((_, row) => row % 20 === 0)) {
    const query = `${tileset}/height?longitude=${longitude}&latitude=${latitude}`;
    const { points } = await page.evaluate((query) => fetch(query).then((answer) => answer.json()), query);
    const difference = Math.abs(points[0].height - Number(height));
    assert.ok(difference <= Number(error) + points[0].error + 0.02, `${longitude}, ${latitude}: ${difference} m`);
    compared++;
  }
  assert.ok(compared > 8);
});

test("the line of the GeoJSON is that of the table", async () => {
  const { features } = JSON.parse((await saved("#path-geojson")).text);
  const { text } = await saved("#path-csv");
  assert.equal(features[0].geometry.coordinates.length, text.trim().split("\r\n").length - 1);
  const [{ metadata }] = await page.evaluate(() => fetch("tilesets").then((answer) => answer.json()));
  const { heights_above: above, vertical_datum: datum } = metadata.source;
  assert.equal(features[0].properties.heights_above, above || datum || "unspecified");
  assert.ok(features[0].properties.area_m2 > 1e5);
});

test("undo takes the last place away, clear all; what is switched off takes no clicks", async () => {
  await page.click("#path-undo");
  assert.ok(!(await page.textContent("#measured")).includes("area"));
  await page.click("#path-clear");
  assert.equal(await page.textContent("#measured"), "Click places on the ground.");
  assert.ok(await page.isDisabled("#path-csv"));
  await page.uncheck("#measuring");
  await page.mouse.click(420, 260);
  await page.check("#measuring");
  assert.equal(await page.textContent("#measured"), "Click places on the ground.");
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
