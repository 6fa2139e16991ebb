// Decoder of the progressive terrain tile; docs/formats/spt.md is the definition.

import { MAX_ZOOM, type Address } from "./address.ts";

const HEADER_BYTES = 32;
const ENTRY_BYTES = 32;
const MAGIC = 0x4c545053; // "SPTL", little-endian
const VERSION = 1;
const SIDES = 4;
const INTERIOR_KIND = 0;

/** What a tile may ask of the browser; far above any real tile, far below what would hurt. */
const LIMITS = { extentBits: 40, levels: 256, vertices: 1 << 20, triangles: 1 << 21, inflatedBytes: 1 << 26 };

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
export async function decodeTile(bytes: Uint8Array): Promise<Tile> {
  const header = readHeader(bytes);
  const entries = readDirectory(bytes, header.levelCount);
  const inflated = await Promise.all(entries.map((entry, index) => inflate(bytes, entry, index)));
  return new LevelReader(header, entries).read(inflated);
}

interface Header {
  readonly address: Address;
  readonly extentBits: number;
  readonly heightStep: number;
  readonly lowest: number;
  readonly highest: number;
  readonly levelCount: number;
}

interface Entry extends Level {
  readonly offset: number;
  readonly length: number;
  readonly inflatedLength: number;
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
  const [lowest, highest] = [view.getInt32(16, true), view.getInt32(20, true)];
  check(lowest <= highest, "the lowest height is above the highest");
  const levelCount = view.getUint16(24, true);
  check(levelCount > SIDES && levelCount <= LIMITS.levels, `${levelCount} levels`);
  check(view.getUint16(26, true) === 0, "reserved bytes are not 0");
  check(view.getUint32(28, true) === bytes.length, `${bytes.length} bytes, ${view.getUint32(28, true)} announced`);
  return { address, extentBits, heightStep: 2 ** view.getInt8(7), lowest, highest, levelCount };
}

function readDirectory(bytes: Uint8Array, levelCount: number): Entry[] {
  const end = HEADER_BYTES + levelCount * ENTRY_BYTES;
  check(end <= bytes.length, "the directory is cut off");
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const entries: Entry[] = [];
  let previous: Entry = { offset: end, length: 0, vertexEnd: 0, triangleEnd: 0, error: Infinity, inflatedLength: 0 };
  for (let index = 0; index < levelCount; index++) {
    const kind = Math.max(INTERIOR_KIND, index - (levelCount - SIDES) + 1);
    previous = readEntry(view, HEADER_BYTES + index * ENTRY_BYTES, kind, previous, `level ${index}`);
    entries.push(previous);
  }
  check(previous.offset + previous.length === bytes.length, "the levels do not fill the tile");
  return entries;
}

function readEntry(view: DataView, at: number, kind: number, previous: Entry, name: string): Entry {
  check(view.getUint32(at, true) === kind, `${name} is of kind ${view.getUint8(at)} where ${kind} should be`);
  const entry = {
    offset: view.getUint32(at + 4, true),
    length: view.getUint32(at + 8, true),
    vertexEnd: view.getUint32(at + 12, true),
    triangleEnd: view.getUint32(at + 16, true),
    error: view.getFloat32(at + 20, true),
    inflatedLength: view.getUint32(at + 28, true),
  };
  check(entry.offset === previous.offset + previous.length, `${name} does not follow the one before it`);
  check(entry.offset + entry.length <= view.byteLength, `${name} is cut off`);
  check(entry.vertexEnd >= previous.vertexEnd && entry.vertexEnd <= LIMITS.vertices, `${name}: bad vertex count`);
  const grows = entry.triangleEnd >= previous.triangleEnd && entry.triangleEnd <= LIMITS.triangles;
  check(grows, `${name}: bad triangle count`);
  check(entry.error >= 0 && entry.error <= previous.error, `${name}: bad error ${entry.error}`);
  check(entry.inflatedLength <= LIMITS.inflatedBytes, `${name} inflates to ${entry.inflatedLength} bytes`);
  return entry;
}

/** Inflates one level, and stops as soon as it turns out longer than announced. */
async function inflate(bytes: Uint8Array, entry: Entry, index: number): Promise<Uint8Array> {
  const source = new Blob([bytes.slice(entry.offset, entry.offset + entry.length)]);
  const reader = source.stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
  const inflated = new Uint8Array(entry.inflatedLength);
  let length = 0;
  for (;;) {
    const { done, value } = await reader.read().catch((cause: unknown) => {
      throw new TileError(`level ${index} is not raw deflate`, { cause });
    });
    if (done) break;
    check(length + value.length <= inflated.length, `level ${index} is longer than announced`);
    inflated.set(value, length);
    length += value.length;
  }
  check(length === inflated.length, `level ${index} is shorter than announced`);
  return inflated;
}

