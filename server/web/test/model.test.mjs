// Drives the page of progressive meshes in headless Chromium and looks at the pixels.
// TERRAIN_URL: address of a server that has open_torus.spm; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";
import { changedShare, launch, messageLike, pixelsOf, quietPage } from "./browser.mjs";

const URL_OF_MODEL = () => new URL("model.html?model=open_torus", process.env.TERRAIN_URL).href;
/** Of the picture: beside the panel, above the slider, inside the outline of what has the focus. */
const CLIP = { x: 240, y: 8, width: 392, height: 392 };
/** Triangles of the levels, as `terrain-ingest info` tells them, the finest first. */
const TRIANGLES = [1516, 758, 378, 188, 94, 47, 23, 19];

let browser, page;
const complaints = [];

before(async () => {
  assert.ok(process.env.TERRAIN_URL, "set TERRAIN_URL to the address of a running terrain-server that has open_torus.spm");
  browser = await launch();
  page = await quietPage(browser, complaints);
  await page.goto(URL_OF_MODEL());
  await isShown(page);
});

after(() => browser?.close());

const isShown = (shown) => shown.waitForFunction(() => window.model?.drawn() !== undefined);

async function drawn() {
  await page.evaluate(() => window.model.frame());
  return page.evaluate(() => window.model.drawn());
}

async function pixels() {
  await drawn();
  return pixelsOf(page, CLIP);
}

/** Drops a file on the page, and tells what the page says of it. */
async function drop(bytes, name) {
  await page.evaluate(
    ({ base64, name }) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([Uint8Array.from(atob(base64), (character) => character.charCodeAt(0))], name));
      window.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer }));
    },
    { base64: Buffer.from(bytes).toString("base64"), name },
  );
}

test("each level has its triangles, and an error that grows with the level", async () => {
  const errors = [];
  for (const [level, triangles] of TRIANGLES.entries()) {
    await page.fill("#level", String(level));
    const now = await drawn();
    assert.deepEqual([now.level, now.triangles], [level, triangles]);
    const [, told] = /triangles, ± (\S+)$/.exec(await page.textContent("#level-text"));
    assert.ok((await page.textContent("#level-text")).startsWith(`Level ${level} of 7: ${triangles.toLocaleString("en")} triangles`));
    assert.ok(Number(told) >= now.error && Number(told) < 1.02 * now.error, `${told} for ${now.error}`);
    errors.push(now.error);
  }
  assert.ok(errors.every((error, at) => at === 0 || error > errors[at - 1]), String(errors));
});

test("levels look alike where they are close, and not where they are far", async () => {
  const pictures = [];
  for (const level of [0, 2, 7]) {
    await page.fill("#level", String(level));
    pictures.push(await pixels());
  }
  const empty = Buffer.alloc(pictures[0].length);
  for (let at = 0; at < empty.length; at++) empty[at] = pictures[0][at % 4];
  const [own, near, far] = [empty, pictures[1], pictures[2]].map((other) => changedShare(pictures[0], other));
  assert.ok(own > 0.2 && own < 0.8, `${own} of the picture is the model`);
  assert.ok(far > 2 * near, `${near} of the picture differ, then ${far}`);
});

test("keys change the level, show edges and turn the page dark; a drag turns the model", async () => {
  await page.fill("#level", "3");
  await page.focus("#view");
  await page.keyboard.press("PageUp");
  assert.equal((await drawn()).level, 2);
  await page.keyboard.press("PageDown");
  assert.equal((await drawn()).level, 3);
  const before = await pixels();
  await page.keyboard.press("x");
  const withEdges = await pixels();
  await page.keyboard.press("x");
  assert.ok(changedShare(before, withEdges) > 0.01, "edges are drawn");
  await page.keyboard.press("b");
  const dark = await pixels();
  await page.keyboard.press("b");
  assert.ok(dark[0] < 80 && before[0] > 200, `background ${before[0]}, dark ${dark[0]}`);
  await page.mouse.move(440, 200);
  await page.mouse.down();
  await page.mouse.move(520, 240);
  await page.mouse.up();
  assert.ok(changedShare(before, await pixels()) > 0.05, "the model was turned");
});

