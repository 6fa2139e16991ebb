// Raster tiles of heights of a running server in MapLibre, in headless Chromium: its terrain, and contour lines. Its rasters of normals.
// TERRAIN_URL: the server's address; TERRAIN_DEM: the raster, in WGS 84 degrees, that its first archive was made of;
// TERRAIN_SCREENSHOTS: where to leave pictures; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, quietPage } from "./browser.mjs";
import { offNearby, readDem } from "./dem.mjs";
import { servePages } from "./pages.mjs";

const url = process.env.TERRAIN_URL;
const SETTLE_MILLISECONDS = 100_000;
const VIEW = [-84.25, 36.3];
/** Places on a grid around the middle of the view. */
const PLACES = Array.from({ length: 25 }, (_, i) => [VIEW[0] + 0.02 * (i % 5 - 2), VIEW[1] + 0.02 * (Math.floor(i / 5) - 2)]);
/** A tile of the archive around the middle, and degrees along its side. */
const [ZOOM, X, Y] = [10, 544, 718];
const SIDE = 180 / 2 ** ZOOM;
/** Metres from contour line to contour line. */
const STEP = 100;

let name, dem, pages, browser;

before(async () => {
  assert.ok(url && process.env.TERRAIN_DEM, "set TERRAIN_URL and TERRAIN_DEM");
  [{ name }] = await json(new URL("tilesets", url));
  [dem, pages, browser] = await Promise.all([readDem(process.env.TERRAIN_DEM), servePages(), launch()]);
});

after(async () => {
  await browser?.close();
  pages?.close();
});

async function json(address) {
  return (await fetch(address)).json();
}

for (const encoding of ["terrarium", "mapbox"]) {
  test(`MapLibre has ${encoding} terrain of 512 pixels as lossless WebP, and contours of it, within the claim`, async () => {
    const tiles = new URL(`${name}/${encoding}.json?size=512&format=webp`, url);
    const { tileSize, tiles: [template], maxzoom, zooms } = await json(tiles);
    assert.ok(tileSize === 512 && template.includes(".webp"), template);
    const { error, quantum } = zooms[maxzoom];
    const pixel = 40_075_017 * Math.cos(VIEW[1] * Math.PI / 180) / 2 ** maxzoom / tileSize;
    const complaints = [], page = await quietPage(browser, complaints);
    const address = new URL(`http://127.0.0.1:${pages.address().port}/test/maplibre.html`);
    for (const [key, value] of Object.entries({ tiles, view: VIEW, step: STEP })) address.searchParams.set(key, value);
    await page.goto(address.href);
    await page.waitForFunction("window.ready?.()", undefined, { timeout: SETTLE_MILLISECONDS }).catch((error) => {
      throw new Error(`${error.message}; ${complaints.join("; ")}`);
    });
    if (process.env.TERRAIN_SCREENSHOTS) await page.screenshot({ path: join(process.env.TERRAIN_SCREENSHOTS, `maplibre-${encoding}.png`) });
    const heights = await page.evaluate((places) => window.sample(places), PLACES);
    const sampled = PLACES.map(([x, y], i) => [x, y, heights[i]]);
    const lines = (await page.evaluate(() => window.contours())).filter(([x, y]) => dem(x, y) !== undefined);
    // Between pixels MapLibre interpolates: a height is that of a place less than a pixel away.
    for (const [what, places] of Object.entries({ sampled, lines })) {
      const offs = places.map(([x, y, height]) => offNearby(dem, x, y, height, pixel));
      const worst = Math.max(...offs);
      console.log(`${encoding}: ${places.length} places of ${what}, ${worst.toFixed(2)} m off at most, ${(error + quantum / 2).toFixed(2)} m allowed`);
      assert.ok(worst <= error + quantum / 2, `${what}: ${places[offs.indexOf(worst)]} is ${worst} m off`);
    }
    assert.ok(lines.length > 1000 && lines.every(([, , height]) => height % STEP === 0), `${lines.length} vertices of contours`);
    assert.deepEqual(complaints, []);
    await page.close();
  });
}

/** How like each other two lists of numbers are: 1 where one is a multiple of the other, but for what all have in common. */
function correlation(one, other) {
  const [a, b] = [one, other].map((numbers) => numbers.map((number) => number - numbers.reduce((sum, n) => sum + n, 0) / numbers.length));
  const product = (p, q) => p.reduce((sum, n, i) => sum + n * q[i], 0);
  return product(a, b) / Math.sqrt(product(a, a) * product(b, b));
}

test("rasters of normals are two grey squares, of what the source rises to the east and to the north", async () => {
  const page = await quietPage(browser, []);
  await page.goto(new URL("healthz", url).href);
  for (const format of ["png", "webp"]) {
    const { width, height, greys } = await page.evaluate(async (address) => {
      const image = await createImageBitmap(await (await fetch(address)).blob(), { colorSpaceConversion: "none" });
      const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
      context.drawImage(image, 0, 0);
      const { data } = context.getImageData(0, 0, image.width, image.height);
      return { width: image.width, height: image.height, greys: Array.from({ length: data.length / 4 }, (_, pixel) => data[4 * pixel]) };
    }, `/${name}/gradients/${ZOOM}/${X}/${Y}.${format}`);
    assert.deepEqual([width, height], [129, 258]);
    const [told, expected] = [[[], []], [[], []]];
    for (let row = 4; row < 129; row += 5) {
      for (let column = 4; column < 129; column += 5) {
        const [longitude, latitude] = [(X + column / 128) * SIDE - 180, (Y + 1 - row / 128) * SIDE - 90];
        const reach = SIDE / 128, metres = 2 * reach * 111_000;
        const rise = ([east, north]) => dem(longitude + east, latitude + north) - dem(longitude - east, latitude - north);
        const east = rise([reach, 0]) / metres / Math.cos((latitude * Math.PI) / 180), north = rise([0, reach]) / metres;
        if (!Number.isFinite(east + north)) continue;
        for (const [part, slope] of [east, north].entries()) {
          const root = (greys[(row + 129 * part) * 129 + column] - 128) / 127;
          told[part].push(root * Math.abs(root));
          expected[part].push(-slope / Math.hypot(1, east, north));
        }
      }
    }
    for (const part of [0, 1]) {
      const likeness = correlation(told[part], expected[part]);
      console.log(`${format}, ${part === 0 ? "east" : "north"}: ${told[part].length} normals, like the source's by ${likeness.toFixed(3)}`);
      assert.ok(told[part].length > 300 && likeness > 0.9);
    }
  }
  await page.close();
});
