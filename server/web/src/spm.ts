// Decoder of the progressive mesh; docs/formats/spm.md is the definition.

import { check, DecodeError } from "./progressive/decode_error.ts";
import { Numbers, readDirectory, readSampling, type Entry, type Level, type LevelLimits } from "./progressive/fields.ts";
import { LevelsDecoder, type Frame } from "./progressive/levels.ts";

/** Bytes of the header before the numbers of any length. */
const FIXED_BYTES = 54;
const MAGIC = 0x464d5053; // "SPMF", little-endian
/** Of a mesh in which no split opens a hole, and of one in which some may. */
const [VERSION, VERSION_WITH_HOLES] = [1, 2];
const [HEIGHT_FIELD, SAMPLED] = [1, 2];

/** What a model may ask of the browser: half a gigabyte or so. */
const LIMITS: LevelLimits = { levels: 1024, vertices: 1 << 22, triangles: 1 << 23 };

/** A mesh with its levels of detail, coarsest first. */
export interface ProgressiveMesh {
  /** Errors are distances, both ways, in the units of the mesh. */
  readonly levels: readonly Level[];
  /** x, y, z for n vertices as stored, then n times where each vertex's representative goes when the vertex comes in. */
  readonly positions: Float64Array;
  /** Vertex that each one is drawn at until its level comes in; itself in level 0. */
  readonly representatives: Uint32Array;
  /** Three corners a triangle, in the numbering of the finest level. */
  readonly corners: Uint32Array;
}

/** Decodes a whole file; throws a {@link DecodeError} when a length, count, index or coordinate is out of range, or a limit is exceeded. */
export function decodeModel(bytes: Uint8Array, limits: LevelLimits = LIMITS): ProgressiveMesh {
  const { frame, origin, step, entries, start } = readHead(bytes, limits);
  const decoder = new LevelsDecoder(frame);
  let at = start;
  for (const entry of entries) {
    const run = bytes.subarray(at, (at += entry.length));
    check(at <= bytes.length, "the levels are cut off");
    decoder.add({ ...entry, bytes: run, isCut: false });
  }
  check(at === bytes.length, "the levels do not fill the file");
  const { madeAt, restored, representatives, corners } = decoder.levels();
  const positions = new Float64Array(madeAt.length + restored.length);
  positions.set(madeAt);
  positions.set(restored, madeAt.length);
  for (let place = 0; place < positions.length; place++) positions[place] = origin[place % 3]! + positions[place]! * step[place % 3]!;
  const levels = entries.map(({ vertexEnd, triangleEnd, error }) => ({ vertexEnd, triangleEnd, error }));
  return { levels, positions, representatives: representatives.slice(), corners: corners.slice() };
}

interface Head {
  readonly frame: Frame;
  readonly origin: readonly number[];
  readonly step: readonly number[];
  readonly entries: readonly Entry[];
  /** Where the levels begin. */
  readonly start: number;
}

function readHead(bytes: Uint8Array, limits: LevelLimits): Head {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  check(bytes.length >= 4 && view.getUint32(0, true) === MAGIC, "it is no progressive mesh (.spm)");
  if (bytes.length < FIXED_BYTES) throw new DecodeError(`${bytes.length} bytes are too few for a header`);
  const [version, flags] = [view.getUint8(4), view.getUint8(5)];
  check(version === VERSION || version === VERSION_WITH_HOLES, `version ${version} is not ${VERSION} or ${VERSION_WITH_HOLES}`);
  const [origin, step] = [6, 30].map((at) => [0, 8, 16].map((offset) => view.getFloat64(at + offset, true))) as [number[], number[]];
  check(origin.every(Number.isFinite) && step.every((size) => Number.isFinite(size) && size > 0), "the lattice is out of range");
  const numbers = new Numbers(bytes, FIXED_BYTES);
  const levelCount = numbers.next();
  check(levelCount > 0 && levelCount <= limits.levels, `${levelCount} levels`);
  const [baseVertices, baseTriangles] = [numbers.next(), numbers.next()];
  const high = [numbers.next(), numbers.next(), numbers.next()] as const;
  const frame = {
    low: [0, 0, 0],
    high,
    boundaryFrom: levelCount,
    baseVertices,
    baseTriangles,
    opensHoles: version === VERSION_WITH_HOLES,
    sampling: (flags & SAMPLED) !== 0 ? readSampling(view, numbers) : undefined,
    isHeightField: (flags & HEIGHT_FIELD) !== 0,
  } as const;
  const entries = readDirectory(numbers, levelCount, limits, false);
  return { frame, origin, step, entries, start: numbers.at };
}
