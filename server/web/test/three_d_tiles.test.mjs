// 3D Tiles of a running server: every file against the Khronos validator, every claim against the DEM, and both tilesets drawn by
// CesiumJS and three.js in headless Chromium.
// TERRAIN_URL: the server's address; TERRAIN_DEM: the raster, in WGS 84 degrees, that its first archive was made of;
// TERRAIN_SCREENSHOTS: where to leave pictures; CHROMIUM: another browser.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import validator from "gltf-validator";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
import { launch, quietPage } from "./browser.mjs";
import { offNearby, PLACES, readDem } from "./dem.mjs";
import { servePages } from "./pages.mjs";

const url = process.env.TERRAIN_URL;
const PACKINGS = ["plain", "meshopt"];
const SETTLE_MILLISECONDS = 100_000;

let name, dem, pages, browser;

before(async () => {
  assert.ok(url && process.env.TERRAIN_DEM, "set TERRAIN_URL and TERRAIN_DEM");
  [{ name }] = await json(new URL("tilesets", url));
  await MeshoptDecoder.ready;
  dem = await readDem(process.env.TERRAIN_DEM);
  pages = await servePages();
  browser = await launch();
});

after(async () => {
  await browser?.close();
  pages?.close();
});

async function json(address) {
  return (await fetch(address)).json();
}

async function bytesOf(address) {
  const response = await fetch(address);
  assert.equal(response.status, 200, address.href);
  return new Uint8Array(await response.arrayBuffer());
}

/** Degrees and metres above WGS 84 of Earth-centred metres, by fixed-point iteration of the latitude. */
function geodetic([x, y, z]) {
  const a = 6378137, f = 1 / 298.257223563, e2 = f * (2 - f), p = Math.hypot(x, y);
  let latitude = Math.atan2(z, p * (1 - e2)), n = a;
  for (let turn = 0; turn < 12; turn++) {
    n = a / Math.sqrt(1 - e2 * Math.sin(latitude) ** 2);
    latitude = Math.atan2(z + e2 * n * Math.sin(latitude), p);
  }
  const height = p * Math.cos(latitude) + z * Math.sin(latitude) - a * Math.sqrt(1 - e2 * Math.sin(latitude) ** 2);
  return [Math.atan2(y, x) * 180 / Math.PI, latitude * 180 / Math.PI, height];
}

/** A GLB file's first primitive, placed on the Earth. */
function placed(glb) {
  const view = new DataView(glb.buffer, glb.byteOffset);
  const length = view.getUint32(12, true);
  const file = JSON.parse(new TextDecoder().decode(glb.subarray(20, 20 + length)));
  const [primitive] = file.meshes[0].primitives;
  const binary = glb.subarray(28 + length);
  const numbers = (index, width) => {
    const { bufferView, componentType, count, normalized } = file.accessors[index];
    const view = file.bufferViews[bufferView];
    const bytes = decompressed(binary, view);
    const kind = { 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array }[componentType];
    const step = (view.byteStride ?? width * kind.BYTES_PER_ELEMENT) / kind.BYTES_PER_ELEMENT;
    const all = new kind(bytes.buffer);
    const unit = normalized ? 65535 : 1;
    return Array.from({ length: count * width }, (_, i) => all[Math.floor(i / width) * step + i % width] / unit);
  };
  const m = file.nodes[0].matrix, local = numbers(primitive.attributes.POSITION, 3), positions = [];
  for (let i = 0; i < local.length; i += 3) {
    const [x, y, z] = [0, 1, 2].map((k) => m[k] * local[i] + m[4 + k] * local[i + 1] + m[8 + k] * local[i + 2] + m[12 + k]);
    positions.push([x, -z, y]);
  }
  return { positions, indices: numbers(primitive.indices, 1), error: file.asset.extras.certifiedError };
}

