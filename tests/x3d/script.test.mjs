// The script against the test vectors that drive the library, too.

import assert from "node:assert/strict";
import { readdir, readFile } from "node:fs/promises";
import { test } from "node:test";
import { startScript } from "./script.mjs";

const FOLDERS = ["../vectors/", "../../../shared/vectors/"];

/** The vectors of a kind whose vertices are points in space. */
async function vectorsOf(kind) {
  const files = [];
  for (const folder of FOLDERS.map((path) => new URL(path, import.meta.url))) {
    const names = await readdir(folder).catch(() => []);
    files.push(...names.filter((name) => name.endsWith(".json")).map((name) => new URL(name, folder)));
  }
  const vectors = await Promise.all(files.map(async (file) => JSON.parse(await readFile(file, "utf8"))));
  return vectors.filter((vector) => vector.kind === kind && (vector.dimension ?? 3) === 3);
}

/** The script with a whole text, in pieces of so many characters. */
async function loaded(text, pieceLength = text.length, options = {}) {
  const run = startScript(options);
  for (let at = 0; at < text.length; at += pieceLength) run.send(text.slice(at, at + pieceLength));
  run.close();
  await run.settle();
  return run;
}

test("every level and geomorph is what the library draws, in pieces of any size", async () => {
  const vectors = await vectorsOf("multilevel");
  assert.ok(vectors.some(({ name }) => name === "multilevel_solid"));
  for (const { name, text, expected } of vectors) {
    for (const pieceLength of [1, 7, text.length]) {
      const run = await loaded(text, pieceLength);
      assert.deepEqual(run.errors, [], name);
      for (const [level, triangles] of expected.lods.entries()) {
        run.script.set_level(level);
        const positions = expected.positions.slice(0, expected.vertices_in_lod[level]);
        assert.deepEqual(run.drawn(), { triangles, positions }, `${name}, level ${level}`);
      }
      for (const { level, triangles, positions } of expected.geomorphs) {
        run.script.set_fractional_level(level);
        assert.deepEqual(run.drawn(), { triangles, positions }, `${name}, level ${level}`);
      }
    }
  }
});

test("what the library refuses is refused in a line", async () => {
  const vectors = await vectorsOf("malformed");
  const texts = vectors.flatMap(({ texts }) => texts);
  assert.ok(texts.length >= 18, `only ${texts.length} texts`);
  for (const text of texts) {
    const { errors } = await loaded(text);
    assert.equal(errors.length, 1, JSON.stringify(text));
    assert.match(errors[0], /^model\.lod: .+$/, JSON.stringify(text));
  }
});

/** Vertices 3 and 4 collapse into 1, the latter by way of the former. */
const LEVELS = [
  "{0 0 0  4 0 0  0 4 0}{0 4 2  3 1}",
  "{2 0 1}{3 1 2 # a comment that \n}",
  "{1 0 2}{4 3 2}",
];
const LODS = [
  [[0, 4, 2], [3, 1, 2], [4, 3, 2]],
  [[0, 3, 2], [3, 1, 2]],
  [[0, 1, 2]],
];

test("a level is drawn as soon as its last brace is there", async () => {
  const run = startScript();
  run.send(LEVELS[0].slice(0, -1));
  await run.settle();
  assert.deepEqual(run.events, []);
  run.send("}");
  await run.settle();
  assert.deepEqual(run.drawn().triangles, LODS[2]);
  assert.deepEqual(run.events, [["levelCount_changed", 1], ["isReady", true], ["level_changed", 0]]);
});

test("the finest level there is gets drawn, whichever arrives", async () => {
  const run = startScript();
  for (const [index, level] of LEVELS.entries()) {
    run.send(level);
    await run.settle();
    assert.deepEqual(run.drawn().triangles, LODS[2 - index]);
  }
  run.close();
  await run.settle();
  assert.deepEqual(run.errors, []);
});

test("a level that was asked for stays so many levels behind the finest", async () => {
  const run = startScript();
  run.script.set_level(1);
  assert.deepEqual(run.drawn().triangles, []);
  for (const [level, lod] of [[LEVELS[0], LODS[2]], [LEVELS[1], LODS[2]], [LEVELS[2], LODS[1]]]) {
    run.send(level);
    await run.settle();
    assert.deepEqual(run.drawn().triangles, lod);
  }
});

test("levels outside are the nearest there is, and what is no number changes nothing", async () => {
  const run = await loaded(LEVELS.join(""));
  const drawnLevels = () => run.events.filter(([name]) => name === "level_changed").map(([, level]) => level);
  const before = drawnLevels().length;
  run.script.set_level(9);
  run.script.set_level(-1);
  run.script.set_fractional_level(2.5);
  run.script.set_fractional_level(NaN);
  run.script.set_fractional_level(0.1);
  assert.deepEqual(drawnLevels().slice(before), [2, 0, 2, 0.1]);
});

test("coordinates are told relative to the origin, before they are rounded", async () => {
  const run = await loaded("{5000000.1 0 1  5000001 0 0  5000000 1 0}{0 1 2}", 9, { origin: [5000000, 0, 1] });
  assert.deepEqual(run.drawn().positions[0].map(Math.fround), [5000000.1 - 5000000, 0, 0].map(Math.fround));
});

test("the file is looked for beside the world, and what a server refuses is told", async () => {
  const run = startScript({ status: 404 });
  await run.settle();
  assert.deepEqual(run.requests, ["http://host/folder/model.lod"]);
  assert.deepEqual(run.errors, ["model.lod: the server answers 404"]);
});

test("every level is told where debug is set", async () => {
  const run = await loaded(LEVELS.join(""), 9, { debug: true });
  assert.deepEqual(run.printed, [1, 2, 3].map((count) => `model.lod: ${count} levels, ${count} triangles`));
});

test("a world that is left ends its download without a word", async () => {
  const run = startScript();
  run.send(LEVELS[0]);
  await run.settle();
  run.script.shutdown();
  run.fail();
  await run.settle();
  assert.deepEqual(run.errors, []);
});
