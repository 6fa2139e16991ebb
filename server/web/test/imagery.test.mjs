// Imagery from a stand-in for a tile server, whose tiles say by their colours where they are. TERRAIN_URL: the page.

import assert from "node:assert/strict";
import { createServer } from "node:http";
import { once } from "node:events";
import { after, before, test } from "node:test";
import { launch, pixelsOf, quietPage } from "./browser.mjs";

/** Degrees of a band of one colour, from north to south and from west to east: red tells latitude, green longitude. */
const CELL = 0.05;
const FINEST = 13;
const [WEST, NORTH] = [-85, 37];

let server, browser, page, template;
/** What the server answers instead of a tile; undefined for the tile. */
let refusal = () => undefined;
const complaints = [];
const asked = [];

before(async () => {
  server = createServer((request, response) => {
    const [z, x, y] = request.url.match(/\d+/g).map(Number);
    asked.push({ z, x, y });
    response.setHeader("access-control-allow-origin", "*");
    const status = refusal({ z, x, y });
    if (status !== undefined) response.writeHead(status).end();
    else if (z > FINEST) response.writeHead(204).end();
    else response.writeHead(200, { "content-type": "image/bmp" }).end(tileBitmap(z, x, y));
  }).listen(0, "127.0.0.1");
  await once(server, "listening");
  template = `http://127.0.0.1:${server.address().port}/{z}/{x}/{y}.bmp`;
  browser = await launch();
  page = await quietPage(browser, complaints);
});

after(async () => {
  await browser?.close();
  server?.close();
});

/** A bitmap file: 54 bytes of header, then rows from the south of blue, green and red, by the definition of the scheme. */
function tileBitmap(z, x, y) {
  const size = 256;
  const file = Buffer.alloc(54 + 3 * size * size);
  file.write("BM", "latin1");
  for (const [at, number] of [[2, file.length], [10, 54], [14, 40], [18, size], [22, size]]) file.writeUInt32LE(number, at);
  file.writeUInt16LE(1, 26);
  file.writeUInt16LE(24, 28);
  for (let row = 0; row < size; row++) {
    const share = (y + (row + 0.5) / size) / 2 ** z;
    const latitude = (Math.atan(Math.sinh(Math.PI * (1 - 2 * share))) * 180) / Math.PI;
    for (let column = 0; column < size; column++) {
      const longitude = ((x + (column + 0.5) / size) / 2 ** z) * 360 - 180;
      file.set([0, levelOf(longitude - WEST), levelOf(NORTH - latitude)], 54 + 3 * ((size - 1 - row) * size + column));
    }
  }
  return file;
}

/** Brightness of a band: sixteen of them, then again. */
const levelOf = (degrees) => 30 + 14 * (Math.max(0, Math.floor(degrees / CELL)) % 16);

/** The bands that are seen are those of the places where they are seen. */
async function assertImageryLies() {
  const image = await pixelsOf(page, { x: 0, y: 0, width: 640, height: 480 });
  let compared = 0;
  const places = Array.from({ length: 96 }, (_, at) => [250 + 30 * (at % 12), 60 + 45 * Math.floor(at / 12)]);
  const grounds = await page.evaluate(
    (places) => places.map(([x, y]) => window.terrain.groundAt((2 * x + 1) / 640 - 1, 1 - (2 * y + 1) / 480)),
    places,
  );
  for (const [at, ground] of grounds.entries()) {
    const [x, y] = places[at];
    if (ground === undefined) continue;
    const [south, east] = [(NORTH - ground.latitude) / CELL, (ground.longitude - WEST) / CELL];
    // Beside the edge of a band either colour is right.
    const isNearEdge = [south, east].some((cells) => Math.abs(cells - Math.round(cells)) < 0.06);
    if (isNearEdge) continue;
    const [red, green, blue] = image.subarray(4 * (y * 640 + x));
    // Light makes all channels brighter or darker by about as much; there is no blue in the imagery but by haze.
    const ratio = levelOf(NORTH - ground.latitude) / levelOf(ground.longitude - WEST);
    assert.ok(Math.abs(red / green - ratio) < 0.09 * ratio + 0.02, `${x}, ${y}: ${red}, ${green}, ${blue} for a ratio of ${ratio}`);
    compared++;
  }
  assert.ok(compared >= 20, `${compared} places compared`);
}

test("imagery lies where it belongs, however deep its tiles are, and names its owner", async () => {
  await page.goto(`${process.env.TERRAIN_URL}?imagery=${encodeURIComponent(template)}&attribution=Survey%20of%20%3Cb%3ENowhere`);
  await page.waitForFunction(() => window.terrain !== undefined);
  assert.equal(await page.textContent("#attribution"), "Survey of <b>Nowhere");
  for (const [distance, down] of [[40_000, 80], [9000, 60]]) {
    await page.evaluate(([distance, down]) => window.terrain.flyTo(-84.24, 36.3, 400, distance, 20, down), [distance, down]);
    await page.evaluate(() => window.terrain.settled());
    await assertImageryLies();
  }
  assert.ok(asked.length > 8 && new Set(asked.map(({ z }) => z)).size > 1, JSON.stringify(asked.length));
});

