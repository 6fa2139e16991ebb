// Drives the served page in headless Chromium and looks at the pixels.
// TERRAIN_URL: address of the page; TERRAIN_SCREENSHOT: where to leave the picture; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { changedShare, describe, launch, messageLike, pixelsOf, placeText, quietPage } from "./browser.mjs";

/** Of the picture: right of the panel, above the help. */
const CLIP = { x: 240, y: 0, width: 400, height: 430 };
const SETTLE_MILLISECONDS = 120_000;

let browser, page, folder;
const complaints = [];

before(async () => {
  const url = process.env.TERRAIN_URL;
  assert.ok(url, "set TERRAIN_URL to the address of a running terrain-server, for example http://127.0.0.1:8080/");
  folder = await mkdtemp(join(tmpdir(), "terrain-page-"));
  browser = await launch();
  page = await quietPage(browser, complaints);
  await page.goto(url);
  await page.waitForFunction(() => window.terrain !== undefined, undefined, { timeout: 20_000 });
});

after(async () => {
  await browser?.close();
  if (folder !== undefined) await rm(folder, { recursive: true });
});

/** Figures of the view, once everything it needs is loaded and drawn. */
async function settledStats() {
  const late = new Promise((_, reject) => setTimeout(reject, SETTLE_MILLISECONDS, new Error("never settled")).unref());
  await Promise.race([page.evaluate(() => window.terrain.settled()), late]);
  return page.evaluate(() => window.terrain.stats());
}

const pixels = () => pixelsOf(page, CLIP);

test("the first view shows terrain", async () => {
  const stats = await settledStats();
  await page.screenshot({ path: process.env.TERRAIN_SCREENSHOT ?? join(folder, "page.png") });
  const { colours, groundShare } = describe(await pixels());
  console.log({ ...stats, colours, groundShare });
  assert.ok(stats.tiles > 0 && stats.triangles > 100 && stats.bytes > 1000, JSON.stringify(stats));
  assert.ok(stats.error > 0 && stats.error < 10_000, `certified error ${stats.error}`);
  assert.ok(colours > 1000, `only ${colours} colours`);
  assert.ok(groundShare > 0.15 && groundShare < 0.98, `${groundShare} of the picture is ground`);
});

test("the panel says what is drawn", async () => {
  const { tiles, triangles } = await settledStats();
  assert.equal(await page.textContent("#tiles"), tiles.toLocaleString("en"));
  assert.equal(await page.textContent("#triangles"), triangles.toLocaleString("en"));
  assert.match(await page.textContent("#error"), /^± [\d.]+ m$/);
  assert.ok(await page.isHidden("#message"));
});

test("the panel says what heights are above", async () => {
  const [{ metadata }] = await page.evaluate(() => fetch("tilesets").then((answer) => answer.json()));
  const text = await page.textContent("#heights");
  const { heights_above: above, vertical_datum: datum, geoid } = metadata.source;
  assert.ok(text.startsWith(`Heights above: ${above || datum}`), text);
  assert.ok(!geoid || text.endsWith(`from ${datum} by ${geoid}`), text);
});

test("less error on the screen means more triangles and a smaller certified error", async () => {
  await page.evaluate(() => window.terrain.setMaxPixels(8));
  const coarse = await settledStats();
  await page.evaluate(() => window.terrain.setMaxPixels(1));
  const fine = await settledStats();
  assert.equal(await page.textContent("#pixels-value"), "1 px");
  assert.ok(fine.triangles > 1.5 * coarse.triangles, `${coarse.triangles} → ${fine.triangles} triangles`);
  assert.ok(fine.error < coarse.error, `${coarse.error} → ${fine.error} m`);
});

test("the wireframe switch draws the edges and takes them away again", async () => {
  await settledStats();
  await page.evaluate(() => window.terrain.rested());
  const plain = await pixels();
  await page.check("#wireframe");
  await settledStats();
  const wired = changedShare(plain, await pixels());
  await page.uncheck("#wireframe");
  await settledStats();
  const back = changedShare(plain, await pixels());
  assert.ok(wired > 0.03, `the wireframe changes ${wired} of the picture`);
  assert.ok(back < 0.001, `${back} of the picture stays changed`);
});

