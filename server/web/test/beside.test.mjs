// Two archives side by side. TERRAIN_URL: address of a terrain-server that has at least two.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { changedShare, describe, launch, pixelsOf, placeText, quietPage } from "./browser.mjs";

const LEFT = { x: 240, y: 0, width: 150, height: 440 };
const RIGHT = { x: 402, y: 60, width: 390, height: 420 };
const complaints = [];
let browser, page, names;

before(async () => {
  browser = await launch();
  page = await quietPage(browser, complaints, { width: 800, height: 560 });
  await page.goto(process.env.TERRAIN_URL);
  await page.waitForFunction(() => window.terrain !== undefined);
  names = await page.evaluate(() => fetch("tilesets").then((answer) => answer.json())).then((list) => list.map(({ name }) => name));
});

after(() => browser?.close());

const settled = () => page.evaluate(() => window.terrain.settled());

async function poses() {
  await settled();
  await page.waitForTimeout(300);
  return page.evaluate(() => [window.terrain.pose(), window.terrain.besidePose()]);
}

function assertAlike([one, other]) {
  for (const [part, most] of Object.entries({ longitude: 1e-6, latitude: 1e-6, height: 0.1, azimuth: 0.5, down: 0.5 })) {
    assert.ok(Math.abs(one[part] - other[part]) < most, `${part}: ${one[part]}, ${other[part]}`);
  }
}

test("another archive is shown beside the first, and its name", async () => {
  await page.selectOption("#beside-tileset", names[1]);
  await settled();
  assert.equal(await page.textContent("#beside-name"), names[1]);
  assert.ok(page.url().includes(`beside=${names[1]}`));
  assert.ok(describe(await pixelsOf(page, LEFT)).groundShare > 0.1);
  assert.ok(describe(await pixelsOf(page, RIGHT)).groundShare > 0.1);
  assertAlike(await poses());
});

test("whichever view is moved, the other moves with it", async () => {
  for (const x of [330, 600]) {
    const [before] = await poses();
    await page.mouse.move(x, 300);
    await page.mouse.down();
    await page.mouse.move(x + 40, 320, { steps: 4 });
    await page.mouse.up();
    const [main, beside] = await poses();
    assert.ok(Math.abs(main.azimuth - before.azimuth) > 1, `${before.azimuth} → ${main.azimuth}`);
    assertAlike([main, beside]);
  }
});

test("the height under the pointer is told of both", async () => {
  await page.mouse.move(600, 330);
  assert.match(await placeText(page), /: [\d.]+ ± [\d.]+ m above .* · beside: [\d.]+ ± [\d.]+ m$/);
});

test("styles are those of both, and a link shows both", async () => {
  const [left, right] = [await pixelsOf(page, LEFT), await pixelsOf(page, RIGHT)];
  await page.selectOption("#style", "Certified error");
  await settled();
  assert.ok(changedShare(left, await pixelsOf(page, LEFT)) > 0.1);
  assert.ok(changedShare(right, await pixelsOf(page, RIGHT)) > 0.1);
  await page.waitForTimeout(600);
  const other = await quietPage(browser, complaints);
  await other.goto(page.url());
  await other.waitForFunction(() => window.terrain !== undefined);
  assert.equal(await other.textContent("#beside-name"), names[1]);
  await other.close();
});

test("colours and the legend are those of the heights of both, and of one again", async () => {
  const legend = async () => {
    await settled();
    const ends = await page.locator("#legend-low, #legend-high").allTextContents();
    return ends.map((text) => Number(text.replace("−", "-").replace(" m", "")));
  };
  const choose = async (name, beside) => {
    await page.selectOption("#beside-tileset", beside);
    await page.selectOption("#tileset", name);
    return legend();
  };
  const above = names.find((name) => name.endsWith("_ellipsoid"));
  await page.selectOption("#style", "Elevation");
  const [lower, upper] = [await choose(above, "–"), await choose(names[0], "–")];
  assert.ok(lower[0] < upper[0] - 20 && lower[1] < upper[1] - 20, `the geoid is 32 m below the ellipsoid: ${lower}, ${upper}`);
  assert.ok(await page.isHidden("#legend-shared"));
  const left = await pixelsOf(page, LEFT);
  assert.deepEqual(await choose(names[0], above), [lower[0], upper[1]]);
  assert.ok(await page.isVisible("#legend-shared"));
  assert.ok(changedShare(left, await pixelsOf(page, LEFT)) > 0.01, "the first view has the common colours, too");
  assert.deepEqual(await choose(names[0], "–"), upper);
  await page.selectOption("#beside-tileset", names[1]);
});

test("an archive that is far away is said to be, and a click leads there and back", async () => {
  const local = names.find((name) => name.endsWith("_local"));
  const far = names.find((name) => name.startsWith("vancouver")) ?? local;
  await page.selectOption("#beside-tileset", far);
  await settled();
  const notice = page.locator("#elsewhere p");
  const way = far === local ? "" : ": 3,[45]\\d\\d km to the north-west";
  assert.match(await notice.textContent(), new RegExp(`^${far} is not in sight${way}\\. Go there$`));
  assert.equal(describe(await pixelsOf(page, RIGHT)).groundShare < 0.1, true);
  await notice.getByRole("button").click();
  await settled();
  assert.ok(describe(await pixelsOf(page, { ...RIGHT, y: 120 })).groundShare > 0.1);
  assert.ok((await notice.textContent()).startsWith(`${names[0]} is not in sight`));
  assertAlike(await poses());
  await page.mouse.move(600, 330);
  assert.match(await placeText(page), /^[^:]+: beside: −?[\d.]+ ± [\d.]+ m$/);
  await notice.getByRole("button").click();
  await settled();
  assert.ok(describe(await pixelsOf(page, LEFT)).groundShare > 0.1);
  await page.selectOption("#beside-tileset", names[1]);
  await settled();
  assert.equal(await notice.count(), 0);
});

test("one view alone has the whole page again", async () => {
  await page.selectOption("#beside-tileset", "–");
  await settled();
  assert.ok(await page.isHidden("#beside"));
  assert.equal((await page.locator("#view").boundingBox()).width, 800);
  assert.equal(await page.evaluate(() => window.terrain.besidePose()), undefined);
});

test("the console stays quiet", () => assert.deepEqual(complaints, []));
