// Decoder of the progressive terrain tile; docs/formats/spt.md is the definition.

import { MAX_ZOOM, type Address } from "./address.ts";
import { check } from "./progressive/decode_error.ts";
import { endsOf, HeaderCut, Numbers, readDirectory, readSampling, type Entry, type Level } from "./progressive/fields.ts";
import { LevelsDecoder, type Frame, type Levels, type Run } from "./progressive/levels.ts";

/** Bytes of the header before the numbers of any length. */
const FIXED_BYTES = 49;
const MAGIC = 0x4c545053; // "SPTL", little-endian
/** Of a tile in which no split opens a hole, and of one in which some may. */
const [VERSION, VERSION_WITH_HOLES, VERSION_WITH_BREAKLINES, VERSION_WITH_FILLED] = [3, 4, 5, 6];
const SIDES = 4;
const SAMPLED = 1;
const OPENS_HOLES = 2;

/** What a tile may ask of the browser; far above any real tile, far below what would hurt. */
const LIMITS = { extentBits: 40, levels: 256, vertices: 1 << 20, triangles: 1 << 21 };

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

/** How many levels come before the sides. */
export function interiorLevels({ levels }: Pick<Tile, "levels">): number {
  return levels.length - SIDES;
}

/** Decodes a whole tile; throws a {@link DecodeError} when a length, count, index or coordinate is out of range. */
export function decodeTile(bytes: Uint8Array): Tile {
  const decoder = new TileDecoder(bytes);
  check(decoder.levelsThere === decoder.ends.length, "the levels are cut off");
  check(decoder.ends.at(-1) === bytes.length, "the levels do not fill the tile");
  return decoder.tile();
}

/**
 * Decodes as much of a tile as its first bytes tell, at least its base. A level that is cut has the splits that are whole, and
 * the error of the one before, for which alone it is certified; infinity if it is the first. Levels that are missing add nothing.
 */
export function decodeTilePrefix(bytes: Uint8Array): Tile {
  const decoder = new TileDecoder(bytes);
  check(bytes.length <= decoder.ends.at(-1)!, "the levels do not fill the tile");
  decoder.cut();
  return decoder.tile();
}

/** Decodes a tile while its bytes come in, each level as soon as it is whole. */
export class TileDecoder {
  /** Bytes of the tile up to the end of each level. */
  readonly ends: readonly number[];
  /** The levels as the header tells them, also those that are not there yet. */
  readonly levels: readonly Level[];
  private readonly header: Header;
  /** Until the tile is whole. */
  private decoder: LevelsDecoder | undefined;
  private wholeTile: Tile | undefined;
  /** Those that no level was decoded from yet, and how many there are before them. */
  private waiting: Uint8Array;
  private decoded: number;
  private whole = 0;

  /** Begins with at least the header; if that is cut, throws {@link HeaderCut}. */
  constructor(first: Uint8Array) {
    const { header, entries, start } = readHead(first);
    this.header = header;
    this.levels = entries.map(({ vertexEnd, triangleEnd, error }) => ({ vertexEnd, triangleEnd, error }));
    this.decoder = new LevelsDecoder(header.frame);
    this.decoded = start;
    this.ends = endsOf(entries, start);
    this.waiting = first.subarray(start);
    this.decodeWhole();
  }

  get address(): Address {
    return this.header.address;
  }

  /** Which of the tile's ground was filled, still compressed; undefined where all of it was measured. */
  get filledBytes(): Uint8Array | undefined {
    return this.header.filledBytes;
  }

  /** How many levels are whole. */
  get levelsThere(): number {
    return this.whole;
  }

  /** How many bytes of the tile have come. */
  get bytesThere(): number {
    return this.decoded + this.waiting.length;
  }

  /** Goes on with the bytes that come next. */
  add(bytes: Uint8Array): void {
    const joined = new Uint8Array(this.waiting.length + bytes.length);
    joined.set(this.waiting);
    joined.set(bytes, this.waiting.length);
    this.waiting = joined;
    this.decodeWhole();
  }

  /** Decodes what is there of the level that is not whole, for nothing more will come. */
  cut(): void {
    const isBase = this.whole === 0;
    if (this.whole < this.levels.length && (isBase || this.waiting.length > 0)) this.decode(this.waiting, true);
  }

  /** What has been decoded so far. Levels that are missing add nothing and have the error of the last that is whole. */
  tile(): Tile {
    if (this.wholeTile !== undefined) return this.wholeTile;
    const tile = tileOf(this.header, this.levels, this.whole, this.decoder!.levels());
    if (this.whole < this.levels.length) return tile;
    // What decodes is far larger.
    this.decoder = undefined;
    return (this.wholeTile = tile);
  }