/** The bytes of a view, in a buffer of their own. */
function decompressed(binary, view) {
  const compressed = view.extensions?.EXT_meshopt_compression;
  if (compressed === undefined) return binary.slice(view.byteOffset, view.byteOffset + view.byteLength);
  const bytes = new Uint8Array(compressed.count * compressed.byteStride);
  const source = binary.subarray(compressed.byteOffset, compressed.byteOffset + compressed.byteLength);
  MeshoptDecoder.decodeGltfBuffer(bytes, compressed.count, compressed.byteStride, source, compressed.mode, compressed.filter);
  return bytes;
}

/** All tiles of the explicit tileset with an address of a file. */
async function* explicitTiles(address) {
  const document = await json(address);
  const open = [document.root];
  while (open.length > 0) {
    const tile = open.pop();
    open.push(...(tile.children ?? []));
    if (tile.content === undefined) continue;
    const content = new URL(tile.content.uri, address);
    if (content.pathname.endsWith(".json")) yield* explicitTiles(content);
    else yield { address: content, tile };
  }
}

async function assertValid(address, glb) {
  const { issues } = await validator.validateBytes(glb, { ignoredIssues: ["UNSUPPORTED_EXTENSION"] });
  assert.deepEqual(issues.messages.filter(({ severity }) => severity < 2), [], address.href);
}

for (const packing of PACKINGS) {
  test(`every ${packing} tile of the explicit tileset is valid and within its certified error of the DEM`, async () => {
    let files = 0, untold = 0, points = 0, worst = 0;
    for await (const { address, tile } of explicitTiles(new URL(`${name}/3d-tiles/tileset.json?packing=${packing}`, url))) {
      const glb = await bytesOf(address);
      await assertValid(address, glb);
      const { positions, indices, error } = placed(glb);
      const { certifiedError, rounding } = tile.metadata.properties;
      assert.ok(tile.geometricError >= certifiedError + rounding, address.href);
      assert.ok(error === null || error >= certifiedError, address.href);
      for (let i = 0; i < indices.length; i += 3) {
        for (const [a, b, c] of [[1 / 3, 1 / 3, 1 / 3], [0.8, 0.1, 0.1], [0, 0.5, 0.5]]) {
          const [p, q, r] = [0, 1, 2].map((k) => positions[indices[i + k]]);
          const [longitude, latitude, height] = geodetic([0, 1, 2].map((k) => a * p[k] + b * q[k] + c * r[k]));
          const expected = dem(longitude, latitude);
          if (expected === undefined) continue;
          const off = Math.abs(height - expected);
          assert.ok(error === null || off <= error + 1e-6, `${address.href}: ${off} m off, ${error} m claimed, at ${longitude}, ${latitude}`);
          const inSpace = offNearby(dem, longitude, latitude, height, rounding);
          assert.ok(inSpace <= certifiedError + rounding + 1e-6, `${address.href}: ${inSpace} m off at ${longitude}, ${latitude}`);
          worst = Math.max(worst, inSpace / (certifiedError + rounding));
          points++;
        }
      }
      files++;
      if (error === null) untold++;
    }
    console.log(`${packing}: ${files} files, ${untold} of them tell no error along the vertical; ${points} points, worst ${worst.toFixed(3)} of the claim`);
    assert.ok(files > 10 && points > 10_000);
  });

  test(`every ${packing} tile of the implicit tileset is valid, and the ground beside the data`, async () => {
    const [{ metadata }] = await json(new URL("tilesets", url));
    let ground = 0;
    for (const { zoom, available } of metadata.zooms) {
      const columns = 2 ** zoom;
      const isMeasured = (x, y) => available.some(([startX, startY, endX, endY]) => startX <= x && x <= endX && startY <= y && y <= endY);
      for (const [startX, startY, endX, endY] of available) {
        for (let x = Math.max(startX - 1, 0); x <= Math.min(endX + 1, 2 * columns - 1); x++) {
          for (let y = Math.max(startY - 1, 0); y <= Math.min(endY + 1, columns - 1); y++) {
            const path = `${name}/3d-terrain/${Math.floor(x / columns)}/${zoom}/${x % columns}/${y}.glb?packing=${packing}`;
            await assertValid(new URL(path, url), await bytesOf(new URL(path, url)));
            ground += isMeasured(x, y) ? 0 : 1;
          }
        }
      }
    }
    assert.ok(ground > 20, `${ground} tiles of ground`);
  });
}

