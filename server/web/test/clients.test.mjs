// The tiles of a running server, read by the parsers that clients have. TERRAIN_URL: the server's address; TERRAIN_DEM: the raster, in WGS 84
// degrees, that its first archive was made of.

import assert from "node:assert/strict";
import { test } from "node:test";
import { parse } from "@loaders.gl/core";
import { QuantizedMeshLoader } from "@loaders.gl/terrain";
import { QuantizedMeshLoaderBase } from "3d-tiles-renderer/core/plugins";
import { offNearby, readDem } from "./dem.mjs";

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

test("loaders.gl, which deck.gl draws terrain with, reads tiles, whose heights are within the claim", async () => {
  const dem = await readDem(process.env.TERRAIN_DEM);
  const [{ name, metadata }] = await fetch(new URL("tilesets", url)).then((answer) => answer.json());
  let points = 0, worst = 0;
  for (const { zoom, finest_error, available } of metadata.zooms) {
    const [x, y] = available[0], side = 180 / 2 ** zoom;
    const [west, south] = [x * side - 180, y * side - 90];
    const bytes = await bytesOf(`${name}/${zoom}/${x}/${y}.terrain`);
    const options = { worker: false, "quantized-mesh": { bounds: [west, south, west + side, south + side] } };
    const { attributes, indices, header } = await parse(bytes, QuantizedMeshLoader, options);
    const places = attributes.POSITION.value;
    // A 32,767th of the side, and of the range of heights: what quantized-mesh rounds to.
    const step = side * 111_000 / 32_767;
    const [[, , low], [, , high]] = header.boundingBox;
    const claimed = finest_error + (high - low) / 32_767;
    for (let i = 0; i < indices.value.length; i += 3) {
      const corners = [0, 1, 2].map((k) => places.slice(3 * indices.value[i + k], 3 * indices.value[i + k] + 3));
      // Triangles are flat in degrees here, not in space: they follow the Earth, and those of the tile dip below it.
      const longest = Math.max(...corners.map(([x, y], k) => 111_000 * Math.hypot(x - corners[(k + 1) % 3][0], y - corners[(k + 1) % 3][1])));
      const allowed = claimed + longest ** 2 / (6 * 6_371_000);
      for (const weights of [[1, 0, 0], [1 / 3, 1 / 3, 1 / 3], [0.5, 0.5, 0]]) {
        const [longitude, latitude, height] = [0, 1, 2].map((axis) =>
          weights.reduce((sum, weight, k) => sum + weight * corners[k][axis], 0),
        );
        if (!isWellInside(dem, longitude, latitude, finest_error)) continue;
        const off = offNearby(dem, longitude, latitude, height, step) / allowed;
        assert.ok(off <= 1, `zoom ${zoom}: ${off} of the claim at ${longitude}, ${latitude}`);
        worst = Math.max(worst, off);
        points++;
      }
    }
  }
  console.log(`loaders.gl: ${points} points, worst ${worst.toFixed(3)} of the claim`);
  assert.ok(points > 1000);
});

/** Where the data end, an edge may stray by as many metres as the surface may err. */
function isWellInside(dem, longitude, latitude, metres) {
  const [east, north] = [metres / 111_000 / Math.cos(latitude * Math.PI / 180), metres / 111_000];
  return [-1, 1].every((way) => dem(longitude + way * east, latitude) !== undefined && dem(longitude, latitude + way * north) !== undefined);
}