  private decodeWhole(): void {
    while (this.whole < this.ends.length && this.bytesThere >= this.ends[this.whole]!) {
      const length = this.ends[this.whole]! - this.decoded;
      this.decode(this.waiting.subarray(0, length), false);
      this.waiting = this.waiting.subarray(length);
      this.decoded += length;
      this.whole++;
    }
  }

  private decode(bytes: Uint8Array, isCut: boolean): void {
    const run: Run = { ...this.levels[this.whole]!, bytes, isCut };
    this.decoder!.add(run);
  }
}

interface Header {
  readonly address: Address;
  readonly extentBits: number;
  readonly heightStep: number;
  readonly levelCount: number;
  readonly frame: Frame;
  readonly filledBytes: Uint8Array | undefined;
}

function readHead(bytes: Uint8Array): { header: Header; entries: Entry[]; start: number } {
  if (bytes.length < FIXED_BYTES) throw new HeaderCut(`${bytes.length} bytes are too few for a header`);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  check(view.getUint32(0, true) === MAGIC, "the magic is not SPTL");
  const version = view.getUint8(4);
  check(version >= VERSION && version <= VERSION_WITH_FILLED, `version ${version} is not ${VERSION} to ${VERSION_WITH_FILLED}`);
  const numbers = new Numbers(bytes, FIXED_BYTES);
  const header = readHeader(view, numbers);
  return { header, entries: readDirectory(numbers, header.levelCount, LIMITS, true), start: numbers.at };
}

function readHeader(view: DataView, numbers: Numbers): Header {
  const address = { zoom: view.getUint8(5), x: view.getUint32(8, true), y: view.getUint32(12, true) };
  check(address.zoom <= MAX_ZOOM, `zoom ${address.zoom} is above ${MAX_ZOOM}`);
  check(address.x < 2 ** (address.zoom + 1) && address.y < 2 ** address.zoom, "the address is off the Earth");
  const extentBits = view.getUint8(6);
  check(extentBits <= LIMITS.extentBits, `an extent of 2^${extentBits} lattice units`);
  const levelCount = numbers.next();
  check(levelCount > SIDES && levelCount <= LIMITS.levels, `${levelCount} levels`);
  const [lowest, highest] = [view.getInt32(16, true), view.getInt32(20, true)];
  check(lowest <= highest, "the lowest height is above the highest");
  const [version, flags] = [view.getUint8(4), view.getUint8(24)];
  const frame = {
    low: [0, 0, lowest],
    high: [2 ** extentBits, 2 ** extentBits, highest],
    boundaryFrom: levelCount - SIDES,
    baseVertices: numbers.next(),
    baseTriangles: numbers.next(),
    opensHoles: version === VERSION_WITH_HOLES || (version >= VERSION_WITH_BREAKLINES && (flags & OPENS_HOLES) !== 0),
    sampling: (flags & SAMPLED) !== 0 ? readSampling(view, numbers) : undefined,
    isHeightField: true,
  } as const;
  if (version >= VERSION_WITH_BREAKLINES) skipBreaklines(numbers);
  const filledBytes = version === VERSION_WITH_FILLED ? readFilled(view, numbers) : undefined;
  return { address, extentBits, heightStep: 2 ** view.getInt8(7), levelCount, frame, filledBytes };
}

/** Edges along breaklines are for whoever makes the parent of the tile. */
function skipBreaklines(numbers: Numbers): void {
  const count = numbers.next();
  for (let number = 0; number < 4 * count; number++) numbers.signed();
}

function readFilled(view: DataView, numbers: Numbers): Uint8Array {
  const length = numbers.next();
  const from = numbers.at;
  numbers.at += length;
  if (numbers.at > view.byteLength) throw new HeaderCut("the header is cut off");
  return new Uint8Array(view.buffer, view.byteOffset + from, length).slice();
}

/** Levels as far as they were decoded: one that is cut has the error of the one before, those missing the same. */
function levelsOf(levels: readonly Level[], whole: number, decoded: Levels): Level[] {
  const last = {
    vertexEnd: decoded.representatives.length,
    triangleEnd: decoded.corners.length / 3,
    error: levels[whole - 1]?.error ?? Infinity,
  };
  return levels.map((level, index) => (index < whole ? level : last));
}

/** The arrays of a tile; heights become metres. */
function tileOf(header: Header, levels: readonly Level[], whole: number, decoded: Levels): Tile {
  const positions = new Float64Array(decoded.madeAt.length + decoded.restored.length);
  positions.set(decoded.madeAt);
  positions.set(decoded.restored, decoded.madeAt.length);
  for (let at = 2; at < positions.length; at += 3) positions[at]! *= header.heightStep;
  return {
    address: header.address,
    extentBits: header.extentBits,
    levels: levelsOf(levels, whole, decoded),
    positions,
    representatives: decoded.representatives.slice(),
    corners: decoded.corners.slice(),
  };
}
