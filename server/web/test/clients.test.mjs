// The tiles of a running server, read by the parsers that clients have. TERRAIN_URL: the server's address.

import assert from "node:assert/strict";
import { test } from "node:test";
import { QuantizedMeshLoaderBase } from "3d-tiles-renderer/core/plugins";

const url = process.env.TERRAIN_URL;

async function bytesOf(path, headers = {}) {
  const response = await fetch(new URL(path, url), { headers });
  assert.equal(response.status, 200, path);
  return response.arrayBuffer();
}

test("3d-tiles-renderer reads tiles, with every extension that layer.json names", async () => {
  const [{ name }] = await fetch(new URL("tilesets", url)).then((answer) => answer.json());
  const layer = await fetch(new URL(`${name}/layer.json`, url)).then((answer) => answer.json());
  // As its plugin makes the header.
  const accept = `application/vnd.quantized-mesh,application/octet-stream;q=0.9;extensions=${layer.extensions.join("-")}`;
  const loader = new QuantizedMeshLoaderBase();
  for (const [zoom, ranges] of layer.available.entries()) {
    const { startX, startY } = ranges[0];
    const path = `${name}/${zoom}/${startX}/${startY}.terrain`;
    const plain = loader.parse(await bytesOf(path));
    assert.deepEqual(Object.keys(plain.extensions), [], path);
    const asked = loader.parse(await bytesOf(path, { accept }));
    assert.deepEqual(Object.keys(asked.extensions), ["octvertexnormals"], path);
    assert.ok(asked.indices.length >= 6 && asked.vertexData.u.length >= 4, path);
  }
});
