// Worlds as the program writes them, in the X3D browser X_ITE in headless Chromium, from a server that sends the mesh
// piece by piece. What is drawn is compared with what the library draws of the same file.
// TERRAIN_PROGRAMS: folder of terrain-ingest and terrain-vectors; TERRAIN_SCREENSHOTS: where to leave pictures;
// CHROMIUM: another browser.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { chromium } from "playwright-core";
import { hills } from "./hills.mjs";
import { serve } from "./slow_server.mjs";

const HERE = fileURLToPath(new URL(".", import.meta.url));
const PROGRAMS = process.env.TERRAIN_PROGRAMS ?? join(HERE, "../../target/debug");
const SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const QUIET = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking"];
const VIEWPORT = { width: 640, height: 480 };
/** Of the picture: left of the viewpoint's name, above the slider. */
const CLIP = { x: 0, y: 0, width: 490, height: 430 };
const GEOMORPHS = [0.25, 0.7, 1.5];

const run = promisify(execFile);
let browser, server, folder;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "terrain-world-"));
  server = await serve({ viewer: HERE, made: folder }, ".lod");
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  browser = await chromium.launch({ executablePath, args: [...SOFTWARE_GL, ...QUIET] });
});

after(async () => {
  await browser?.close();
  server?.close();
  if (folder !== undefined) await rm(folder, { recursive: true });
});

/** Makes the world of the hills; returns its mesh as text, and what the library draws of that. */
async function makeWorld(name) {
  const [question, answer, model] = ["question.json", "answer.json", "model.lod"].map((file) => join(folder, file));
  const geomorphs = GEOMORPHS.map((level) => ({ level }));
  await writeFile(question, JSON.stringify({ ...hills(), expected: { geomorphs } }));
  await run(join(PROGRAMS, "terrain-vectors"), [question, "-o", answer]);
  const { expected } = JSON.parse(await readFile(answer, "utf8"));
  await writeFile(model, expected.text);
  await run(join(PROGRAMS, "terrain-ingest"), ["mesh", model, "-o", join(folder, name)]);
  return { text: await readFile(join(folder, "world.lod"), "utf8"), expected };
}

/** Where the levels of a text end, coarsest first: at every other closing brace. */
function levelEnds(text) {
  const braces = [...text.matchAll(/}/g)].map(({ index }) => index + 1);
  return braces.filter((_, index) => index % 2 === 1);
}

/** The corners of triangles as the browser has them: single precision, relative to the origin of the world. */
function cornersOf({ triangles, positions }, origin) {
  const place = (vertex) => positions[vertex].map((coordinate, axis) => Math.fround(coordinate - origin[axis]));
  return triangles.flat().flatMap(place);
}

/** What X_ITE sends to the graphics card, once it has drawn. */
async function drawnCorners(page) {
  return page.evaluate(async () => {
    for (let frame = 0; frame < 2; frame++) await new Promise(requestAnimationFrame);
    const vertices = Array.from(window.world.surface.getValue().getInnerNode().getVertices());
    return vertices.filter((_, index) => index % 4 !== 3);
  });
}

/** The share of the picture that the surface covers, whose colour is warm where the sky's is cold, and in how many shades. */
async function look(page) {
  const png = (await page.screenshot({ clip: CLIP })).toString("base64");
  return page.evaluate(async (base64) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    const warm = [];
    for (let at = 0; at < data.length; at += 4) if (data[at] > data[at + 2]) warm.push(data[at]);
    return { share: (4 * warm.length) / data.length, shades: new Set(warm).size };
  }, png);
}

for (const name of ["world.x3d", "world.wrl"]) {
  describe(name, () => {
    const complaints = [];
    let page, text, expected, origin;

    before(async () => {
      ({ text, expected } = await makeWorld(name));
      page = await browser.newPage({ viewport: VIEWPORT });
      page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
      page.on("pageerror", (error) => complaints.push(error.message));
      await page.goto(`${server.url}/viewer/viewer.html?world=/made/${name}`);
      await page.waitForFunction(() => window.world !== undefined);
      origin = await page.evaluate(() => Array.from(window.world.surface.origin));
    });

    after(() => page?.close());

    const assertDraws = async (lod) => {
      const drawn = await drawnCorners(page);
      assert.equal(drawn.length / 9, lod.triangles.length, "triangles");
      assert.deepEqual(drawn, cornersOf(lod, origin));
    };
    const lod = (level) => ({ triangles: expected.lods[level], positions: expected.positions });
    const assertLooks = async (moment, fewestShades) => {
      const pictures = process.env.TERRAIN_SCREENSHOTS;
      if (pictures !== undefined) await page.screenshot({ path: join(pictures, `${name}-${moment}.png`) });
      const { share, shades } = await look(page);
      console.log({ name, moment, share, shades });
      // Stood on its edge it would cover a third.
      assert.ok(share > 0.2 && share < 0.28, `the surface covers ${share} of the picture`);
      assert.ok(shades >= fewestShades, `only ${shades} shades`);
    };

    test("the surface is refined while the file is on its way", async () => {
      const ends = levelEnds(text);
      assert.ok(ends.length >= 4, `only ${ends.length} levels`);
      assert.ok(server.isAsked());
      const moments = [1, Math.ceil(ends.length / 2), ends.length - 1];
      for (const count of moments) {
        server.sendUpTo(ends[count - 1]);
        await page.waitForFunction((count) => window.world.surface.levelCount_changed === count, count);
        await assertDraws(lod(expected.levels - count));
        await assertLooks(`${count}-levels`, count === 1 ? 2 : 50);
      }
    });

    test("a level can be chosen while the file is on its way", async () => {
      await page.evaluate(() => (window.world.surface.set_level = 1));
      await assertDraws(lod(2));
      server.finish();
      await page.waitForFunction((count) => window.world.surface.levelCount_changed === count, expected.levels);
      await assertDraws(lod(1));
    });

    test("every level is what the library draws", async () => {
      for (let level = 0; level < expected.levels; level++) {
        await page.evaluate((level) => (window.world.surface.set_level = level), level);
        await assertDraws(lod(level));
      }
    });

    test("every geomorph is what the library draws", async () => {
      for (const geomorph of expected.geomorphs) {
        await page.evaluate((level) => (window.world.surface.set_fractional_level = level), geomorph.level);
        await assertDraws(geomorph);
        assert.equal(await page.evaluate(() => window.world.surface.level_changed), geomorph.level);
      }
    });

    test("the slider of the viewer goes from the coarsest level to the finest", async () => {
      await page.fill("input", await page.getAttribute("input", "min"));
      await assertDraws(lod(expected.levels - 1));
      await page.fill("input", "0");
      await assertDraws(lod(0));
      await assertLooks("finest", 50);
    });

    test("the console stays quiet", () => assert.deepEqual(complaints, []));
  });
}
