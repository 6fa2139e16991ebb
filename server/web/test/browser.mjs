// A headless Chromium, and what its pictures show. CHROMIUM: another browser.

import { chromium } from "playwright-core";

/** Mesa draws twice as fast as SwiftShader, which Chromium has itself and takes where Mesa is not there. */
const SOFTWARE_GL = ["--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist", "--enable-unsafe-swiftshader"];
const QUIET = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking"];

export function launch() {
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: [...SOFTWARE_GL, ...QUIET] });
}

/** A page whose complaints are added to a list. */
export async function quietPage(browser, complaints, viewport = { width: 640, height: 480 }) {
  const page = await browser.newPage({ viewport });
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  return page;
}

/** Waits until the page's message is like this one; there may be others before. */
export async function messageLike(page, pattern) {
  const isLike = (pattern) => {
    const { hidden, textContent } = document.getElementById("message");
    return !hidden && pattern.test(textContent);
  };
  try {
    await page.waitForFunction(isLike, pattern);
  } catch (error) {
    throw new Error(`the message is “${await page.textContent("#message")}”, not like ${pattern}`, { cause: error });
  }
}

/** What the page says of the ground under the pointer: it looks for that once a frame. */
export async function placeText(page) {
  await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
  return page.textContent("#place");
}

/** Pixels of a part of a page as `[r, g, b, a, …]`, decoded by the browser. */
export async function pixelsOf(page, clip) {
  const png = (await page.screenshot({ clip })).toString("base64");
  const decoded = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes]));
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    return btoa(Array.from(data, (byte) => String.fromCharCode(byte)).join(""));
  }, png);
  return Buffer.from(decoded, "base64");
}

/** How many colours there are, and the share of pixels that are not the blue-grey of the air. */
export function describe(image) {
  const colours = new Set();
  let ground = 0;
  for (let at = 0; at < image.length; at += 4) {
    const [red, green, blue] = image.subarray(at, at + 3);
    colours.add((red << 16) | (green << 8) | blue);
    if (blue < green || blue < red) ground++;
  }
  return { colours: colours.size, groundShare: (4 * ground) / image.length };
}

export function changedShare(one, other) {
  let changed = 0;
  for (let at = 0; at < one.length; at += 4) {
    if ([0, 1, 2].some((channel) => Math.abs(one[at + channel] - other[at + channel]) > 16)) changed++;
  }
  return (4 * changed) / one.length;
}
