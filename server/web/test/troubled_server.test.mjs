// The page while its server is slow, fails every tenth request, or dies and comes back: the ground stays, and all comes in the end.
// TERRAIN_URL: a terrain-server; TERRAIN_ARCHIVE: an archive, which is read by ranges, too.

import assert from "node:assert/strict";
import { basename, dirname } from "node:path";
import { after, afterEach, before, test } from "node:test";
import { launch, messageLike, quietPage } from "./browser.mjs";
import { serveByNginx } from "./nginx.mjs";
import { troubled } from "./proxy.mjs";

const VIEWPORT = { width: 320, height: 240 };
const SETTLE_MILLISECONDS = 40_000;
/** What browsers themselves say of answers that fail. */
const OF_THE_NETWORK = /^Failed to load resource/;
const isData = (path) => /\.(spt|webp|pmtiles)/.test(path);

let browser, nginx, server, archives, page, undisturbed, undisturbedNearer;
const complaints = [];

before(async () => {
  nginx = await serveByNginx(dirname(process.env.TERRAIN_ARCHIVE));
  [server, archives] = [await troubled(process.env.TERRAIN_URL), await troubled(nginx.url)];
  browser = await launch();
  page = await opened();
  undisturbed = await settled();
  await goNearer();
  undisturbedNearer = await settled();
  await page.close();
});

afterEach(async () => {
  server.trouble = archives.trouble = () => undefined;
  await page.close();
});

after(async () => {
  await browser?.close();
  await Promise.all([server, archives, nginx].map((one) => one?.stop()));
});

/** A page that notes, from its first ground on, when there is none in the middle, and how many pictures it showed. */
async function opened(query = "") {
  page = await quietPage(browser, complaints, VIEWPORT);
  await page.goto(`${server.url}?pixels=1${query}`);
  await page.waitForFunction(() => window.terrain !== undefined);
  await page.evaluate(() => {
    window.seen = { isThere: false, holes: 0, pictures: new Set() };
    setInterval(() => {
      const isThere = window.terrain.groundAt(0, 0) !== undefined;
      if (window.seen.isThere && !isThere) window.seen.holes++;
      window.seen.isThere ||= isThere;
      if (isThere) window.seen.pictures.add(window.terrain.stats().triangles);
    }, 40);
  });
  return page;
}

/** Figures of the view, once everything it needs is loaded and drawn. */
async function settled() {
  const late = new Promise((_, reject) => setTimeout(reject, SETTLE_MILLISECONDS, new Error("never settled")).unref());
  await Promise.race([page.evaluate(() => window.terrain.settled()), late]);
  const { tiles, error } = await page.evaluate(() => window.terrain.stats());
  return { tiles, error };
}

const goNearer = () =>
  page.evaluate(() => {
    const { height, ...pose } = window.terrain.pose();
    window.terrain.setPose({ ...pose, height: 0.6 * height });
  });

async function assertGroundStayed(leastPictures) {
  const { isThere, holes, pictures } = await page.evaluate(() => ({ ...window.seen, pictures: window.seen.pictures.size }));
  console.log({ pictures });
  assert.ok(isThere && holes === 0, `${holes} moments without ground`);
  assert.ok(pictures >= leastPictures, `${pictures} pictures`);
  assert.ok(await page.isHidden("#message"), "no message is left");
}

const SLOW = { delay: 100, bytesPerSecond: 6_000 };

test("from a slow server the picture comes bit by bit, and in the end is that of a quick one", async () => {
  server.trouble = (path) => (path.includes(".spt") ? SLOW : undefined);
  await opened();
  assert.deepEqual(await settled(), undisturbed);
  await assertGroundStayed(3);
});

for (const [name, failure] of [["does not answer", { status: 503 }], ["breaks off", { breaksAfter: 200, bytesPerSecond: 10_000 }]]) {
  test(`a server that ${name} every tenth time is asked again`, async () => {
    let failed = 0;
    server.trouble = (path) => (isData(path) && server.asked % 10 === 0 && ++failed ? failure : undefined);
    await opened();
    assert.deepEqual(await settled(), undisturbed);
    await assertGroundStayed(2);
    assert.ok(failed > 0);
  });
}

test("an archive of which every tenth range breaks off is asked again", async () => {
  archives.trouble = () => (archives.asked > 2 && archives.asked % 10 === 0 ? { breaksAfter: 100, bytesPerSecond: 10_000 } : undefined);
  await opened(`&archive=${archives.url}${basename(process.env.TERRAIN_ARCHIVE)}`);
  const { tiles, error } = await settled();
  assert.deepEqual({ tiles, error }, undisturbed);
  await assertGroundStayed(2);
});

test("while the server is dead the ground stays, also in a new view, and all comes when it is back", async () => {
  server.trouble = (path) => (path.includes(".spt") ? SLOW : undefined);
  await opened();
  await page.waitForFunction(() => window.seen.pictures.size >= 2);
  await server.die();
  server.trouble = () => undefined;
  await goNearer();
  await messageLike(page, /^Tile /);
  await page.waitForTimeout(500);
  await server.comeBack();
  assert.deepEqual(await settled(), undisturbedNearer);
  await assertGroundStayed(3);
});

test("the console has nothing but the network's own complaints", () => {
  assert.deepEqual(complaints.filter((complaint) => !OF_THE_NETWORK.test(complaint)), []);
});