test("dragging orbits, and W flies forward", async () => {
  await settledStats();
  const still = await pixels();
  await page.mouse.move(450, 250);
  await page.mouse.down();
  await page.mouse.move(520, 250, { steps: 4 });
  await page.mouse.up();
  await settledStats();
  const turned = await pixels();
  assert.ok(changedShare(still, turned) > 0.1, "the drag changes the picture");
  await page.keyboard.press("f");
  await page.keyboard.down("w");
  await page.waitForTimeout(700);
  await page.keyboard.up("w");
  await settledStats();
  assert.ok(await page.isChecked("#flying"));
  assert.ok(changedShare(turned, await pixels()) > 0.05, "the flight changes the picture");
});

/** Turns the wheel over the middle, without waiting for frames in between. */
const turnWheel = (turns, deltaY) =>
  page.evaluate(
    ([turns, deltaY]) => {
      const canvas = document.querySelector("#view");
      const wheel = { deltaY, clientX: canvas.clientWidth / 2, clientY: canvas.clientHeight / 2, cancelable: true };
      for (let turn = 0; turn < turns; turn++) canvas.dispatchEvent(new WheelEvent("wheel", wheel));
    },
    [turns, deltaY],
  );

/** Looks at the middle of the data as at first, without flying. */
async function startAnew() {
  if (await page.isChecked("#flying")) await page.uncheck("#flying");
  await page.keyboard.press("r");
  return settledStats();
}

test("far away the terrain is not lost in haze", async () => {
  await startAnew();
  await turnWheel(25, 100);
  await settledStats();
  const { groundShare } = describe(await pixels());
  assert.ok(groundShare > 0.005, `${groundShare} of the picture is ground`);
});

/** Leads down by the wheel and then by flying, and tells how far above ground each ends. */
async function descend() {
  await startAnew();
  // Each turn leaves 0.95 of the distance: these lead from tens of kilometres to metres, and finer ground comes in between.
  for (let times = 0; times < 3; times++) {
    await turnWheel(60, -100);
    await settledStats();
  }
  const zoomed = await page.evaluate(() => window.terrain.metresAboveGround());
  await page.keyboard.press("f");
  await page.keyboard.down("q");
  await page.waitForTimeout(3000);
  await page.keyboard.up("q");
  await settledStats();
  return { zoomed, flown: await page.evaluate(() => window.terrain.metresAboveGround()) };
}

test("neither the wheel nor a flight leads below the ground, whatever heights are above", async () => {
  const [first, ...others] = await page.evaluate(() => fetch("tilesets").then((answer) => answer.json()));
  for (const { name } of [first, ...others.filter((other) => other.name.endsWith("_ellipsoid"))]) {
    if (name !== first.name) await page.selectOption("#tileset", name);
    const { zoomed, flown } = await descend();
    assert.ok(zoomed > 1.9 && zoomed < 10, `${name}: ${zoomed} m above ground after zooming in`);
    assert.ok(flown > 1.9 && flown < 1000, `${name}: ${flown} m above ground after flying down`);
  }
  if (others.length > 0) await page.selectOption("#tileset", first.name);
});

test("arrows move the view, + and - bring it nearer and farther", async () => {
  await startAnew();
  await page.focus("#view");
  const poses = [await page.evaluate(() => window.terrain.pose())];
  for (const key of ["ArrowUp", "+", "-"]) {
    await page.keyboard.press(key);
    await settledStats();
    poses.push(await page.evaluate(() => window.terrain.pose()));
  }
  const [first, moved, nearer, farther] = poses;
  assert.ok(moved.latitude > first.latitude, "up is forward");
  assert.ok(nearer.height < moved.height - 100, `${moved.height} → ${nearer.height} m`);
  assert.ok(farther.height > nearer.height + 100, `${nearer.height} → ${farther.height} m`);
});

test("the height under the pointer is that of the server, within both errors", async () => {
  await startAnew();
  await page.mouse.move(420, 260);
  const text = await placeText(page);
  assert.match(text, /^[\d.]+° N, [\d.]+° W: [\d.]+ ± [\d.]+ m above /);
  const ground = await page.evaluate(() => window.terrain.groundAt(420 / 320 - 1, 1 - 260 / 240));
  const [{ name }] = await page.evaluate(() => fetch("tilesets").then((answer) => answer.json()));
  const query = `${name}/height?longitude=${ground.longitude}&latitude=${ground.latitude}`;
  const { points } = await page.evaluate((query) => fetch(query).then((answer) => answer.json()), query);
  const difference = Math.abs(points[0].height - ground.height);
  console.log({ text, difference });
  assert.ok(difference <= ground.error + points[0].error + 0.01, `${difference} m`);
});

