// The script of the prototype MultiLevelProgIfs: streams a progressive multilevel mesh over HTTP into an IndexedFaceSet,
// level by level, and draws any level of detail, also while the rest is on its way.
//
// After A. Guéziec, G. Taubin, B. Horn, F. Lazarus, "A Framework for Streaming Geometry in VRML", IEEE Computer Graphics
// and Applications 19(2), 1999, "VRML implementation". What they do in a thread of its own is an asynchronous function
// here. Levels are numbered as they are in the paper: 0 is the finest one there is; while the mesh loads, every arriving
// level becomes level 0.
//
// The browser gives the script the fields `urlData`, `debug`, `origin` and `ifs`, takes what is assigned to `isReady`,
// `level_changed` and `levelCount_changed`, and calls the functions at the end, which have the names of events.

"use strict";

/** No browser draws more vertices; a file that names one beyond is broken, and would fill the memory. */
const LARGEST_INDEX = 2 ** 24 - 1;

/** Vertices and triangles in order of decreasing level, so that a level of detail is a prefix of both. */
class MultilevelMesh {
  /** Three numbers a vertex. */
  positions = [];
  /** Three vertices a triangle, those of the finest surface. */
  corners = [];
  /** What stands for a vertex that is not there; itself, where nothing does. Some vertices have yet to come. */
  representatives = [];
  /** How far the arrays reach for one level of detail, coarsest first. */
  ends = [];

  get vertexCount() {
    return this.positions.length / 3;
  }

  get levelCount() {
    return this.ends.length;
  }

  addVertex(position) {
    this.positions.push(...position);
    this.know(this.vertexCount - 1);
  }

  addTriangle(corners) {
    if (new Set(corners).size < 3) throw new Error(`a triangle uses a vertex twice: ${corners.join(", ")}`);
    corners.forEach((corner) => this.know(corner));
    this.corners.push(...corners);
  }

  /** Whether a vertex is missing and nothing stands for it. */
  isUnrepresented(vertex) {
    return vertex >= this.vertexCount && this.representatives[vertex] === vertex;
  }

  setRepresentative(vertex, representative) {
    if (representative >= vertex) throw new Error(`vertex ${vertex} cannot be represented by ${representative}`);
    this.representatives[vertex] = representative;
  }

  /** Checks that no vertex is missing any more. */
  checkComplete() {
    const { vertexCount, representatives } = this;
    if (this.levelCount === 0) throw new Error("there is no level");
    if (representatives.length > vertexCount) {
      throw new Error(`vertex ${representatives.length - 1} is used, but there are only ${vertexCount} vertices`);
    }
  }

  /** The paper's addLevel(): what has been added since the last level becomes level 0. */
  endLevel() {
    this.ends.push({ vertices: this.vertexCount, corners: this.corners.length });
  }

  /** How far the arrays reach for a level; nothing where there is no such level. */
  end(level) {
    return this.ends[this.ends.length - 1 - level];
  }

  /**
   * The path-compressed representatives: for each vertex the one below `present` that stands for it, else itself. One pass
   * does, because representatives come before their vertices.
   */
  roots(present) {
    const { representatives } = this;
    const roots = new Int32Array(representatives.length);
    for (let vertex = 0; vertex < roots.length; vertex++) {
      roots[vertex] = vertex;
      const reached = roots[representatives[vertex]];
      if (vertex >= present && reached < present) roots[vertex] = reached;
    }
    return roots;
  }

  know(vertex) {
    const { representatives } = this;
    while (representatives.length <= vertex) representatives.push(representatives.length);
  }
}

/** The vertices that triangles of a level of detail are drawn with. */
function drawnCorners(mesh, level) {
  const end = mesh.end(level);
  const roots = mesh.roots(end.vertices);
  return mesh.corners.slice(0, end.corners).map((corner) => roots[corner]);
}

/**
 * Positions of a level of detail, the vertices that the next coarser one lacks `weight` of the way to what represents them
 * there (the paper's geomorph).
 */
function drawnPositions(mesh, level, weight) {
  const positions = mesh.positions.slice(0, 3 * mesh.end(level).vertices);
  const coarser = mesh.end(level + 1);
  if (weight === 0 || coarser === undefined) return positions;
  const roots = mesh.roots(coarser.vertices);
  for (let at = 3 * coarser.vertices; at < positions.length; at++) {
    const representative = mesh.positions[3 * roots[Math.floor(at / 3)] + (at % 3)];
    positions[at] = positions[at] * (1 - weight) + representative * weight;
  }
  return positions;
}

/** Cuts text that arrives in pieces into braces and words; commas and white space only separate. */
class Tokenizer {
  rest = "";

