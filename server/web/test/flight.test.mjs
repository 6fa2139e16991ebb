// A recorded flight over an archive, in the page and in CesiumJS, which gets the same archive as quantized-mesh.
// TERRAIN_URL: a terrain-server. Flights are over those of its archives that are there; TERRAIN_SCREENSHOTS: where to leave pictures,
// then CesiumJS flies along, which takes as long again.
// TERRAIN_KBITS: the line to the terrain, once a page's own program is there, so many kbit/s with 40 ms to the server and back; the
// page then has no light of normals, as CesiumJS has none.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, quietPage } from "./browser.mjs";
import { between, FLIGHTS, FRAMES, VIEWPORT } from "./flights.mjs";
import { serveByNginx } from "./nginx.mjs";

const HOME = new URL("..", import.meta.url).pathname;
const SETTLE_MILLISECONDS = 120_000;
/** How long CesiumJS has to be without a request to be done. */
const REST_MILLISECONDS = 3000;
/** Places of the picture, right of the panel and below the horizon, that ground has to cover. */
const BELOW = [-0.1, 0.3, 0.6, 0.9].flatMap((x) => [-0.15, -0.4, -0.65].map((y) => [x, y]));

let browser, nginx, tilesets, heights;
const complaints = [];

before(async () => {
  const listed = await fetch(new URL("tilesets", process.env.TERRAIN_URL)).then((answer) => answer.json());
  tilesets = listed.map(({ name }) => name);
  heights = Object.fromEntries(listed.map(({ name, metadata }) => [name, metadata.heights]));
  nginx = await serveByNginx(HOME);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await nginx?.stop();
});

const LINE = { offline: false, latency: 40, downloadThroughput: Number(process.env.TERRAIN_KBITS) * 125, uploadThroughput: -1 };

/** Opens an address; where a line is asked for, what the terrain begins with waits for it. Tells from when on time counts. */
async function openedOn(page, address, begins) {
  if (process.env.TERRAIN_KBITS === undefined) {
    const since = performance.now();
    await page.goto(address);
    return since;
  }
  const session = await page.context().newCDPSession(page);
  const waiting = new Promise((resolve) => page.route(begins, resolve));
  await page.goto(address);
  const route = await waiting;
  await page.evaluate(() => document.querySelector("#light:checked")?.click());
  await session.send("Network.emulateNetworkConditions", LINE);
  const since = performance.now();
  await route.continue();
  await page.unroute(begins);
  return since;
}

/** A new page of the terrain from a pose, and the bytes and milliseconds until all that it needs is drawn. */
async function opened(name, start, pixels) {
  const page = await quietPage(browser, complaints, VIEWPORT);
  const link = [start.latitude, start.longitude, start.height, start.azimuth, start.down].join(",");
  const since = await openedOn(page, `${process.env.TERRAIN_URL}?pixels=${pixels}#${name}/${link}`, "**/tilesets");
  await page.waitForFunction(() => window.terrain !== undefined);
  await settled(page);
  const { bytes, normalsBytes, triangles } = await page.evaluate(() => window.terrain.stats());
  return { page, bytes, normalsBytes, triangles, milliseconds: Math.round(performance.now() - since) };
}

async function settled(page) {
  const late = new Promise((_, reject) => setTimeout(reject, SETTLE_MILLISECONDS, new Error("never settled")).unref());
  await Promise.race([page.evaluate(() => window.terrain.settled()), late]);
}

/** The same in CesiumJS. */
async function openedInCesium(name, start, pixels) {
  const page = await quietPage(browser, complaints, VIEWPORT);
  let bytes = 0;
  const sizes = [];
  page.on("requestfinished", (request) => {
    if (request.url().includes(".terrain")) sizes.push(request.sizes().then(({ responseBodySize }) => (bytes += responseBodySize)));
  });
  const query = new URLSearchParams({ tileset: new URL(name, process.env.TERRAIN_URL), pixels, pose: JSON.stringify(start), heights: heights[name] });
  const since = await openedOn(page, `${nginx.url}test/flight_cesium.html?${query}`, "**/layer.json");
  await page.waitForFunction(() => window.isReady && window.isSettled(), undefined, { timeout: SETTLE_MILLISECONDS });
  const milliseconds = Math.round(performance.now() - since - REST_MILLISECONDS);
  await Promise.all(sizes);
  return { page, bytesNow: async () => (await Promise.all(sizes), bytes), bytes, tiles: sizes.length, milliseconds };
}