/** Opens a page on a tileset and waits until it says that it has all it needs. */
async function open(file, tileset, packing) {
  const complaints = [];
  const page = await quietPage(browser, complaints);
  const address = new URL(`http://127.0.0.1:${pages.address().port}/test/${file}`);
  address.searchParams.set("tileset", new URL(`${name}/${tileset}/tileset.json?packing=${packing}`, url));
  address.searchParams.set("view", "-84.27,36.30");
  await page.goto(address.href);
  await page.waitForFunction("window.ready?.()", undefined, { timeout: SETTLE_MILLISECONDS }).catch((error) => {
    throw new Error(`${file}: ${error.message}; ${complaints.join("; ")}`);
  });
  await page.waitForTimeout(1000);
  // A globe has all it needs before it begins, too.
  await page.waitForFunction("window.ready?.()", undefined, { timeout: SETTLE_MILLISECONDS });
  if (process.env.TERRAIN_SCREENSHOTS) await page.screenshot({ path: join(process.env.TERRAIN_SCREENSHOTS, `${file}-${tileset}-${packing}.png`) });
  return { page, complaints };
}

/** Heights may be off by what is certified of the finest tiles, by how far rounding moved them, and by what is added. */
async function assertNear(heights, packing, added) {
  const [{ metadata }] = await json(new URL("tilesets", url));
  let claimed = 0, rounding = 0;
  for await (const { address, tile } of explicitTiles(new URL(`${name}/3d-tiles/tileset.json?packing=${packing}`, url))) {
    if (!address.pathname.includes(`/3d-tiles/${metadata.max_zoom}/`)) continue;
    claimed = Math.max(claimed, tile.metadata.properties.certifiedError);
    rounding = tile.metadata.properties.rounding;
  }
  const allowed = claimed + rounding + added;
  let worst = 0;
  for (const [i, [longitude, latitude]] of PLACES.entries()) {
    const off = offNearby(dem, longitude, latitude, heights[i], rounding);
    assert.ok(off <= allowed, `${off} m off at ${longitude}, ${latitude}; ${allowed} m allowed`);
    worst = Math.max(worst, off);
  }
  console.log(`${packing}: ${worst.toFixed(2)} m off at most, ${allowed.toFixed(2)} m allowed`);
}

for (const packing of PACKINGS) {
  test(`CesiumJS's globe takes the implicit tileset, ${packing}, and samples heights within the claim`, async () => {
    const { page, complaints } = await open("cesium.html", "3d-terrain", packing);
    const heights = await page.evaluate((places) => window.sample(places), PLACES);
    // Heights of the globe are rounded as quantized-mesh is.
    await assertNear(heights, packing, 0.5);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  test(`CesiumJS draws the explicit tileset, ${packing}, and samples heights within the claim`, async () => {
    const { page, complaints } = await open("cesium.html", "3d-tiles", packing);
    const heights = await page.evaluate((places) => window.sample(places), PLACES);
    await assertNear(heights, packing, 0.01);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  test(`three.js draws the explicit tileset, ${packing}, by 3d-tiles-renderer, and a ray meets it within the claim`, async () => {
    const { page, complaints } = await open("three.html", "3d-tiles", packing);
    const heights = await page.evaluate((places) => window.sample(places), PLACES);
    await assertNear(heights, packing, 0.05);
    assert.deepEqual(complaints, []);
    await page.close();
  });
}
