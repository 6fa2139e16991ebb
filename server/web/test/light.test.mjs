// The light of a view that rests, in headless Chromium, beside the light on the raster that the archive was made of.
// TERRAIN_URL: a server whose first archive is of TERRAIN_DEM; TERRAIN_SCREENSHOTS: where to leave pictures; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, pixelsOf, quietPage } from "./browser.mjs";
import { readDem } from "./dem.mjs";

const VIEWPORT = { width: 800, height: 560 };
/** Of the picture: right of the panel. */
const CLIP = { x: 320, y: 40, width: 440, height: 440 };
const STEP = 5;
/** Straight down on the middle, some 45 m a pixel. */
const VIEW = { longitude: -84.2458, latitude: 36.3029, height: 30_000, azimuth: 0, down: 90 };
const SUN = [-0.54, 0.44, 0.72];

let browser, dem;
const complaints = [];

before(async () => {
  dem = await readDem(process.env.TERRAIN_DEM);
  browser = await launch();
});

after(() => browser?.close());

/** A page that shows the view in grey, once its first picture is there. */
async function opened(holdUp = async () => {}) {
  const page = await quietPage(browser, complaints, VIEWPORT);
  const asked = [];
  await page.route("**/gradients/**", async (route) => {
    asked.push(route.request().url());
    await holdUp();
    await route.continue().catch(() => {});
  });
  await page.goto(process.env.TERRAIN_URL);
  await page.waitForFunction(() => window.terrain !== undefined);
  await page.selectOption("#style", { label: "Hillshade" });
  await page.evaluate((view) => window.terrain.setPose(view), VIEW);
  await page.evaluate(() => window.terrain.settled());
  return { page, asked };
}

/** What the sun gives to the ground of the source, as a hillshade has it: by the rise from sample to sample. */
function sunAt([longitude, latitude]) {
  const sample = 1 / 1200;
  const rise = (east, north) => dem(longitude + east, latitude + north) - dem(longitude - east, latitude - north);
  const metres = 2 * sample * 111_000;
  const [east, north] = [rise(sample, 0) / metres / Math.cos((latitude * Math.PI) / 180), rise(0, sample) / metres];
  return Math.max(0, (SUN[2] - SUN[0] * east - SUN[1] * north) / Math.hypot(1, east, north));
}

function correlation(one, other) {
  const [a, b] = [one, other].map((numbers) => numbers.map((number) => number - numbers.reduce((sum, n) => sum + n, 0) / numbers.length));
  const product = (p, q) => p.reduce((sum, n, i) => sum + n * q[i], 0);
  return product(a, b) / Math.sqrt(product(a, a) * product(b, b));
}

test("the light of a view that rests is that of a hillshade", async () => {
  const { page, asked } = await opened();
  const first = { bytes: (await page.evaluate(() => window.terrain.stats())).normalsBytes, requests: asked.length };
  const coarse = await pixelsOf(page, CLIP);
  await page.evaluate(() => window.terrain.rested());
  const fine = await pixelsOf(page, CLIP);
  if (process.env.TERRAIN_SCREENSHOTS) await page.screenshot({ path: join(process.env.TERRAIN_SCREENSHOTS, "light.png") });
  const places = [];
  for (let y = 0; y < CLIP.height; y += STEP) for (let x = 0; x < CLIP.width; x += STEP) places.push([x, y]);
  const ground = await page.evaluate(
    ([places, { x: left, y: top }]) =>
      places.map(([x, y]) => window.terrain.groundAt((2 * (left + x + 0.5)) / innerWidth - 1, 1 - (2 * (top + y + 0.5)) / innerHeight)).map((found) => found && [found.longitude, found.latitude]),
    [places, CLIP],
  );
  const suns = ground.map((place) => (place === undefined ? NaN : sunAt(place)));
  const isKnown = (_, index) => Number.isFinite(suns[index]);
  const greys = (picture) => places.map(([x, y]) => picture[4 * (y * CLIP.width + x)]).filter(isKnown);
  const [before, after] = [coarse, fine].map((picture) => correlation(greys(picture), suns.filter(isKnown)));
  const last = { bytes: (await page.evaluate(() => window.terrain.stats())).normalsBytes, requests: asked.length };
  console.log({ places: suns.filter(isKnown).length, before, after, first, last });
  assert.ok(suns.filter(isKnown).length > 3000);
  assert.ok(after > 0.9 && after > before + 0.05, `${before} → ${after}`);
  await page.waitForTimeout(1500);
  assert.equal(asked.length, last.requests, "then it is done");
  await page.close();
});

/** Turns the view a little each frame, and tells how much of its grey each picture changes on the mean. */
function turned(page, frames) {
  return page.evaluate(
    async ([frames, clip]) => {
      const canvas = document.getElementById("view");
      const context = new OffscreenCanvas(clip.width, clip.height).getContext("2d", { willReadFrequently: true });
      const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
      const pose = window.terrain.pose();
      const changes = [];
      let before;
      await frame();
      for (let at = 0; at < frames; at++) {
        // The first picture is that of before; to ask whether it is settled draws it.
        if (at === 0) void window.terrain.settled();
        else window.terrain.setPose({ ...pose, azimuth: pose.azimuth + 0.004 * at });
        // In the frame that drew it: afterwards the canvas is empty.
        await frame();
        context.drawImage(canvas, -clip.x, -clip.y);
        const { data } = context.getImageData(0, 0, clip.width, clip.height);
        let sum = 0;
        for (let pixel = 0; pixel < data.length; pixel += 4) sum += Math.abs(data[pixel] - (before?.[pixel] ?? data[pixel]));
        if (before !== undefined) changes.push((4 * sum) / data.length);
        before = data;
      }
      return changes;
    },
    [frames, CLIP],
  );
}

function meanChange(one, other) {
  let sum = 0;
  for (let at = 0; at < one.length; at += 4) sum += Math.abs(one[at] - other[at]);
  return (4 * sum) / one.length;
}

test("light does not jump while the view moves: finer light stays, and what comes then waits for the next rest", async () => {
  let isSlow = false;
  const { page, asked } = await opened(() => isSlow && new Promise((resolve) => setTimeout(resolve, 250)));
  isSlow = true;
  const first = asked.length;
  const coming = page.waitForRequest("**/gradients/**", { timeout: 20_000 });
  const coarse = await pixelsOf(page, CLIP);
  await coming;
  const whileItComes = await turned(page, 40);
  const there = asked.length;
  await page.evaluate(() => window.terrain.rested());
  const fine = await pixelsOf(page, CLIP);
  const between = meanChange(coarse, fine);
  const onTheWay = await turned(page, 40);
  const [worst, worstAfter] = [whileItComes, onTheWay].map((changes) => Math.max(...changes));
  console.log({ between, worst, worstAfter, asked: [first, there, asked.length] });
  assert.ok(between > 2, `${between} of 256`);
  assert.ok(worst < between / 3, `${worst} while it comes`);
  assert.ok(worstAfter < between / 3, `${worstAfter} when it goes on`);
  await page.close();
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
