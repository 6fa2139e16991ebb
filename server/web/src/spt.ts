// Decoder of the progressive terrain tile; docs/formats/spt.md is the definition.

import { MAX_ZOOM, type Address } from "./address.ts";
import { decodeLevels, LevelError, type Frame, type Levels } from "./progressive/levels.ts";
import type { Sampling } from "./progressive/split_decoder.ts";
import type { Point } from "./progressive/surface.ts";

const HEADER_BYTES = 72;
const ENTRY_BYTES = 20;
const MAGIC = 0x4c545053; // "SPTL", little-endian
const VERSION = 2;
const SIDES = 4;
const SAMPLED = 1;
/** Samples lie at least so far from each other and at most so far from the tile's corner, in lattice units. */
const [LEAST_STEP, GREATEST_DISTANCE] = [2 ** -16, 2 ** 41];

/** What a tile may ask of the browser; far above any real tile, far below what would hurt. */
const LIMITS = { extentBits: 40, levels: 256, vertices: 1 << 20, triangles: 1 << 21 };

/** How far the arrays reach for one level, and what its surface is good for. */
export interface Level {
  /** Vertices of this level and all before it. */
  readonly vertexEnd: number;
  /** Triangles of this level and all before it. */
  readonly triangleEnd: number;
  /** Certified vertical error of the surface so far, metres. */
  readonly error: number;
}

/** A decoded tile. The last four levels are the sides west, south, east and north. */
export interface Tile {
  readonly address: Address;
  /** The tile's side is 2^extentBits lattice units. */
  readonly extentBits: number;
  readonly levels: readonly Level[];
  /**
   * x, y in lattice units from the south-west corner and height in metres, for n vertices as stored, then n times
   * where each vertex's representative goes when the vertex comes in (its own place in level 0).
   */
  readonly positions: Float64Array;
  /** Vertex that each one is drawn at until its level comes in; itself in level 0. */
  readonly representatives: Uint32Array;
  /** Three corners a triangle, in the numbering of the finest surface. */
  readonly corners: Uint32Array;
}

/** Bytes that are not a tile of this format. */
export class TileError extends Error {
  override readonly name = "TileError";
}

/** How many levels come before the sides. */
export function interiorLevels(tile: Tile): number {
  return tile.levels.length - SIDES;
}

/** Decodes a whole tile; throws a {@link TileError} when a length, count, index or coordinate is out of range. */
export function decodeTile(bytes: Uint8Array): Tile {
  const header = readHeader(bytes);
  const entries = readDirectory(bytes, header.levelCount);
  const runs = entries.map((entry) => ({ ...entry, bytes: bytes.subarray(entry.start, entry.end) }));
  try {
    return tileOf(header, entries, decodeLevels(header.frame, runs));
  } catch (error) {
    throw error instanceof LevelError ? new TileError(error.message, { cause: error }) : error;
  }
}

interface Header {
  readonly address: Address;
  readonly extentBits: number;
  readonly heightStep: number;
  readonly levelCount: number;
  readonly frame: Frame;
}

interface Entry extends Level {
  readonly start: number;
  readonly end: number;
}

function check(condition: boolean, message: string): asserts condition {
  if (!condition) throw new TileError(message);
}

function readHeader(bytes: Uint8Array): Header {
  check(bytes.length >= HEADER_BYTES, `${bytes.length} bytes are too few for a header`);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  check(view.getUint32(0, true) === MAGIC, "the magic is not SPTL");
  check(view.getUint8(4) === VERSION, `version ${view.getUint8(4)} is not ${VERSION}`);
  const address = { zoom: view.getUint8(5), x: view.getUint32(8, true), y: view.getUint32(12, true) };
  check(address.zoom <= MAX_ZOOM, `zoom ${address.zoom} is above ${MAX_ZOOM}`);
  check(address.x < 2 ** (address.zoom + 1) && address.y < 2 ** address.zoom, "the address is off the Earth");
  const extentBits = view.getUint8(6);
  check(extentBits <= LIMITS.extentBits, `an extent of 2^${extentBits} lattice units`);
  const levelCount = view.getUint16(24, true);
  check(levelCount > SIDES && levelCount <= LIMITS.levels, `${levelCount} levels`);
  check(view.getUint32(28, true) === bytes.length, `${bytes.length} bytes, ${view.getUint32(28, true)} announced`);
  const frame = readFrame(view, 2 ** extentBits);
  return { address, extentBits, heightStep: 2 ** view.getInt8(7), levelCount, frame };
}

function readFrame(view: DataView, extent: number): Frame {
  const [lowest, highest] = [view.getInt32(16, true), view.getInt32(20, true)];
  check(lowest <= highest, "the lowest height is above the highest");
  return {
    low: [0, 0, lowest],
    high: [extent, extent, highest],
    sampling: (view.getUint16(26, true) & SAMPLED) !== 0 ? readSampling(view) : undefined,
    boundaryLevels: SIDES,
    baseVertices: view.getUint32(32, true),
    baseTriangles: view.getUint32(36, true),
  };
}

function readSampling(view: DataView): Sampling {
  const number = (at: number) => view.getFloat64(at, true);
  const sampling = { origin: [number(40), number(48)], step: [number(56), number(64)] } as const;
  const isNear = sampling.origin.every((coordinate) => Math.abs(coordinate) <= GREATEST_DISTANCE);
  const isApart = sampling.step.every((step) => step >= LEAST_STEP && step <= GREATEST_DISTANCE);
  check(isNear && isApart, "the samples are out of range");
  return sampling;
}

function readDirectory(bytes: Uint8Array, levelCount: number): Entry[] {
  const end = HEADER_BYTES + levelCount * ENTRY_BYTES;
  check(end <= bytes.length, "the directory is cut off");
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const entries: Entry[] = [];
  let previous: Entry = { start: end, end, vertexEnd: 0, triangleEnd: 0, error: Infinity };
  for (let index = 0; index < levelCount; index++) {
    previous = readEntry(view, HEADER_BYTES + index * ENTRY_BYTES, previous, `level ${index}`);
    entries.push(previous);
  }
  check(previous.end === bytes.length, "the levels do not fill the tile");
  return entries;
}

function readEntry(view: DataView, at: number, previous: Entry, name: string): Entry {
  const entry = {
    start: previous.end,
    end: view.getUint32(at, true),
    vertexEnd: view.getUint32(at + 4, true),
    triangleEnd: view.getUint32(at + 8, true),
    error: view.getFloat32(at + 12, true),
  };
  check(entry.end >= entry.start && entry.end <= view.byteLength, `${name} is cut off`);
  check(entry.vertexEnd >= previous.vertexEnd && entry.vertexEnd <= LIMITS.vertices, `${name}: bad vertex count`);
  const grows = entry.triangleEnd >= previous.triangleEnd && entry.triangleEnd <= LIMITS.triangles;
  check(grows, `${name}: bad triangle count`);
  check(entry.error >= 0 && entry.error <= previous.error, `${name}: bad error ${entry.error}`);
  return entry;
}

/** The arrays of a tile; heights become metres. */
function tileOf(header: Header, levels: readonly Level[], decoded: Levels): Tile {
  const flat = (points: readonly Point[]) => points.flatMap(([x, y, height]) => [x, y, height * header.heightStep]);
  return {
    address: header.address,
    extentBits: header.extentBits,
    levels,
    positions: Float64Array.from([...flat(decoded.madeAt), ...flat(decoded.restored)]),
    representatives: Uint32Array.from(decoded.representatives),
    corners: Uint32Array.from(decoded.corners),
  };
}
