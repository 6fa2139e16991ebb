// An archive that is replaced while a page shows it. TERRAIN_SERVER: the program; TERRAIN_ARCHIVE: an archive, beside which there is one of
// the same ground whose name ends in "_coarse". The page itself comes from TERRAIN_URL.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { copyFile, mkdtemp, rename, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch } from "./browser.mjs";
import { serveByNginx } from "./nginx.mjs";

const ARCHIVE = process.env.TERRAIN_ARCHIVE;
const OTHER = ARCHIVE.replace(/\.pmtiles$/, "_coarse.pmtiles");
let browser, folder;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "terrain-replaced-"));
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await rm(folder, { recursive: true });
});

const put = (archive) => copyFile(archive, join(folder, "new")).then(() => rename(join(folder, "new"), join(folder, "ground.pmtiles")));

/** A page that shows little of the archive, for which this then is another one, and then wants more. */
async function toldAfterReplacing(query, hasChanged) {
  await put(ARCHIVE);
  await hasChanged();
  const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
  await page.goto(`${process.env.TERRAIN_URL}?pixels=16&${query}`);
  await page.waitForFunction(() => window.terrain !== undefined);
  await page.evaluate(() => window.terrain.settled());
  const { tiles } = await page.evaluate(() => window.terrain.stats());
  assert.ok(await page.isHidden("#message"));
  await put(OTHER);
  await hasChanged();
  await page.evaluate(() => window.terrain.setMaxPixels(0.5));
  await page.waitForSelector("#message:not([hidden])");
  const told = await page.textContent("#message");
  assert.ok((await page.evaluate(() => window.terrain.stats())).tiles >= tiles, "what was drawn stays");
  await page.close();
  return told;
}

test("a page is told that its server has another archive of that name", async () => {
  const server = spawn(process.env.TERRAIN_SERVER, [folder, "--listen", "127.0.0.1:0", "--look-every", "1"], { stdio: ["ignore", "pipe", "pipe"] });
  try {
    let said = "";
    for (const stream of [server.stdout, server.stderr]) stream.on("data", (part) => (said += part));
    while (!/http:\/\/127\.0\.0\.1:\d+/.test(said)) await new Promise((resolve) => setTimeout(resolve, 50));
    const [url] = /http:\/\/127\.0\.0\.1:\d+/.exec(said);
    let before;
    const hasChanged = async () => {
      for (;;) {
        const [tileset] = await fetch(`${url}/tilesets`).then((answer) => answer.json());
        if (tileset !== undefined && tileset.version !== before) return void (before = tileset.version);
        await new Promise((resolve) => setTimeout(resolve, 100));
      }
    };
    assert.match(await toldAfterReplacing(`server=${url}/`, hasChanged), /^Tile .*: the server has another archive of this name by now: load the page again$/);
  } finally {
    server.kill();
    await once(server, "exit");
  }
});

test("a page is told that an archive on a web server is another one", async () => {
  const nginx = await serveByNginx(folder, { "Access-Control-Allow-Origin": "*", "Access-Control-Expose-Headers": "ETag" });
  try {
    const told = await toldAfterReplacing(`archive=${nginx.url}ground.pmtiles`, async () => {});
    assert.match(told, /^Tile .*: the archive is another one by now: load the page again$/);
  } finally {
    await nginx.stop();
  }
});
