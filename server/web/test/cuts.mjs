// How many triangles a flight would draw if tiles were refined inside, by the graph of their vertex splits (the papers' local
// refinement), beside the tiles' levels that are drawn. No test: `npm run test:unit`, then
// node test/cuts.mjs ARCHIVE FLIGHT [PIXELS], FLIGHT being one of flights.mjs.

import { open } from "node:fs/promises";
import { Frustum, MathUtils, PerspectiveCamera, Vector3 } from "three";
import { PMTiles } from "pmtiles";
import { decodeTile, Frame, interiorLevels, keyOf, loadDecoder, select, Sight, tileBounds, triangleCount } from "../node_modules/.unit/src/index.js";
import { degreesOf } from "../node_modules/.unit/src/address.js";
import { CollapsingSurface, collapseGraph } from "../node_modules/.unit/src/collapse_graph.js";
import { TileStore } from "../node_modules/.unit/src/tile_store.js";
import { between, FLIGHTS, FRAMES, VIEWPORT } from "./flights.mjs";

const [path, flight, pixels = "2"] = process.argv.slice(2);
const tolerance = Number(pixels);
await loadDecoder();

const file = await open(path);
const getBytes = async (offset, length) => {
  const { buffer, bytesRead } = await file.read(new Uint8Array(length), 0, length, offset);
  return { data: buffer.buffer.slice(0, bytesRead) };
};
const archive = new PMTiles({ getKey: () => path, getBytes });
const metadata = await archive.getMetadata();
const [west, south, east, north] = metadata.bounds;
const frame = new Frame((west + east) / 2, (south + north) / 2);
const tileBytes = new Map();

async function loadTile(address, from) {
  const { zoom, x, y } = address;
  const { data } = await archive.getZxy(zoom + 1, x, 2 ** zoom - 1 - y);
  tileBytes.set(keyOf(address), new Uint8Array(data));
  return new Uint8Array(data, from);
}

const store = new TileStore({ name: path, metadata, source: { tile: loadTile } }, frame, { exaggeration: { value: 1 } }, () => {});

/** The splits of a tile's levels, the last one first: where they are, the triangles that they add, the later ones that need them. */
function splitsOf(address) {
  const tile = decodeTile(tileBytes.get(keyOf(address)));
  const first = tile.levels[0].vertexEnd;
  const placeOf = (vertex) => {
    const [[tileWest, tileSouth], unit] = [tileBounds(address), degreesOf(address.zoom) / 2 ** tile.extentBits];
    const [x, y, height] = tile.positions.subarray(3 * vertex, 3 * vertex + 3);
    return frame.position(tileWest + x * unit, tileSouth + y * unit, height);
  };
  const { needs } = collapseGraph(tile, first);
  const surface = new CollapsingSurface(tile.representatives.length, tile.corners);
  const splits = [];
  for (let blue = tile.representatives.length - 1; blue >= first; blue--) {
    const red = tile.representatives[blue];
    const [centre, star] = [placeOf(blue), surface.star(blue, red)];
    const radius = Math.max(...[...star].map((vertex) => placeOf(vertex).distanceTo(centre)));
    const level = tile.levels.findIndex(({ vertexEnd }) => blue < vertexEnd);
    splits.push({ blue, level, centre, radius, neededBy: needs[blue - first], triangles: surface.collapse(blue, red) });
  }
  return { tile, splits };
}

/** The smallest closed set of splits with all of which `isNeeded` holds, and its triangles. */
function cut({ tile, splits }, isNeeded) {
  const isIn = new Uint8Array(tile.representatives.length);
  let triangles = tile.levels[0].triangleEnd;
  for (const split of splits) {
    if (!isNeeded(split) && !split.neededBy.some((other) => isIn[other] === 1)) continue;
    isIn[split.blue] = 1;
    triangles += split.triangles;
  }
  return { isIn, triangles };
}