test("as the view needs it the model has more triangles the nearer it is, and those of a level again after that", async () => {
  await page.fill("#level", "0");
  await page.focus("#view");
  await page.keyboard.press("v");
  const settled = async () => {
    for (;;) {
      const now = await drawn();
      if (now.isSettled) return now;
    }
  };
  await page.fill("#within", "3");
  const figures = [];
  for (const factor of [0.2, 5, 2]) {
    await page.evaluate((factor) => window.model.nearer(factor), factor);
    figures.push(await settled());
  }
  const [far, middle, near] = figures.map(({ triangles }) => triangles);
  assert.ok(far < middle && middle < near && near < TRIANGLES[0], `${far}, ${middle}, ${near}`);
  assert.equal(await page.textContent("#within-text"), `Within 8 px: ${near.toLocaleString("en")} of 1,516 triangles`);
  assert.ok(figures.every(({ changes, bytes }) => changes > 0 && bytes > 0), JSON.stringify(figures));
  await page.evaluate(() => window.model.nearer(1 / 2));
  assert.equal((await settled()).triangles, middle, "what is drawn depends on the view alone");
  const ofView = await pixels();
  await page.keyboard.press("PageDown");
  const coarser = await settled();
  assert.ok(coarser.within === 16 && coarser.triangles < middle, JSON.stringify(coarser));
  await page.keyboard.press("PageUp");
  await page.keyboard.press("v");
  assert.deepEqual(await page.evaluate(() => ["by-level", "as-needed"].map((id) => document.getElementById(id).hidden)), [false, true]);
  assert.equal((await drawn()).triangles, TRIANGLES[0]);
  const finest = await pixels();
  assert.ok(changedShare(ofView, finest) < 0.25, "it looks like the finest level");
  await page.keyboard.press("r");
});

test("what is no model, damaged or too large is told in a line, and the model before it stays", async () => {
  const bytes = await readFile("../../codec/golden/open_torus.spm");
  const damaged = Buffer.from(bytes);
  damaged.fill(255, 300, 400);
  for (const [file, name, message] of [
    [Buffer.from("solid"), "not.spm", /^not\.spm: not a progressive mesh file/],
    [bytes.subarray(0, 2000), "cut.spm", /^cut\.spm: truncated at byte 2000/],
    [damaged, "damaged.spm", /^damaged\.spm: /],
  ]) {
    await drop(file, name);
    await messageLike(page, message);
    assert.equal((await drawn()).triangles, TRIANGLES[0]);
  }
  await page.evaluate(() => {
    const event = new Event("drop");
    event.dataTransfer = { files: [{ name: "huge.spm", size: 2 ** 30 }] };
    window.dispatchEvent(event);
  });
  await messageLike(page, /^huge\.spm: 1024 MB are too large/);
  await drop(bytes, "again.spm");
  await page.waitForFunction(() => document.getElementById("name").textContent === "again.spm");
  assert.ok(await page.isHidden("#message"));
});

test("a model of another address is opened, and what is missing is told", async () => {
  const shown = await quietPage(browser, []);
  await shown.goto(new URL("model.html?url=open_torus%2Fmodel.spm", process.env.TERRAIN_URL).href);
  await isShown(shown);
  assert.equal(await shown.textContent("#name"), "model.spm");
  await shown.goto(new URL("model.html?model=nothing", process.env.TERRAIN_URL).href);
  await messageLike(shown, /^nothing: there is no such model$/);
  await shown.close();
});

test("the help of both pages of models names the mouse, keys and fingers", async () => {
  const curved = await quietPage(browser, complaints);
  await curved.goto(new URL("curved.html?model=torus", process.env.TERRAIN_URL).href);
  for (const shown of [page, curved]) {
    const help = await shown.textContent("#help");
    assert.ok(["drag", "wheel", "arrows", "one finger: orbit", "two fingers: move", "two fingers: zoom"].every((word) => help.includes(word)), help);
  }
  await curved.close();
});

test("on a phone nothing covers anything else, and a finger turns the model", async () => {
  const phone = await browser.newPage({ viewport: { width: 360, height: 640 }, hasTouch: true });
  await phone.goto(URL_OF_MODEL());
  await isShown(phone);
  const boxes = await phone.evaluate(() => ["panel", "levels"].map((id) => document.getElementById(id).getBoundingClientRect().toJSON()));
  assert.ok(boxes[0].bottom < boxes[1].top && boxes.every(({ left, right, bottom }) => left >= 0 && right <= 360 && bottom <= 640), JSON.stringify(boxes));
  const before = await pixelsOf(phone, { x: 0, y: 100, width: 360, height: 400 });
  const session = await phone.context().newCDPSession(phone);
  const touch = (type, touchPoints) => session.send("Input.dispatchTouchEvent", { type, touchPoints });
  await touch("touchStart", [{ x: 180, y: 300 }]);
  for (const x of [200, 230, 260]) await touch("touchMove", [{ x, y: 320 }]);
  await touch("touchEnd", []);
  await phone.evaluate(() => window.model.frame());
  assert.ok(changedShare(before, await pixelsOf(phone, { x: 0, y: 100, width: 360, height: 400 })) > 0.05);
  await phone.close();
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