/** CesiumJS moves; tells the bytes so far and the milliseconds until all that it needs is drawn. */
async function movedInCesium(cesium, moment) {
  const since = performance.now();
  await cesium.page.evaluate((moment) => (window.setPose(moment), window.moved()), moment);
  await cesium.page.waitForFunction(() => window.isSettled(), undefined, { timeout: SETTLE_MILLISECONDS });
  const cesiumMilliseconds = Math.round(performance.now() - since - REST_MILLISECONDS);
  return { cesiumBytes: await cesium.bytesNow(), cesiumMilliseconds };
}

/** Flies from moment to moment, a pose a frame, and counts places without ground. */
async function fly(page, poses) {
  return page.evaluate(
    async ([poses, places]) => {
      const holes = [];
      const started = performance.now();
      for (const [frame, pose] of poses.entries()) {
        window.terrain.setPose(pose);
        await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
        for (const [x, y] of places) if (window.terrain.groundAt(x, y) === undefined) holes.push([frame, x, y]);
      }
      return { holes, millisecondsOfFrame: Math.round((performance.now() - started) / poses.length) };
    },
    [poses, BELOW],
  );
}

for (const [place, moments] of Object.entries(FLIGHTS)) {
  test(`a flight over ${place} shows ground wherever there is some`, async (context) => {
    const name = tilesets.find((tileset) => tileset.startsWith(place));
    if (name === undefined) return context.skip(`no archive of ${place} is served`);
    const { page } = await opened(name, moments[0], 2);
    const screenshots = process.env.TERRAIN_SCREENSHOTS;
    const cesium = screenshots === undefined ? undefined : await openedInCesium(name, moments[0], 2);
    for (const [at, moment] of moments.entries()) {
      if (at > 0) {
        const poses = Array.from({ length: FRAMES }, (_, frame) => between(moments[at - 1], moment, (frame + 1) / FRAMES));
        const { holes, millisecondsOfFrame } = await fly(page, poses);
        assert.deepEqual(holes.slice(0, 5), [], `on the way to moment ${at}`);
        console.log({ moment: at, millisecondsOfFrame });
      }
      const since = performance.now();
      await settled(page);
      const ours = { ...(await page.evaluate(() => window.terrain.stats())), milliseconds: Math.round(performance.now() - since) };
      console.log({ moment: at, tiles: ours.tiles, triangles: ours.triangles, error: ours.error, bytes: ours.bytes, normalsBytes: ours.normalsBytes,
        milliseconds: ours.milliseconds, ...(cesium && (await movedInCesium(cesium, moment))) });
      assert.ok(ours.triangles > 100 && ours.bytes > 1000, JSON.stringify(ours));
      for (const [x, y] of BELOW) assert.ok(await page.evaluate(([x, y]) => window.terrain.groundAt(x, y) !== undefined, [x, y]), `moment ${at}: ${x}, ${y}`);
      if (cesium !== undefined) {
        await page.screenshot({ path: join(screenshots, `${name}-${at}.png`) });
        await cesium.page.screenshot({ path: join(screenshots, `${name}-${at}-cesium.png`) });
      }
    }
    await page.close();
    await cesium?.page.close();
  });

  test(`the first picture of ${place} takes fewer bytes than in CesiumJS`, async (context) => {
    const name = tilesets.find((tileset) => tileset.startsWith(place));
    if (name === undefined) return context.skip(`no archive of ${place} is served`);
    for (const pixels of [16, 2]) {
      const ours = await opened(name, moments[1], pixels);
      const cesium = await openedInCesium(name, moments[1], pixels);
      console.log({ place, pixels, bytes: ours.bytes, normalsBytes: ours.normalsBytes, milliseconds: ours.milliseconds,
        cesiumBytes: cesium.bytes, cesiumTiles: cesium.tiles, cesiumMilliseconds: cesium.milliseconds });
      await ours.page.close();
      await cesium.page.close();
      assert.ok(ours.bytes > 0 && cesium.bytes > 0);
      assert.ok(ours.bytes < cesium.bytes, `${pixels} px: ${ours.bytes} and ${cesium.bytes} bytes`);
    }
  });
}

test("the consoles stay quiet", () => assert.deepEqual(complaints, []));
