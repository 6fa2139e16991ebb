// The package as npm packs it, installed beside an archive in a folder that nginx serves. TERRAIN_ARCHIVE: the archive.
// `npm run package` has to have been run.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { cp, copyFile, mkdir, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { promisify } from "node:util";
import { describe, launch, messageLike, pixelsOf, quietPage } from "./browser.mjs";
import { serveByNginx } from "./nginx.mjs";

const run = promisify(execFile);
const HOME = new URL("..", import.meta.url).pathname;
const CLIP = { x: 0, y: 0, width: 640, height: 480 };

let folder, nginx, browser, packed;
const complaints = [];

before(async () => {
  assert.ok(process.env.TERRAIN_ARCHIVE, "set TERRAIN_ARCHIVE to an archive of terrain-ingest");
  folder = await mkdtemp(join(tmpdir(), "terrain-package-"));
  const { stdout } = await run("npm", ["pack", "--json", "--pack-destination", folder], { cwd: HOME });
  [packed] = JSON.parse(stdout);
  const modules = join(folder, "node_modules");
  await mkdir(join(modules, "terrain-viewer"), { recursive: true });
  await run("tar", ["xf", join(folder, packed.filename), "-C", join(modules, "terrain-viewer"), "--strip-components=1"]);
  for (const name of ["three", "pmtiles", "fflate", "@types", "@dimforge", "@tweenjs", "meshoptimizer"]) {
    await cp(join(HOME, "node_modules", name), join(modules, name), { recursive: true });
  }
  await copyFile(process.env.TERRAIN_ARCHIVE, join(folder, "terrain.pmtiles"));
  await copyFile(join(HOME, "example/index.html"), join(folder, "index.html"));
  nginx = await serveByNginx(folder);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await nginx?.stop();
  if (folder !== undefined) await rm(folder, { recursive: true });
});

/** Milliseconds. */
const LONGEST_WAIT = 30_000;

test("the package has the library, its types and a read-me, and nothing of the page", () => {
  const names = packed.files.map(({ path }) => path);
  console.log({ files: names.length, bytes: packed.size, unpacked: packed.unpackedSize });
  const others = names.filter((name) => !/^(package\.json|README\.md|lib\/[a-z_/]+\.(js|wasm|d\.ts))$/.test(name));
  assert.deepEqual(others, []);
  assert.ok(names.includes("lib/index.js") && names.includes("lib/index.d.ts") && names.includes("README.md"));
  assert.ok(!names.some((name) => /hud|main|share|legend/.test(name)), names.join(" "));
});

test("a page of ten lines draws an archive that nginx serves, by ranges of it", async () => {
  const page = await quietPage(browser, complaints);
  await page.goto(nginx.url);
  await page.waitForLoadState("networkidle");
  // What has been loaded may still be on its way to the picture.
  let seen = { colours: 0, groundShare: 0 };
  const isDrawn = () => seen.colours > 1000 && seen.groundShare > 0.15 && seen.groundShare < 0.98;
  for (const end = Date.now() + LONGEST_WAIT; !isDrawn() && Date.now() < end; await page.waitForTimeout(500)) {
    seen = describe(await pixelsOf(page, CLIP));
  }
  assert.ok(page.workers().length > 0, "tiles are decoded beside the page");
  await page.close();
  assert.ok(isDrawn(), `${seen.colours} colours, ${seen.groundShare} ground`);
  const log = await readFile(nginx.log, "utf8");
  const ranges = log.split("\n").filter((line) => line.includes("/terrain.pmtiles"));
  assert.ok(ranges.length > 3 && ranges.every((line) => line.startsWith("206 ")), ranges.join("\n"));
});

test("the page of the server shows the archive from nginx, and says so where there is none", async () => {
  await cp(join(HOME, "dist"), join(folder, "page"), { recursive: true });
  const page = await quietPage(browser, complaints);
  await page.goto(`${nginx.url}page/index.html?archive=../terrain.pmtiles`);
  await page.waitForFunction(() => window.terrain !== undefined);
  await page.evaluate(() => window.terrain.settled());
  const stats = await page.evaluate(() => window.terrain.stats());
  assert.ok(stats.triangles > 1000 && stats.normalsBytes === 0, JSON.stringify(stats));
  assert.equal(await page.textContent("#name"), "terrain");
  assert.ok(await page.isDisabled("#light"), "there are no normals to switch on");
  await page.close();
  const lost = await browser.newPage();
  await lost.goto(`${nginx.url}page/index.html?archive=../nowhere.pmtiles`);
  await messageLike(lost, /^nowhere cannot be read: .*404/);
  await lost.goto(`${nginx.url}page/index.html?archive=index.html`);
  await messageLike(lost, /^index\.html cannot be read/);
  await lost.close();
});

test("where workers are not to be had, the page decodes tiles itself", async () => {
  const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
  await page.route("**/tile_worker*", (route) => route.abort());
  await page.goto(`${nginx.url}page/index.html?archive=../terrain.pmtiles`);
  await page.waitForFunction(() => window.terrain !== undefined);
  await page.evaluate(() => window.terrain.settled());
  assert.ok((await page.evaluate(() => window.terrain.stats())).triangles > 1000);
  await page.close();
});

test("a program in TypeScript that uses it has its types", async () => {
  const source = `import { openArchive, TerrainLayer, type Tileset } from "terrain-viewer";
    import { Scene } from "three";
    const tileset: Tileset = await openArchive("alps.pmtiles");
    const layer = new TerrainLayer(tileset);
    new Scene().add(layer.group);
    export const height: number = layer.frame.position(7, 46, 0).z;
    // @ts-expect-error: a tileset's name is text
    export const wrong: number = tileset.name;`;
  await writeFile(join(folder, "program.ts"), source);
  const options = ["--noEmit", "--strict", "--target", "es2022", "--module", "esnext", "--moduleResolution", "bundler", "--lib", "es2022,dom,dom.iterable"];
  const checked = await run(join(HOME, "node_modules/.bin/tsc"), [...options, "--types", "three", "program.ts"], { cwd: folder }).catch((error) => error);
  assert.equal(checked.stdout, "");
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