test("however often the pointer moves before a frame, one place is told: the newest", async () => {
  await startAnew();
  await page.mouse.move(420, 260);
  const newest = await placeText(page);
  await page.mouse.move(300, 200);
  await placeText(page);
  const told = await page.evaluate(async () => {
    const [canvas, place] = ["view", "place"].map((id) => document.getElementById(id));
    const texts = [];
    new MutationObserver((changes) => changes.forEach(() => texts.push(place.textContent))).observe(place, { childList: true });
    for (let at = 12; at-- > 0;) canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: 420 - 5 * at, clientY: 260 }));
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    return texts;
  });
  assert.deepEqual(told, [newest]);
});

test("a link leads to the same view", async () => {
  await page.evaluate(() => window.terrain.flyTo(-84.2, 36.3, 500, 9000, 120, 40));
  await settledStats();
  await page.waitForTimeout(1000);
  const wanted = await page.evaluate(() => window.terrain.pose());
  const other = await browser.newPage({ viewport: { width: 640, height: 480 } });
  await other.goto(page.url());
  await other.waitForFunction(() => window.terrain !== undefined);
  const got = await other.evaluate(() => window.terrain.pose());
  await other.close();
  for (const [part, most] of Object.entries({ longitude: 1e-5, latitude: 1e-5, height: 1, azimuth: 0.1, down: 0.1 })) {
    assert.ok(Math.abs(got[part] - wanted[part]) < most, `${part}: ${wanted[part]} → ${got[part]}`);
  }
});

test("a link that only names an archive opens it as it is first seen; an unknown name is said to be", async () => {
  const names = await page.evaluate(() => fetch("tilesets").then((answer) => answer.json())).then((list) => list.map(({ name }) => name));
  const other = await quietPage(browser, complaints);
  const shown = async () => {
    await other.evaluate(() => window.terrain.settled());
    const pose = await other.evaluate(() => window.terrain.pose());
    return [await other.textContent("#name"), ...Object.values(pose).map((number) => number.toFixed(6))];
  };
  await other.goto(process.env.TERRAIN_URL);
  await other.waitForFunction(() => window.terrain !== undefined);
  await other.selectOption("#tileset", names[1]);
  const wanted = await shown();
  await other.goto("about:blank");
  await other.goto(new URL(`#${names[1]}`, process.env.TERRAIN_URL).href);
  await other.waitForFunction(() => window.terrain !== undefined);
  assert.deepEqual(await shown(), wanted);
  assert.ok(await other.isHidden("#message"));
  // The page is there already: only its address changes.
  await other.goto(new URL("#nowhere", process.env.TERRAIN_URL).href);
  await messageLike(other, /^There is no tileset “nowhere” here; this is /);
  assert.ok((await other.textContent("#message")).endsWith(` this is ${names[1]}.`));
  await other.goto(new URL(`#${names[0]}`, process.env.TERRAIN_URL).href);
  await other.waitForSelector("#message", { state: "hidden" });
  assert.equal((await shown())[0], names[0]);
  await other.close();
});

test("on a phone the panel is folded and opens", async () => {
  const phone = await browser.newPage({ viewport: { width: 360, height: 640 } });
  await phone.goto(process.env.TERRAIN_URL);
  await phone.waitForFunction(() => window.terrain !== undefined);
  const folded = await phone.locator("#panel").boundingBox();
  assert.ok(folded.width * folded.height < 0.05 * 360 * 640, JSON.stringify(folded));
  await phone.click("#panel > summary");
  assert.ok(await phone.isVisible("#pixels") && (await phone.isHidden("#wireframe")));
  await phone.click("#more > summary");
  assert.ok(await phone.isVisible("#wireframe"));
  await phone.close();
});

test("fingers are told what they do, and there is a way back to all of the data without a key", async () => {
  const phone = await browser.newPage({ viewport: { width: 360, height: 640 }, hasTouch: true, isMobile: true });
  await phone.goto(process.env.TERRAIN_URL);
  await phone.waitForFunction(() => window.terrain !== undefined);
  await phone.tap("#panel > summary");
  await phone.tap("#figures > summary");
  assert.match(await phone.textContent("#help"), /^one finger: orbit/);
  const heightAfter = async (act) => {
    await act();
    await phone.evaluate(() => window.terrain.settled());
    return (await phone.evaluate(() => window.terrain.pose())).height;
  };
  const first = await heightAfter(() => {});
  const near = await heightAfter(() => phone.evaluate(() => window.terrain.flyTo(-84.2, 36.3, 500, 2000)));
  const all = await heightAfter(() => phone.tap("#all"));
  await phone.close();
  assert.ok(near < first / 2 && Math.abs(all / first - 1) < 0.01, `${first} m, ${near} m, ${all} m`);
});

