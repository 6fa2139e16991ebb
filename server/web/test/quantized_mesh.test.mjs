// Quantized-mesh of a running server in CesiumJS, in headless Chromium: in both projections, with rows from either end.
// TERRAIN_URL: the server's address; TERRAIN_DEM: the raster, in WGS 84 degrees, that its first archive was made of;
// TERRAIN_SCREENSHOTS: where to leave pictures; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, quietPage } from "./browser.mjs";
import { offNearby, PLACES, readDem } from "./dem.mjs";
import { servePages } from "./pages.mjs";

const url = process.env.TERRAIN_URL;
const SETTLE_MILLISECONDS = 100_000;

let name, metadata, dem, pages, browser;

before(async () => {
  assert.ok(url && process.env.TERRAIN_DEM, "set TERRAIN_URL and TERRAIN_DEM");
  [{ name, metadata }] = await fetch(new URL("tilesets", url)).then((answer) => answer.json());
  dem = await readDem(process.env.TERRAIN_DEM);
  pages = await servePages();
  browser = await launch();
});

after(async () => {
  await browser?.close();
  pages?.close();
});

for (const path of ["", "?scheme=slippyMap", "/mercator", "/mercator?scheme=slippyMap"]) {
  test(`CesiumJS draws NAME${path} and samples heights within the claim`, async () => {
    const complaints = [], wrong = [];
    const page = await quietPage(browser, complaints);
    page.on("response", (response) => response.status() >= 400 && wrong.push(response.url()));
    const address = new URL(`http://127.0.0.1:${pages.address().port}/test/cesium.html`);
    address.searchParams.set("tileset", new URL(`${name}${path}`, url));
    address.searchParams.set("view", "-84.27,36.30");
    await page.goto(address.href);
    await page.waitForFunction("window.ready?.()", undefined, { timeout: SETTLE_MILLISECONDS }).catch((error) => {
      throw new Error(`${error.message}; ${complaints.join("; ")}`);
    });
    await page.waitForTimeout(3000);
    await page.waitForFunction("window.ready()", undefined, { timeout: SETTLE_MILLISECONDS });
    if (process.env.TERRAIN_SCREENSHOTS) {
      await page.screenshot({ path: join(process.env.TERRAIN_SCREENSHOTS, `quantized_mesh${path.replace(/\W/g, "_")}.png`) });
    }
    const heights = await page.evaluate((places) => window.sample(places), PLACES);
    const { finest_error } = metadata.zooms.at(-1);
    // Coordinates are rounded to a 32,767th of the tile; where data and bare ground share a tile, so are heights over a kilometre.
    const step = 180 / 2 ** metadata.max_zoom * 111_000 / 32_767;
    let worst = 0;
    for (const [i, [longitude, latitude]] of PLACES.entries()) {
      worst = Math.max(worst, offNearby(dem, longitude, latitude, heights[i], 2 * step));
    }
    console.log(`NAME${path}: ${worst.toFixed(2)} m off at most, ${finest_error} m claimed`);
    assert.ok(worst <= finest_error + 0.5, `${worst} m`);
    assert.deepEqual([complaints, wrong], [[], []]);
    await page.close();
  });
}