function cameraAt({ longitude, latitude, height, azimuth, down }) {
  const camera = new PerspectiveCamera(45, VIEWPORT.width / VIEWPORT.height, 1, 1e8);
  const [turn, dip] = [azimuth, down].map(MathUtils.degToRad);
  camera.up.set(0, 0, 1);
  camera.position.copy(frame.position(longitude, latitude, height));
  const ahead = new Vector3(Math.cos(dip) * Math.sin(turn), Math.cos(dip) * Math.cos(turn), -Math.sin(dip));
  camera.lookAt(ahead.multiplyScalar(1000).add(camera.position));
  camera.updateMatrixWorld();
  camera.updateProjectionMatrix();
  const { planes } = new Frustum().setFromProjectionMatrix(camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse));
  return { eye: camera.position, pixelsPerRadian: VIEWPORT.height / (2 * Math.tan(Math.PI / 8)), frustum: planes, ground: undefined, farthest: Infinity };
}

/** What is drawn once all is loaded. */
async function choicesFor(camera, before) {
  for (;;) {
    const demand = { tolerance, keep: 0.8, triangles: Infinity, bytes: Infinity };
    const { choices, requests } = select(store, camera, demand, before);
    if (requests.length === 0) return choices;
    for (const { address } of requests) await store.load({ address, levels: Infinity });
    store.takeUp();
  }
}

const known = new Map();
let [before, beforeCuts, sums] = [[], new Map(), { pictures: 0, tiles: 0, levels: 0, cut: 0, closedSides: 0, changedLevels: 0, changedCuts: 0, milliseconds: 0 }];
const moments = FLIGHTS[flight];
for (let step = 0; step < FRAMES * (moments.length - 1); step++) {
  const leg = Math.floor(step / FRAMES);
  const camera = cameraAt(between(moments[leg], moments[leg + 1], (step % FRAMES) / FRAMES));
  const choices = await choicesFor(camera, before);
  const sight = new Sight(camera);
  const cuts = new Map();
  for (const choice of choices.filter(({ address }) => sight.sees(store.bounds(address)))) {
    const key = keyOf(choice.address);
    if (!known.has(key)) known.set(key, splitsOf(choice.address));
    const { tile } = known.get(key);
    const interior = interiorLevels(tile);
    const isOfFineSide = ({ level }) => level >= interior && choice.fineSides[level - interior];
    const isNeeded = (split) => {
      if (split.level >= interior) return isOfFineSide(split);
      const distance = Math.max(1, split.centre.distanceTo(camera.eye) - split.radius);
      const isInSight = camera.frustum.every(({ normal, constant }) => normal.dot(split.centre) + constant + split.radius >= 0);
      return isInSight && (tile.levels[split.level - 1].error * camera.pixelsPerRadian) / distance > tolerance;
    };
    const since = performance.now();
    const refined = cut(known.get(key), isNeeded);
    sums.milliseconds += performance.now() - since;
    cuts.set(key, { choice, isIn: refined.isIn });
    const level = store.levels(choice.address).findIndex(({ error }) => (error * camera.pixelsPerRadian) / Math.max(1, distanceOf(choice, camera)) <= tolerance);
    const wanted = level < 0 ? interior - 1 : level;
    sums.closedSides += cut(known.get(key), (split) => (split.level < interior ? split.level <= wanted : isOfFineSide(split))).triangles;
    sums.tiles++;
    sums.levels += triangleCount(tile, choice);
    sums.cut += refined.triangles;
    const earlier = beforeCuts.get(key);
    if (earlier === undefined) continue;
    sums.changedLevels += Number(JSON.stringify([choice.interior, choice.fineSides]) !== JSON.stringify([earlier.choice.interior, earlier.choice.fineSides]));
    sums.changedCuts += Number(refined.isIn.some((isIn, at) => isIn !== earlier.isIn[at]));
  }
  sums.pictures++;
  [before, beforeCuts] = [choices, cuts];
}

function distanceOf({ address }, { eye }) {
  const { centre, axes, halfSizes } = store.bounds(address);
  const offset = eye.clone().sub(centre);
  return Math.hypot(...axes.map((axis, at) => Math.max(0, Math.abs(offset.dot(axis)) - halfSizes[at])));
}

const each = (sum) => sum / sums.pictures;
console.log({
  flight, pixels: tolerance, pictures: sums.pictures, tilesInSight: each(sums.tiles), trianglesOfLevels: each(sums.levels),
  trianglesOfCuts: each(sums.cut), share: sums.cut / sums.levels, shareIfOnlySidesAreClosed: sums.closedSides / sums.levels,
  tilesWhoseLevelChanges: each(sums.changedLevels), tilesWhoseCutChanges: each(sums.changedCuts), millisecondsOfCuts: each(sums.milliseconds),
});