test("in flight one finger looks around, and two move, forward as they part", async () => {
  const phone = await browser.newPage({ viewport: { width: 360, height: 640 }, hasTouch: true, isMobile: true });
  await phone.goto(process.env.TERRAIN_URL);
  await phone.waitForFunction(() => window.terrain !== undefined);
  await phone.evaluate(() => window.terrain.flyTo(-84.2, 36.3, 500, 8000, 0, 45));
  await phone.evaluate(() => document.getElementById("flying").click());
  assert.match(await phone.textContent("#help"), /^one finger: look/);
  const session = await phone.context().newCDPSession(phone);
  const touch = (type, ...places) => session.send("Input.dispatchTouchEvent", { type, touchPoints: places.map(([x, y], id) => ({ x, y, id })) });
  /** How the pose differs, in degrees and metres, after fingers went from places to others. */
  const changeBy = async (from, to) => {
    const pose = async () => {
      await phone.evaluate(() => window.terrain.settled());
      return phone.evaluate(() => window.terrain.pose());
    };
    const before = await pose();
    await touch("touchStart", ...from);
    for (const share of [0.25, 0.5, 0.75, 1]) {
      await touch("touchMove", ...from.map(([x, y], finger) => [x + share * (to[finger][0] - x), y + share * (to[finger][1] - y)]));
    }
    await touch("touchEnd");
    const after = await pose();
    const change = (part) => after[part] - before[part];
    const turned = ((change("azimuth") + 540) % 360) - 180;
    return { turned, down: change("down"), up: change("height"), north: change("latitude") * 111_000, east: change("longitude") * 89_500 };
  };
  const isStill = ({ up, north, east }) => Math.hypot(up, north, east) < 1;
  const isAhead = ({ turned, down }) => Math.hypot(turned, down) < 0.5;
  const looked = await changeBy([[180, 400]], [[240, 380]]);
  assert.ok(looked.turned < -5 && looked.down > 2 && isStill(looked), JSON.stringify(looked));
  await changeBy([[240, 380]], [[180, 400]]);
  const parted = await changeBy([[150, 400], [210, 400]], [[90, 400], [270, 400]]);
  assert.ok(parted.north > 500 && parted.up < -500 && Math.abs(parted.east) < 50 && isAhead(parted), JSON.stringify(parted));
  const joined = await changeBy([[90, 400], [270, 400]], [[150, 400], [210, 400]]);
  assert.ok(joined.north < -300 && joined.up > 300 && isAhead(joined), JSON.stringify(joined));
  const moved = await changeBy([[90, 400], [150, 400]], [[190, 400], [250, 400]]);
  assert.ok(moved.east < -500 && Math.abs(moved.up) < 50 && isAhead(moved), JSON.stringify(moved));
  const lifted = await changeBy([[90, 400], [150, 400]], [[90, 480], [150, 480]]);
  assert.ok(lifted.up > 500 && Math.abs(lifted.east) < 50 && isAhead(lifted), JSON.stringify(lifted));
  await phone.close();
});

/** Of what is on the page, the pairs that cover each other, and what is partly off the page. */
const overlaps = (shown) =>
  shown.evaluate(() => {
    const ids = ["panel", "north", "loading", "message", "elsewhere", "levels", "measure", "bar"];
    const boxes = ids.map((id) => [id, document.getElementById(id).getBoundingClientRect()]).filter(([, { width }]) => width > 0);
    const isOff = ({ left, top, right, bottom }) => left < 0 || top < 0 || right > innerWidth || bottom > innerHeight;
    const meet = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    const pairs = boxes.flatMap(([one, a], at) => boxes.slice(at + 1).flatMap(([other, b]) => (meet(a, b) ? [`${one} ${other}`] : [])));
    return [...pairs, ...boxes.flatMap(([id, box]) => (isOff(box) ? [`${id} is off`] : []))];
  });