/** A run of LEB128 integers. */
class Integers {
  private at = 0;

  constructor(
    private readonly bytes: Uint8Array,
    private readonly name: string,
  ) {}

  unsigned(): number {
    let value = 0;
    // Seven bytes hold 49 bits, all exact in a double and enough for the longest difference of lattice coordinates.
    for (let scale = 1; scale < 2 ** 49; scale *= 128) {
      const byte = this.bytes[this.at++];
      check(byte !== undefined, `${this.name} ends within a number`);
      value += (byte & 127) * scale;
      if (byte < 128) return value;
    }
    throw new TileError(`${this.name} has a number of more than 49 bits`);
  }

  signed(): number {
    const zigzag = this.unsigned();
    return zigzag % 2 === 0 ? zigzag / 2 : -(zigzag + 1) / 2;
  }

  finish(): void {
    check(this.at === this.bytes.length, `${this.name} has bytes to spare`);
  }
}

/** Reads the levels of one tile, coarsest first, into its arrays. */
class LevelReader {
  private readonly vertexCount: number;
  private readonly positions: Float64Array;
  private readonly representatives: Uint32Array;
  private readonly corners: Uint32Array;
  /** For each vertex, where its position is now: its own place, or that of the vertex which restored another. */
  private readonly current: Uint32Array;

  constructor(
    private readonly header: Header,
    private readonly levels: readonly Entry[],
  ) {
    const last = levels[levels.length - 1];
    this.vertexCount = last?.vertexEnd ?? 0;
    this.positions = new Float64Array(6 * this.vertexCount);
    this.representatives = Uint32Array.from({ length: this.vertexCount }, (_, vertex) => vertex);
    this.corners = new Uint32Array(3 * (last?.triangleEnd ?? 0));
    this.current = Uint32Array.from(this.representatives);
  }

  read(inflated: readonly Uint8Array[]): Tile {
    let [vertexStart, triangleStart] = [0, 0];
    this.levels.forEach(({ vertexEnd, triangleEnd }, index) => {
      const integers = new Integers(inflated[index] ?? new Uint8Array(), `level ${index}`);
      this.readVertices(integers, vertexStart, vertexEnd, index === 0);
      this.readTriangles(integers, triangleStart, triangleEnd);
      integers.finish();
      [vertexStart, triangleStart] = [vertexEnd, triangleEnd];
    });
    for (let at = 2; at < this.positions.length; at += 3) this.positions[at]! *= this.header.heightStep;
    const { address, extentBits } = this.header;
    const { levels, positions, representatives, corners } = this;
    return { address, extentBits, levels, positions, representatives, corners };
  }

  private readVertices(integers: Integers, start: number, end: number, isCoarsest: boolean): void {
    let previous = [0, 0, 0];
    for (let vertex = start; vertex < end; vertex++) {
      previous = this.readPosition(integers, vertex, previous);
      if (isCoarsest) {
        this.positions.copyWithin(3 * (this.vertexCount + vertex), 3 * vertex, 3 * vertex + 3);
      } else {
        this.readRepresentative(integers, vertex);
      }
    }
  }

  private readRepresentative(integers: Integers, vertex: number): void {
    const back = integers.unsigned();
    check(back >= 1 && back <= vertex, `vertex ${vertex} has a representative that does not come before it`);
    const representative = vertex - back;
    const at = 3 * this.current[representative]!;
    this.readPosition(integers, this.vertexCount + vertex, Array.from(this.positions.subarray(at, at + 3)));
    this.representatives[vertex] = representative;
    this.current[representative] = this.vertexCount + vertex;
  }

  /** Heights stay in steps until all is read, so that differences are exact. */
  private readPosition(integers: Integers, place: number, origin: readonly number[]): number[] {
    const position = origin.map((coordinate) => coordinate + integers.signed());
    const [x = 0, y = 0, height = 0] = position;
    const extent = 2 ** this.header.extentBits;
    check(x >= 0 && x <= extent && y >= 0 && y <= extent, `position ${place} is outside the tile`);
    check(height >= this.header.lowest && height <= this.header.highest, `position ${place} is outside the heights`);
    this.positions.set(position, 3 * place);
    return position;
  }

  private readTriangles(integers: Integers, start: number, end: number): void {
    let first = 0;
    for (let triangle = start; triangle < end; triangle++) {
      first += integers.signed();
      const second = first + integers.signed();
      const corners = [first, second, second + integers.signed()];
      const inRange = corners.every((corner) => corner >= 0 && corner < this.vertexCount);
      check(inRange, `triangle ${triangle} has a corner out of range`);
      this.corners.set(corners, 3 * triangle);
    }
  }
}
