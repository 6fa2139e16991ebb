// Drives the served page in headless Chromium and looks at the pixels.
// TERRAIN_URL: address of the page; TERRAIN_SCREENSHOT: where to leave the picture; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { chromium } from "playwright-core";

const SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const QUIET = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking"];
/** Of the picture: right of the panel, above the help. */
const CLIP = { x: 240, y: 0, width: 400, height: 430 };
const SETTLE_MILLISECONDS = 120_000;

let browser, page, folder;
const complaints = [];

before(async () => {
  const url = process.env.TERRAIN_URL;
  assert.ok(url, "set TERRAIN_URL to the address of a running terrain-server, for example http://127.0.0.1:8080/");
  folder = await mkdtemp(join(tmpdir(), "terrain-page-"));
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  browser = await chromium.launch({ executablePath, args: [...SOFTWARE_GL, ...QUIET] });
  page = await browser.newPage({ viewport: { width: 640, height: 480 } });
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  await page.goto(url);
  await page.waitForFunction(() => window.terrain !== undefined, undefined, { timeout: 20_000 });
});

after(async () => {
  await browser?.close();
  if (folder !== undefined) await rm(folder, { recursive: true });
});

/** Figures of the view, once everything it needs is loaded and drawn. */
async function settledStats() {
  const late = new Promise((_, reject) => setTimeout(reject, SETTLE_MILLISECONDS, new Error("never settled")).unref());
  await Promise.race([page.evaluate(() => window.terrain.settled()), late]);
  return page.evaluate(() => window.terrain.stats());
}

/** Pixels of the clip as `[r, g, b, a, …]`, decoded by the browser. */
async function pixels() {
  const png = (await page.screenshot({ clip: CLIP })).toString("base64");
  const decoded = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes]));
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    return btoa(Array.from(data, (byte) => String.fromCharCode(byte)).join(""));
  }, png);
  return Buffer.from(decoded, "base64");
}

/** How many colours there are, and the share of pixels that are not the blue-grey of the air. */
function describe(image) {
  const colours = new Set();
  let ground = 0;
  for (let at = 0; at < image.length; at += 4) {
    const [red, green, blue] = image.subarray(at, at + 3);
    colours.add((red << 16) | (green << 8) | blue);
    if (blue < green || blue < red) ground++;
  }
  return { colours: colours.size, groundShare: (4 * ground) / image.length };
}

function changedShare(one, other) {
  let changed = 0;
  for (let at = 0; at < one.length; at += 4) {
    if ([0, 1, 2].some((channel) => Math.abs(one[at + channel] - other[at + channel]) > 16)) changed++;
  }
  return (4 * changed) / one.length;
}

test("the first view shows terrain", async () => {
  const stats = await settledStats();
  await page.screenshot({ path: process.env.TERRAIN_SCREENSHOT ?? join(folder, "page.png") });
  const { colours, groundShare } = describe(await pixels());
  console.log({ ...stats, colours, groundShare });
  assert.ok(stats.tiles > 0 && stats.triangles > 100 && stats.bytes > 1000, JSON.stringify(stats));
  assert.ok(stats.error > 0 && stats.error < 10_000, `certified error ${stats.error}`);
  assert.ok(colours > 1000, `only ${colours} colours`);
  assert.ok(groundShare > 0.15 && groundShare < 0.98, `${groundShare} of the picture is ground`);
});

test("the panel says what is drawn", async () => {
  const { tiles, triangles } = await settledStats();
  assert.equal(await page.textContent("#tiles"), tiles.toLocaleString("en"));
  assert.equal(await page.textContent("#triangles"), triangles.toLocaleString("en"));
  assert.match(await page.textContent("#error"), /^± [\d.]+ m$/);
  assert.ok(await page.isHidden("#message"));
});

test("the panel says what heights are above", async () => {
  const [{ metadata }] = await page.evaluate(() => fetch("tilesets").then((answer) => answer.json()));
  const text = await page.textContent("#heights");
  const { heights_above: above, vertical_datum: datum, geoid } = metadata.source;
  assert.ok(text.startsWith(`Heights above: ${above || datum}`), text);
  assert.ok(!geoid || text.endsWith(`from ${datum} by ${geoid}`), text);
});

test("less error on the screen means more triangles and a smaller certified error", async () => {
  await page.evaluate(() => window.terrain.setMaxPixels(8));
  const coarse = await settledStats();
  await page.evaluate(() => window.terrain.setMaxPixels(1));
  const fine = await settledStats();
  assert.equal(await page.textContent("#pixels-value"), "1 px");
  assert.ok(fine.triangles > 1.5 * coarse.triangles, `${coarse.triangles} → ${fine.triangles} triangles`);
  assert.ok(fine.error < coarse.error, `${coarse.error} → ${fine.error} m`);
});

test("the wireframe switch draws the edges and takes them away again", async () => {
  await settledStats();
  const plain = await pixels();
  await page.check("#wireframe");
  await settledStats();
  const wired = changedShare(plain, await pixels());
  await page.uncheck("#wireframe");
  await settledStats();
  const back = changedShare(plain, await pixels());
  assert.ok(wired > 0.03, `the wireframe changes ${wired} of the picture`);
  assert.ok(back < 0.001, `${back} of the picture stays changed`);
});

test("dragging orbits, and W flies forward", async () => {
  await settledStats();
  const still = await pixels();
  await page.mouse.move(450, 250);
  await page.mouse.down();
  await page.mouse.move(520, 250, { steps: 4 });
  await page.mouse.up();
  await settledStats();
  const turned = await pixels();
  assert.ok(changedShare(still, turned) > 0.1, "the drag changes the picture");
  await page.keyboard.press("f");
  await page.keyboard.down("w");
  await page.waitForTimeout(700);
  await page.keyboard.up("w");
  await settledStats();
  assert.ok(await page.isChecked("#flying"));
  assert.ok(changedShare(turned, await pixels()) > 0.05, "the flight changes the picture");
});

test("a missing server is told in a line", async () => {
  const lost = await browser.newPage();
  await lost.route("**/tilesets", (route) => route.abort());
  await lost.goto(process.env.TERRAIN_URL);
  await lost.waitForSelector("#message:not([hidden])");
  assert.equal(await lost.textContent("#message"), "The terrain server does not answer.");
  await lost.close();
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