test("nothing covers anything else, on a phone or a larger page, with all that there is open", async () => {
  for (const viewport of [{ width: 360, height: 640 }, { width: 640, height: 480 }, { width: 800, height: 560 }]) {
    const shown = await browser.newPage({ viewport });
    await shown.goto(process.env.TERRAIN_URL);
    await shown.waitForFunction(() => window.terrain !== undefined);
    await shown.evaluate(() => window.terrain.settled());
    await shown.mouse.move(viewport.width / 2, viewport.height / 2);
    assert.deepEqual(await overlaps(shown), [], `${viewport.width}, at first`);
    for (const id of ["panel", "more", "figures"]) await shown.evaluate((id) => (document.getElementById(id).open = true), id);
    assert.deepEqual(await overlaps(shown), [], `${viewport.width}, with the panel`);
    for (const id of ["measuring", "filled"]) await shown.evaluate((id) => document.getElementById(id).click(), id);
    assert.deepEqual(await overlaps(shown), [], `${viewport.width}, with the panel, measuring`);
    if (viewport.width < 600) await shown.click("#panel > summary");
    for (const share of [0.55, 0.7]) await shown.mouse.click(viewport.width * share, 0.45 * viewport.height);
    await shown.waitForSelector("#profile canvas");
    assert.deepEqual(await overlaps(shown), [], `${viewport.width}, with a profile`);
    for (const id of ["measuring", "tile-levels"]) await shown.evaluate((id) => document.getElementById(id).click(), id);
    await shown.check("#collapses");
    await shown.waitForSelector("#collapse-graph circle");
    assert.deepEqual(await overlaps(shown), [], `${viewport.width}, with a graph of collapses`);
    await shown.close();
  }
});

test("light by normals changes the picture, not the triangles", async () => {
  const fine = await startAnew();
  const lit = await pixels();
  await page.uncheck("#light");
  const plain = await settledStats();
  const changed = changedShare(lit, await pixels());
  await page.check("#light");
  assert.ok(fine.normalsBytes > 1000 && changed > 0.02, `${fine.normalsBytes} bytes, ${changed} of the picture`);
  assert.equal(plain.triangles, fine.triangles);
});

test("contour lines have their heights written on them while the view rests", async () => {
  await startAnew();
  await page.check("#contours");
  await page.waitForSelector("#contour-labels span", { state: "attached" });
  const labels = await page.evaluate(() =>
    [...document.querySelectorAll("#contour-labels span")].map((label) => {
      const { x, y, width, height } = label.getBoundingClientRect();
      const ground = window.terrain.groundAt((2 * (x + width / 2)) / innerWidth - 1, 1 - (2 * (y + height / 2)) / innerHeight);
      return { text: label.textContent, height: ground?.height };
    }),
  );
  assert.ok(labels.length >= 3, `${labels.length} labels`);
  for (const { text, height } of labels) assert.ok(Math.abs(Number(text) - height) < 25, `${text} on ground of ${height} m`);
  assert.ok(new Set(labels.map(({ text }) => text)).size > 1);
  await page.uncheck("#contours");
  await settledStats();
  assert.equal(await page.locator("#contour-labels span").count(), 0);
});