  *tokens(piece) {
    const text = this.rest + piece;
    const end = text.search(/(#[^\n]*|[^ \t\r\n\f,{}#]*)$/); // a word or comment that may go on in the next piece
    this.rest = text.slice(end);
    for (const [token] of text.slice(0, end).matchAll(/#[^\n]*|[{}]|[^ \t\r\n\f,{}#]+/g)) {
      if (!token.startsWith("#")) yield token;
    }
  }
}

/** What the reader waits for between two levels. */
const NEXT_LEVEL = "a level";

/**
 * Reads the paper's file into `mesh`, one token per `next`, which returns what comes next; calls `levelAdded` whenever a
 * level is whole.
 */
function* levelReader(mesh, levelAdded) {
  for (;;) {
    expectBrace(yield NEXT_LEVEL);
    for (let token = yield; token !== "}"; token = yield) {
      mesh.addVertex([toCoordinate(token), toCoordinate(yield), toCoordinate(yield)]);
    }
    expectBrace(yield);
    for (let token = yield; token !== "}"; token = yield) {
      const corners = [toIndex(token), toIndex(yield), toIndex(yield)];
      mesh.addTriangle(corners);
      for (let vertex of corners) {
        while (mesh.isUnrepresented(vertex)) {
          mesh.setRepresentative(vertex, toIndex(yield));
          vertex = mesh.representatives[vertex];
        }
      }
    }
    mesh.endLevel();
    levelAdded();
  }
}

function expectBrace(token) {
  if (token !== "{") throw new Error(`expected '{', found '${token}'`);
}

function toCoordinate(token) {
  const coordinate = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(token) ? Number(token) : NaN;
  if (!Number.isFinite(coordinate)) throw new Error(`expected a coordinate, found '${token}'`);
  return coordinate;
}

function toIndex(token) {
  const index = /^\+?\d+$/.test(token) ? Number(token) : NaN;
  if (!(index <= LARGEST_INDEX)) throw new Error(`expected a vertex below ${LARGEST_INDEX + 1}, found '${token}'`);
  return index;
}

const mesh = new MultilevelMesh();
const download = new AbortController();
let requestedLevel = 0;

/** The download goes on after this; a browser that got a promise from here would wait for it. */
function initialize() {
  stream().catch((error) => {
    if (!download.signal.aborted) console.error(`${urlData}: ${error.message}`);
  });
}

function shutdown() {
  download.abort();
}

async function stream() {
  const response = await fetch(new URL(urlData, Browser.currentScene.worldURL), { signal: download.signal });
  if (!response.ok) throw new Error(`the server answers ${response.status}`);
  const text = response.body.pipeThrough(new TextDecoderStream()).getReader();
  const levels = levelReader(mesh, announceLevel);
  const tokenizer = new Tokenizer();
  let awaited = levels.next().value;
  for (let piece = await text.read(); !piece.done; piece = await text.read()) {
    for (const token of tokenizer.tokens(piece.value)) awaited = levels.next(token).value;
  }
  if (awaited !== NEXT_LEVEL) throw new Error("the file ends inside a level");
  mesh.checkComplete();
}

function announceLevel() {
  if (debug) Browser.println(`${urlData}: ${mesh.levelCount} levels, ${mesh.corners.length / 3} triangles`);
  levelCount_changed = mesh.levelCount;
  isReady = true;
}

/** Draws the level that was asked for last, or the nearest there is so far. */
function draw() {
  if (mesh.levelCount === 0) return;
  const level = Math.min(Math.max(requestedLevel, 0), mesh.levelCount - 1);
  const finer = Math.floor(level);
  ifs.coord.point = toPoints(drawnPositions(mesh, finer, level - finer));
  ifs.coordIndex = toCoordIndex(drawnCorners(mesh, finer));
  level_changed = level;
}

/** Relative to the origin, because X3D has single precision. */
function toPoints(positions) {
  const { x, y, z } = origin;
  const points = new MFVec3f();
  for (let at = 0; at < positions.length; at += 3) {
    points[at / 3] = new SFVec3f(positions[at] - x, positions[at + 1] - y, positions[at + 2] - z);
  }
  return points;
}

/** Every triangle ends with −1. */
function toCoordIndex(corners) {
  const indices = new MFInt32();
  for (let at = 0; at < corners.length; at++) {
    indices[at + Math.floor(at / 3)] = corners[at];
    if (at % 3 === 2) indices[at + (at + 1) / 3] = -1;
  }
  return indices;
}

/** The browser is ready to draw what has arrived. */
function update() {
  draw();
}

/** The paper's setLevel(int). */
function set_level(level) {
  requestedLevel = level;
  draw();
}

/** The paper's setLevel(float): a geomorph. */
function set_fractional_level(level) {
  if (!Number.isNaN(level)) set_level(level);
}
