// Links to views, in headless Chromium: the picture that a link leads to is that which was linked.
// TERRAIN_URL: a terrain-server; views are of those of its archives that are there; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launch, quietPage } from "./browser.mjs";

const VIEWPORT = { width: 640, height: 480 };
/** The address follows the last frame by less. */
const REST_MILLISECONDS = 900;
const MOST_PIXELS = 1.5;
/** Places of the canvas where ground is looked for, and directions all around the scene. */
const PLACES = [-0.9, 0, 0.9].flatMap((x) => [-0.9, 0, 0.9].map((y) => [x, y]));
const DIRECTIONS = Array.from({ length: 2000 }, (_, i) => {
  const [z, turn] = [1 - (2 * i + 1) / 2000, i * Math.PI * (3 - Math.sqrt(5))];
  return [Math.sqrt(1 - z * z) * Math.cos(turn), Math.sqrt(1 - z * z) * Math.sin(turn), z];
});

const at = (longitude, latitude, height, azimuth, down) => ({ pose: { longitude, latitude, height, azimuth, down } });
const around = (...place) => ({ place });
const VIEWS = {
  jacksboro_fault: {
    "straight down in the middle": around(-84.2458, 36.3029, 500, 9000, 130, 90),
    "straight down in a corner, as the orbit has it": around(-84.09, 36.43, 500, 9000, 250, 90),
    "straight down in a corner, as the ground has it": at(-84.4, 36.17, 9000, 70, 90),
    "nearly straight down": around(-84.2, 36.35, 500, 9000, 300, 89.9),
    "aslant": around(-84.2, 36.3, 500, 9000, 120, 40),
    "from near": around(-84.2, 36.3, 500, 60, 200, 50),
    "above the horizon": at(-84.2, 36.3, 2000, 215, -20),
    "straight up": at(-84.2, 36.3, 2000, 215, -90),
  },
  vancouver: {
    "straight down in the middle": around(-123, 49.5, 500, 30_000, 310, 90),
    "straight down in a corner, as the orbit has it": around(-123.9, 49.1, 200, 30_000, 40, 90),
    "straight down in a corner, as the ground has it": at(-122.05, 49.95, 20_000, 155, 90),
    "aslant": at(-123.12, 49.3, 6000, 20, 28),
  },
  whole_earth: {
    "straight down on the equator": at(10, 0, 2e6, 30, 90),
    "straight down at a pole": at(40, 89.9, 3e6, 100, 90),
    "straight down on the pole's axis": around(0, 90, 0, 1e7, 70, 90),
    "aslant at the other pole": at(-120, -89, 2e6, 200, 50),
    "along the axis": at(20, 0, 1e6, 0, 0),
    "straight up": at(130, -33, 1e6, 100, -90),
    "aslant": at(-70, -30, 1e6, 340, 45),
  },
};

let browser, names;
const complaints = [];

before(async () => {
  const listed = await fetch(new URL("tilesets", process.env.TERRAIN_URL)).then((answer) => answer.json());
  names = listed.map(({ name }) => name);
  browser = await launch();
});

after(() => browser?.close());

/** Without light, for which nothing here has to wait. */
async function opened(address) {
  const page = await quietPage(browser, complaints, VIEWPORT);
  await page.goto(address);
  await page.waitForFunction(() => window.terrain !== undefined);
  await page.evaluate(() => document.getElementById("light").click());
  return page;
}

for (const [name, views] of Object.entries(VIEWS)) {
  test(`a link to a view of ${name} leads to the same picture, wherever one looks`, async (context) => {
    if (!names.includes(name)) return context.skip(`no archive ${name} is served`);
    const address = new URL(`?pixels=16#${name}`, process.env.TERRAIN_URL).href;
    const [page, other] = [await opened(address), await opened(address)];
    const offs = {};
    for (const [what, view] of Object.entries(views)) {
      // A page behind another one has few frames.
      await page.bringToFront();
      const wanted = await page.evaluate(
        async ([{ pose, place }, rest, places, directions]) => {
          if (pose === undefined) window.terrain.flyTo(...place);
          else window.terrain.setPose(pose);
          await window.terrain.rested();
          await new Promise((resolve) => setTimeout(resolve, rest));
          const ground = places.flatMap(([x, y]) => window.terrain.groundAt(x, y)?.position ?? []);
          const far = directions.map((direction) => direction.map((part) => 1e9 * part)).map(([x, y, z]) => ({ x, y, z }));
          const seen = [...ground, ...far].map(({ x, y, z }) => ({ place: { x, y, z }, pixel: window.terrain.pixelOf({ x, y, z }) }));
          const isInside = ({ pixel }) => pixel !== undefined && pixel[0] >= 0 && pixel[0] <= innerWidth && pixel[1] >= 0 && pixel[1] <= innerHeight;
          return seen.filter(isInside);
        },
        [view, REST_MILLISECONDS, PLACES, DIRECTIONS],
      );
      await other.bringToFront();
      const got = await other.evaluate(
        async ([hash, places]) => {
          const isFollowed = new Promise((resolve) => addEventListener("hashchange", () => setTimeout(resolve), { once: true }));
          location.hash = hash;
          await isFollowed;
          await window.terrain.settled();
          return places.map((place) => window.terrain.pixelOf(place));
        },
        [new URL(page.url()).hash, wanted.map(({ place }) => place)],
      );
      assert.ok(wanted.length > 20, `${what}: ${wanted.length} places`);
      const off = ({ pixel: [x, y] }, index) => (got[index] === undefined ? Infinity : Math.hypot(got[index][0] - x, got[index][1] - y));
      offs[what] = Math.max(...wanted.map(off));
      console.log({ what, link: new URL(page.url()).hash, pixels: offs[what] });
    }
    await page.close();
    await other.close();
    assert.deepEqual(Object.entries(offs).filter(([, pixels]) => pixels > MOST_PIXELS), []);
  });
}

test("the consoles stay quiet", () => assert.deepEqual(complaints, []));