test("the tile in the middle is shown alone, finer from level to level", async () => {
  await startAnew();
  const all = await settledStats();
  await page.check("#tile-levels");
  const seen = [];
  const count = Number(await page.getAttribute("#level", "max"));
  for (let level = 0; level <= count; level++) {
    await page.fill("#level", String(level));
    const { tiles, triangles, error } = await settledStats();
    assert.equal(tiles, 1);
    assert.ok((await page.textContent("#level-text")).includes(`${triangles.toLocaleString("en")} triangles`));
    seen.push({ triangles, error });
  }
  await page.check("#forest");
  await settledStats();
  await page.waitForTimeout(500);
  const withForest = await pixels();
  await page.uncheck("#forest");
  await settledStats();
  const without = await pixels();
  assert.ok(changedShare(withForest, without) > 0.02, "the forest of representatives is drawn");
  await page.check("#collapses");
  await page.waitForSelector("#collapse-graph circle.chosen");
  const [, collapses, dependencies, depth, part, chosen] = (await page.textContent("#collapse-text"))
    .replaceAll(",", "")
    .match(/^(\d+) collapses (\d+) dependencies (\d+) deep; (\d+) of them around vertex (\d+)$/)
    .map(Number);
  assert.equal(await page.locator("#collapse-graph circle").count(), part);
  assert.ok(collapses > part && dependencies > collapses && depth > 3, `${collapses} collapses, ${dependencies} dependencies, ${depth} deep`);
  const other = await page.getAttribute("#collapse-graph circle:not(.chosen)", "data-vertex");
  await page.click(`#collapse-graph circle[data-vertex="${other}"]`);
  assert.ok((await page.textContent("#collapse-text")).endsWith(`around vertex ${other}`) && Number(other) !== chosen);
  assert.equal(await page.getAttribute("#collapse-graph circle.chosen", "class"), "in chosen");
  await page.fill("#level", "0");
  await page.waitForSelector("#collapse-graph circle.out.chosen");
  await page.uncheck("#collapses");
  assert.ok(count > 2 && seen.every((now, at) => at === 0 || (now.triangles > seen[at - 1].triangles && now.error <= seen[at - 1].error)), JSON.stringify(seen));
  await page.uncheck("#tile-levels");
  // What was finer may stay so: not all is as it was, to the triangle.
  const again = await settledStats();
  assert.ok(again.tiles > 1 && Math.abs(again.triangles / all.triangles - 1) < 0.3, `${all.triangles} → ${again.triangles}`);
});

test("levels of a tile wait for one that is there, and say so", async () => {
  const waiting = await browser.newPage();
  let answer;
  const isAllowed = new Promise((resolve) => (answer = resolve));
  await waiting.route("**/tilesets", async (route) => {
    await isAllowed;
    await route.continue();
  });
  await waiting.goto(process.env.TERRAIN_URL);
  await waiting.evaluate(() => document.getElementById("tile-levels").click());
  assert.match(await waiting.textContent("#level-text"), /^Nothing is there yet/);
  assert.ok((await waiting.isDisabled("#level")) && (await waiting.isDisabled("#collapses")));
  answer();
  await waiting.waitForFunction(() => document.getElementById("level-text").textContent.startsWith("Tile "));
  assert.ok(await waiting.isEnabled("#level"));
  await waiting.close();
});

test("what was drawn stays while the server is away, and goes on when it is back", async () => {
  const shaken = await browser.newPage({ viewport: { width: 640, height: 480 } });
  let answered = 0;
  await shaken.route("**/*.spt*", (route) => (++answered > 8 ? route.abort() : route.continue()));
  await shaken.goto(process.env.TERRAIN_URL);
  await shaken.waitForSelector("#message:not([hidden])");
  assert.ok((await shaken.evaluate(() => window.terrain.stats())).tiles > 0, "something is drawn");
  await shaken.unroute("**/*.spt*");
  await shaken.waitForSelector("#message", { state: "hidden" });
  await shaken.evaluate(() => window.terrain.settled());
  const stats = await shaken.evaluate(() => window.terrain.stats());
  await shaken.close();
  assert.ok(stats.triangles > 1000, JSON.stringify(stats));
});

test("what decodes tiles is there before the first of them", async () => {
  const other = await quietPage(browser, complaints);
  await other.route(/\.spt/, () => {});
  await other.goto(process.env.TERRAIN_URL);
  await other.waitForFunction(() => window.terrain !== undefined);
  for (let times = 0; times < 50 && other.workers().length === 0; times++) await other.waitForTimeout(100);
  assert.match(other.workers()[0]?.url() ?? "no worker", /tile_worker/);
  await other.close();
});

test("a decoder that does not come at first is asked for again, and the page says meanwhile what is missing", async () => {
  const other = await browser.newPage();
  let isRefused = true;
  await other.route(/\.wasm/, (route) => (isRefused ? route.fulfill({ status: 503 }) : route.continue()));
  await other.goto(process.env.TERRAIN_URL);
  await messageLike(other, /decoder is not at .*503/);
  assert.equal(await other.evaluate(() => window.terrain.stats().triangles), 0);
  isRefused = false;
  await other.waitForFunction(() => window.terrain.stats().triangles > 1000);
  await other.waitForFunction(() => document.querySelector("#message").hidden);
  await other.close();
});

test("a missing server is told in a line", async () => {
  const lost = await browser.newPage();
  await lost.route("**/tilesets", (route) => route.abort());
  await lost.goto(process.env.TERRAIN_URL);
  await messageLike(lost, /^The terrain server does not answer\.$/);
  await lost.close();
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