test("without tiles that fine, coarser imagery stays", async () => {
  await page.evaluate(() => window.terrain.flyTo(-84.24, 36.3, 400, 400, 20, 60));
  await page.evaluate(() => window.terrain.settled());
  assert.ok(asked.some(({ z }) => z > FINEST), "finer tiles were asked for");
  const image = await pixelsOf(page, { x: 300, y: 200, width: 40, height: 40 });
  assert.ok(image[2] < image[0] / 3 && image[2] < image[1] / 3, `${image.subarray(0, 3)} has no blue`);
});

test("the field of the panel takes imagery away and says what is wrong with an address", async () => {
  await page.fill("#imagery", "");
  await page.press("#imagery", "Enter");
  assert.ok(await page.isHidden("#attribution"));
  assert.equal(await page.evaluate(() => document.querySelector("#style").value), "Elevation");
  assert.ok(!page.url().includes("imagery"));
  await page.fill("#imagery", "https://example.org/{z}/{x}.png");
  await page.press("#imagery", "Enter");
  assert.match(await page.evaluate(() => document.querySelector("#imagery").validationMessage), /has to have \{y\} in it/);
  await page.fill("#imagery", template);
  await page.press("#imagery", "Enter");
  assert.equal(await page.textContent("#attribution"), "Imagery: 127.0.0.1");
  assert.ok(page.url().includes("imagery="));
});

test("where no imagery comes it is said why, in a line, until some comes or none is asked for", async () => {
  const message = async (wanted) => {
    await page.waitForFunction((wanted) => document.querySelector("#message").textContent === wanted, wanted);
    assert.equal(await page.isHidden("#message"), wanted === "");
  };
  const ask = async (address) => {
    await page.fill("#imagery", address);
    await page.press("#imagery", "Enter");
  };
  await page.evaluate(() => window.terrain.flyTo(-84.24, 36.3, 400, 9000, 20, 60));
  refusal = () => 204;
  await ask(`${template}?none`);
  await message("No imagery: its server has no tiles here.");
  refusal = () => 503;
  await ask(`${template}?broken`);
  await message("No imagery: its server answers 503.");
  refusal = () => undefined;
  await message("");
  await ask("http://127.0.0.1:9/{z}/{x}/{y}.png");
  await message("No imagery: its server cannot be reached, or allows no other pages to read it.");
  await ask("");
  await message("");
  assert.ok(complaints.length > 0 && complaints.splice(0).every((text) => /Failed to load resource/.test(text)));
});

const MISSING = 11;

for (const [what, isMissing] of [
  ["here and there", ({ z, x, y }) => z >= MISSING && (x + y) % 2 === 0],
  ["for whole squares", ({ z, x }) => z >= MISSING && (x + 0.5) / 2 ** z > (180 - 84.24) / 360],
]) {
  test(`where tiles are missing ${what} coarser ones are in their place`, async () => {
    refusal = (tile) => (isMissing(tile) ? 404 : undefined);
    asked.length = 0;
    const query = new URLSearchParams({ imagery: `${template}?${what.replaceAll(" ", "-")}` });
    await page.goto(`${process.env.TERRAIN_URL}?${query}#jacksboro_fault`);
    await page.waitForFunction(() => window.terrain !== undefined);
    await page.evaluate(() => window.terrain.flyTo(-84.24, 36.3, 400, 9000, 20, 60));
    await page.evaluate(() => window.terrain.settled());
    await assertImageryLies();
    assert.ok(await page.isHidden("#message"));
    const missing = asked.filter(isMissing).length;
    assert.ok(missing > 8, `${missing} tiles are missing`);
    refusal = () => undefined;
    complaints.splice(0);
  });
}

test("a server that fails gets a request now and then, and its imagery is there when it works again", async () => {
  refusal = () => 503;
  asked.length = 0;
  // Many squares want pictures.
  const query = new URLSearchParams({ imagery: `${template}?down`, pixels: "0.5" });
  await page.goto(`${process.env.TERRAIN_URL}?${query}#jacksboro_fault`);
  await page.waitForFunction(() => document.querySelector("#message").textContent === "No imagery: its server answers 503.");
  await page.evaluate(() => window.terrain.flyTo(-84.24, 36.3, 400, 40_000, 20, 80));
  await page.waitForTimeout(5000);
  console.log({ requestsWhileDown: asked.length });
  assert.ok(asked.length >= 5 && asked.length <= 15, `${asked.length} requests`);
  assert.equal(await page.textContent("#message"), "No imagery: its server answers 503.");
  refusal = () => undefined;
  await page.waitForFunction(() => document.querySelector("#message").hidden);
  await page.evaluate(() => window.terrain.settled());
  await assertImageryLies();
  assert.ok(complaints.splice(0).every((text) => /Failed to load resource/.test(text)));
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
