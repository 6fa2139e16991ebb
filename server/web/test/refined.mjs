// How many triangles a model has that is drawn as views need it, beside the coarsest level that is within as many pixels, and what it takes
// to go from view to view. No test: `npm run test:unit`, then node test/refined.mjs MODEL.spm [PIXELS]
// The eye flies through the model along its longest side, at a quarter of the shortest one above its middle, in 200 views of 1280 × 720.

import { readFile } from "node:fs/promises";
import { Box3, Frustum, PerspectiveCamera, Vector3 } from "three";
import { loadModelDecoder, ProgressiveModel } from "../node_modules/.unit/src/progressive_model.js";

const [path, pixels = "1"] = process.argv.slice(2);
const within = Number(pixels);
const VIEWS = 200;
await loadModelDecoder();
const model = new ProgressiveModel(new Uint8Array(await readFile(path)));
const { mesh } = model;
const box = new Box3().setFromArray(mesh.positions);
const [size, centre] = [box.getSize(new Vector3()), box.getCenter(new Vector3())];
const [longest, , shortest] = ["x", "y", "z"].sort((a, b) => size[b] - size[a]);

const camera = new PerspectiveCamera(45, 1280 / 720, size.length() / 1e4, 2 * size.length());
camera.up = new Vector3(...["x", "y", "z"].map((axis) => (axis === shortest ? 1 : 0)));
const focalLength = 720 / (2 * Math.tan(Math.PI / 8));

function viewAt(along) {
  const eye = centre.clone();
  eye[longest] += size[longest] * (1.2 * along - 0.85);
  eye[shortest] += 0.75 * size[shortest];
  camera.position.copy(eye);
  const ahead = centre.clone();
  ahead[longest] = eye[longest] + 0.5 * size[longest];
  camera.lookAt(ahead);
  camera.updateMatrixWorld();
  camera.updateProjectionMatrix();
  const { planes } = new Frustum().setFromProjectionMatrix(camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse));
  return { eye: eye.toArray(), frustum: planes.flatMap(({ normal, constant }) => [...normal, constant]), focalLength, within };
}

/** Triangles of the coarsest level whose error is more pixels nowhere, by the distance of the nearest vertex of the model. */
function ofLevel({ eye }) {
  let distance = Infinity;
  for (let at = 0; at < 3 * mesh.representatives.length; at += 3) {
    distance = Math.min(distance, Math.hypot(...[0, 1, 2].map((axis) => mesh.positions[at + axis] - eye[axis])));
  }
  return (mesh.levels.find(({ error }) => (error * focalLength) / distance <= within) ?? mesh.levels.at(-1)).triangleEnd;
}

const started = performance.now();
const first = model.refine(viewAt(0));
const figures = { triangles: first.triangles, levels: ofLevel(viewAt(0)), changes: 0, redrawn: 0, milliseconds: 0, slowest: 0 };
const building = performance.now() - started;
for (let view = 1; view < VIEWS; view++) {
  const from = viewAt(view / VIEWS);
  const since = performance.now();
  const { triangles, changes, places } = model.refine(from);
  const milliseconds = performance.now() - since;
  figures.triangles += triangles;
  figures.levels += ofLevel(from);
  figures.changes += changes;
  figures.redrawn += places.length;
  figures.milliseconds += milliseconds;
  figures.slowest = Math.max(figures.slowest, milliseconds);
}
const each = (sum) => Number((sum / VIEWS).toFixed(2));
console.log({
  model: path, within, trianglesOfAll: mesh.corners.length / 3, buildingMilliseconds: Math.round(building), share: Number((figures.triangles / figures.levels).toFixed(3)),
  triangles: each(figures.triangles), trianglesOfLevels: each(figures.levels), changes: each(figures.changes), redrawnTriangles: each(figures.redrawn),
  milliseconds: each(figures.milliseconds), slowest: Number(figures.slowest.toFixed(1)),
});
