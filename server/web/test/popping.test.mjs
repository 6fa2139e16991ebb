// A flight over an archive, frame by frame, without a graphics card: what the vertex shader would draw is computed here, and held
// against the frame before. TERRAIN_ARCHIVE: the archive. `npm run package` makes the library that is flown with.

import assert from "node:assert/strict";
import { basename, dirname } from "node:path";
import { after, before, test } from "node:test";
import { PerspectiveCamera, Triangle, Vector3 } from "three";
import { openArchive, TerrainLayer } from "../lib/index.js";
import { serveByNginx } from "./nginx.mjs";

const [WIDTH, HEIGHT, FRAME_MILLISECONDS] = [1280, 800, 1000 / 60];
const MAX_PIXELS = 2;
/** Of the grid that triangles are found by: what is nearer than this share of a cell is found beyond its edge. */
const MARGIN = 0.3;
let nginx, tileset;

before(async () => {
  nginx = await serveByNginx(dirname(process.env.TERRAIN_ARCHIVE));
  tileset = await openArchive(`${nginx.url}${basename(process.env.TERRAIN_ARCHIVE)}`);
});

after(() => nginx?.stop());

/** The vertices as the shader places them, and the triangles, of each mesh, and whether it is in sight. */
function drawn(layer) {
  return layer.group.children.map((object) => {
    const { geometry, material } = object.children[0];
    const { positions, places, blend } = material.uniforms;
    const [texels, at] = [positions.value.image.data, places.value.image.data];
    const corners = geometry.index.array.subarray(0, geometry.drawRange.count);
    const used = new Set(corners);
    const vertices = new Map();
    for (const vertex of used) {
      const [to, from] = [4 * at[2 * vertex], 4 * at[2 * vertex + 1]];
      const mixed = (axis) => texels[from + axis] + (texels[to + axis] - texels[from + axis]) * blend.value;
      vertices.set(vertex, new Vector3(mixed(0), mixed(1), mixed(2)).add(object.position));
    }
    return { vertices, corners, isVisible: object.visible };
  });
}

const [TRIANGLE, POINT] = [new Triangle(), new Vector3()];
/** One number for each cell of a grid of less than 2^24 a side. */
const keyOf = (x, y) => x * 2 ** 24 + y;

/** Triangles by the cells of a grid in the plane of the frame, so that those at a place are found. */
class Surface {
  constructor(meshes, cell) {
    this.cell = cell;
    this.cells = new Map();
    for (const { vertices, corners } of meshes) {
      for (let at = 0; at < corners.length; at += 3) {
        const triangle = [0, 1, 2].map((corner) => vertices.get(corners[at + corner]));
        const [a, b, c] = triangle;
        const [lowX, lowY] = [Math.min(a.x, b.x, c.x), Math.min(a.y, b.y, c.y)].map((low) => Math.floor(low / cell - MARGIN));
        const [highX, highY] = [Math.max(a.x, b.x, c.x), Math.max(a.y, b.y, c.y)].map((high) => Math.floor(high / cell + MARGIN));
        for (let x = lowX; x <= highX; x++) for (let y = lowY; y <= highY; y++) {
          const others = this.cells.get(keyOf(x, y));
          if (others === undefined) this.cells.set(keyOf(x, y), [triangle]);
          else others.push(triangle);
        }
      }
    }
  }

  /** Metres from a vertex to the nearest point of the surface; undefined where there is none near. */
  metresFrom(vertex) {
    const near = this.cells.get(keyOf(Math.floor(vertex.x / this.cell), Math.floor(vertex.y / this.cell)));
    if (near === undefined) return undefined;
    let least = Infinity;
    for (const [a, b, c] of near) {
      const metres = TRIANGLE.set(a, b, c).closestPointToPoint(vertex, POINT).distanceTo(vertex);
      if (metres === 0) return 0;
      least = Math.min(least, metres);
    }
    return least;
  }
}

const camera = new PerspectiveCamera(45, WIDTH / HEIGHT, 1, 1e8);
camera.up.set(0, 0, 1);
const pixelsPerRadian = HEIGHT / (2 * Math.tan(Math.PI / 8));

/** Over the middle of the data: down from far above, along, and up again; then a leap. */
function place(frame, share) {
  const height = share < 0.4 ? 30_000 * (1 - share / 0.4) + 1500 : share < 0.8 ? 1500 : 1500 + 80_000 * (share - 0.8);
  const along = 12_000 * Math.sin(2 * Math.PI * share);
  const leap = share > 0.9 ? 9000 : 0;
  camera.position.set(along + leap, -9000 + 14_000 * share, height);
  camera.lookAt(along + leap + 300, camera.position.y + Math.max(4000, 0.6 * height), 300);
  camera.updateMatrixWorld();
}

test("in no frame of a flight the ground jumps by more pixels than it may be off", async () => {
  const layer = new TerrainLayer(tileset);
  layer.set({ maxPixels: MAX_PIXELS });
  camera.updateProjectionMatrix();
  // Fifteen seconds.
  const FRAMES = 900;
  let [before, worst, changes, compared, holes] = [undefined, { pixels: 0 }, 0, 0, 0];
  place(layer.frame, 0);
  for (let settle = 0; settle < 400 && !layer.isSettled; settle++) {
    layer.update(camera, HEIGHT, settle * FRAME_MILLISECONDS);
    await new Promise((resolve) => setTimeout(resolve, 2));
  }
  for (let frame = 0; frame < FRAMES; frame++) {
    place(layer.frame, frame / FRAMES);
    layer.invalidate();
    layer.update(camera, HEIGHT, (400 + frame) * FRAME_MILLISECONDS);
    // Tiles come in whenever they do.
    await new Promise((resolve) => setTimeout(resolve, 3));
    const now = drawn(layer);
    if (before !== undefined) {
      const surface = new Surface(before, 400);
      for (const { vertices } of now.filter(({ isVisible }) => isVisible)) {
        for (const [vertex, position] of vertices) {
          const metres = surface.metresFrom(position);
          if (metres === undefined) {
            holes++;
            continue;
          }
          compared++;
          const pixels = (metres * pixelsPerRadian) / position.distanceTo(camera.position);
          if (metres > 0.01) changes++;
          if (pixels > worst.pixels) worst = { pixels, metres, frame, vertex };
        }
      }
    }
    before = now;
  }
  layer.dispose();
  console.log({ worst, changes, compared, holes });
  assert.ok(compared > 100_000 && changes > 1000, `${compared} compared, ${changes} of them moved`);
  assert.ok(worst.pixels <= MAX_PIXELS, JSON.stringify(worst));
});
