// Drives the page of curved models in headless Chromium and looks at the pixels.
// TERRAIN_URL: address of a server that has torus.clod; CURVED_SCREENSHOT: where to leave a picture; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launch, messageLike, pixelsOf, quietPage } from "./browser.mjs";

/** Of the picture: right of the panel, above the help. */
const CLIP = { x: 240, y: 0, width: 400, height: 430 };

let browser, page;
const complaints = [];

before(async () => {
  const url = process.env.TERRAIN_URL;
  assert.ok(url, "set TERRAIN_URL to the address of a running terrain-server that has torus.clod");
  browser = await launch();
  page = await quietPage(browser, complaints);
  await page.goto(new URL("curved.html?model=torus", url).href);
  await page.waitForFunction(() => window.curved?.drawn() !== undefined, undefined, { timeout: 20_000 });
});

after(() => browser?.close());

async function drawn() {
  await page.evaluate(() => window.curved.frame());
  return page.evaluate(() => window.curved.drawn());
}

/** Shares of the picture: of the colour of the background, and of dark lines. */
async function shares() {
  await drawn();
  const data = await pixelsOf(page, CLIP);
  const [background, counts] = [data.subarray(0, 3), { background: 0, lines: 0 }];
  for (let at = 0; at < data.length; at += 4) {
    const isNear = (colour) => [0, 1, 2].every((channel) => Math.abs(data[at + channel] - colour[channel]) < 12);
    if (isNear(background)) counts.background++;
    if (isNear([20, 36, 61])) counts.lines++;
  }
  return { background: (4 * counts.background) / data.length, lines: (4 * counts.lines) / data.length };
}

test("the coarsest level is drawn, and the slider draws the finest", async () => {
  const coarse = await drawn();
  const { background } = await shares();
  assert.ok(background > 0.2 && background < 0.85, `${background} of the picture is background`);
  if (process.env.CURVED_SCREENSHOT) await page.screenshot({ path: process.env.CURVED_SCREENSHOT });
  await page.fill("#level", "0");
  const fine = await drawn();
  assert.equal(fine.patches, 576);
  assert.equal(await page.textContent("#patches"), "576");
  assert.ok(coarse.patches < 200 && fine.error < coarse.error);
  assert.ok(Math.abs((await shares()).background - background) < 0.05, "the same model");
});

test("patches are cut finer as the camera comes near", async () => {
  const far = await drawn();
  await page.evaluate(() => window.curved.nearer(4));
  const near = await drawn();
  await page.evaluate(() => window.curved.nearer(0.25));
  assert.equal(near.patches, far.patches);
  assert.ok(near.triangles > 1.9 * far.triangles, `${far.triangles} → ${near.triangles}`);
});

test("the net of control points is shown on demand", async () => {
  const without = await shares();
  await page.check("#net");
  const { lines } = await shares();
  await page.uncheck("#net");
  assert.ok(without.lines < 0.001 && lines > 0.02, `${without.lines} → ${lines}`);
});

test("a file that is dropped and is none is told in a line", async () => {
  await page.evaluate(() => {
    const transfer = new DataTransfer();
    transfer.items.add(new File(["not"], "not.clod"));
    window.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer }));
  });
  await messageLike(page, /^not\.clod: .*(ends too early|no \.clod file)/);
});

test("on a phone what is wrong is told beside the panel, and there is no level to choose", async () => {
  const phone = await browser.newPage({ viewport: { width: 360, height: 640 } });
  await phone.goto(new URL("curved.html?model=none", process.env.TERRAIN_URL).href);
  await messageLike(phone, /^none: there is no such model$/);
  const [panel, message] = await phone.evaluate(() => ["panel", "message"].map((id) => document.getElementById(id).getBoundingClientRect().toJSON()));
  assert.ok((await phone.isDisabled("#level")) && message.height > 0 && message.top > panel.bottom, JSON.stringify({ panel, message }));
  assert.equal(await phone.isVisible("#help"), true);
  await phone.close();
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
