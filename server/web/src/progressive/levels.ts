// The levels of a tile or a model out of their bytes: a base mesh, then vertex splits; docs/formats/spm.md is the definition.

import { grown } from "./arrays.ts";
import { check, DecodeError } from "./decode_error.ts";
import { NumberModel } from "./number_model.ts";
import { probabilities, RangeDecoder } from "./range_decoder.ts";
import { SplitDecoder, type Sampling } from "./split_decoder.ts";
import { MOST_NEIGHBOURS, Ring, setPoint, Surface, type Point } from "./surface.ts";

const VALENCES = 12;
const USUAL_DISTANCE = 16384;
const USUAL_GAP = 4;
/** Vertices that there is room for once there are more than those of the base. */
const LEAST_GROWN = 1024;

/** Makes the surface of level 0, any level after it, one in which only vertices of the boundary split. */
const Stage = { Base: 0, Level: 1, Boundary: 2 } as const;
type Stage = (typeof Stage)[keyof typeof Stage];

/** What is known of the levels before their bytes are read. */
export interface Frame {
  /** Lowest and highest coordinates. */
  readonly low: readonly [number, number, number];
  readonly high: readonly [number, number, number];
  readonly sampling: Sampling | undefined;
  /** The first of the levels that split vertices of the boundary only. */
  readonly boundaryFrom: number;
  readonly baseVertices: number;
  readonly baseTriangles: number;
  /** Whether any split may open a hole. */
  readonly opensHoles: boolean;
  /** Whether the third coordinate is a height over the others. */
  readonly isHeightField: boolean;
}

/** One level: its bytes as far as they are there, and how many vertices and triangles there are by its end. */
export interface Run {
  readonly bytes: Uint8Array;
  /** Whether there are more bytes, which are not there. */
  readonly isCut: boolean;
  readonly vertexEnd: number;
  readonly triangleEnd: number;
}

/** All levels as one partition, in arrays that decoding goes on in; see {@link Tile}. Of a level that is cut it has the splits that are whole. */
export interface Levels {
  /** Three coordinates a vertex: where it was made. */
  readonly madeAt: Float64Array;
  /** And where its representative goes when it comes in. */
  readonly restored: Float64Array;
  readonly representatives: Uint32Array;
  readonly corners: Uint32Array;
}

/** Decodes one level after the other. */
export class LevelsDecoder {
  private reader: LevelReader | undefined;
  private count = 0;

  constructor(private readonly frame: Frame) {}

  /** Decodes the next level. Behind one that is cut there is none. */
  add(run: Run): void {
    const { frame } = this;
    const decoder = new RangeDecoder(run.bytes, run.isCut);
    check(frame.baseVertices <= run.vertexEnd && frame.baseTriangles <= run.triangleEnd, "a base of more than level 0");
    this.reader ??= new LevelReader(frame, readBase(decoder, frame));
    const stage = this.count === 0 ? Stage.Base : this.count >= frame.boundaryFrom ? Stage.Boundary : Stage.Level;
    this.reader.read(decoder, stage, run);
    this.count++;
  }

  /** What has been decoded so far. It changes with the next level. */
  levels(): Levels {
    if (this.reader === undefined) throw new DecodeError("no level");
    return this.reader.levels();
  }
}

function isInside({ low, high }: Frame, point: Point): boolean {
  return isBetween(point[0]!, low[0], high[0]) && isBetween(point[1]!, low[1], high[1]) && isBetween(point[2]!, low[2], high[2]);
}

function isBetween(number: number, low: number, high: number): boolean {
  return number >= low && number <= high;
}

function readBase(decoder: RangeDecoder, frame: Frame): Surface {
  const [models, gaps] = [[0, 1, 2].map(() => new NumberModel()), new NumberModel()];
  const positions: number[] = [];
  const position = Float64Array.from(frame.low);
  for (let vertex = 0; vertex < frame.baseVertices; vertex++) {
    models.forEach((model, axis) => (position[axis]! += model.read(decoder, USUAL_DISTANCE, 0)));
    check(isInside(frame, position) && !decoder.isExhausted, `base vertex ${vertex} is out of range`);
    positions.push(...position);
  }
  const corners: number[] = [];
  let next = 0;
  for (let triangle = 0; triangle < frame.baseTriangles; triangle++) {
    for (let corner = 0; corner < 3; corner++) {
      const back = gaps.read(decoder, USUAL_GAP, 0);
      check(back >= 0 && back <= next, `base triangle ${triangle} has a corner out of range`);
      corners.push(next - back);
      if (back === 0) next++;
    }
    const [a, b, c] = corners.slice(-3);
    const isTriangle = a !== b && b !== c && c !== a && next <= frame.baseVertices;
    check(isTriangle && !decoder.isExhausted, `base triangle ${triangle} is none`);
  }
  return new Surface(positions, corners);
}

class LevelReader {
  private capacity: number;
  private madeAt: Float64Array;
  private restored: Float64Array;
  private representatives: Uint32Array;
  private readonly splits: SplitDecoder;
  private readonly answers = probabilities(12 * VALENCES);
  private readonly ring = new Ring();
  /** Vertices to be asked, and how many of them there are. */
  private queue: Uint32Array;
  private queued = 0;
  private isQueued: Uint8Array;

  constructor(
    private readonly frame: Frame,
    private readonly surface: Surface,
  ) {
    this.capacity = surface.vertexCount;
    this.madeAt = surface.positions.slice();
    this.restored = surface.positions.slice();
    this.representatives = Uint32Array.from({ length: this.capacity }, (_, vertex) => vertex);
    this.queue = new Uint32Array(this.capacity);
    this.isQueued = new Uint8Array(this.capacity);
    this.splits = new SplitDecoder(frame, surface);
  }

  levels(): Levels {
    const { vertexCount, edgeCount, origins } = this.surface;
    return {
      madeAt: this.madeAt.subarray(0, 3 * vertexCount),
      restored: this.restored.subarray(0, 3 * vertexCount),
      representatives: this.representatives.subarray(0, vertexCount),
      corners: origins.subarray(0, edgeCount),
    };
  }

  read(decoder: RangeDecoder, stage: Stage, { vertexEnd, triangleEnd, isCut }: Run): void {
    const count = this.surface.vertexCount;
    check(vertexEnd >= count, "a level has fewer vertices than its base");
    for (let vertex = 0; vertex < count; vertex++) this.queue[vertex] = vertex;
    this.queued = count;
    this.isQueued.fill(1, 0, count);
    for (let asked = 0; this.surface.vertexCount < vertexEnd; asked++) {
      const isEmpty = asked === this.queued;
      if (!decoder.isExhausted) check(!isEmpty, "too few vertices split");
      const isDone = isEmpty || !this.ask(decoder, stage, this.queue[asked]!, asked >= count);
      if (isDone && isCut) return;
      check(!isDone, "the bytes of a level end early");
    }
    check(this.surface.edgeCount === 3 * triangleEnd, "a level has another number of triangles");
  }

  /** Reads whether a vertex splits, and how; false where the bytes end. */
  private ask(decoder: RangeDecoder, stage: Stage, vertex: number, isAskedAgain: boolean): boolean {
    this.isQueued[vertex] = 0;
    const valence = this.surface.valences[vertex]!;
    const isClosed = this.surface.closed[vertex]!;
    if (valence < 2 || valence > MOST_NEIGHBOURS || (stage === Stage.Boundary && isClosed === 1)) return true;
    const context = 4 * stage + 2 * isClosed + Number(isAskedAgain);
    const answer = decoder.bit(this.answers, context * VALENCES + Math.min(valence, VALENCES - 1));
    return answer === 0 || this.split(decoder, stage, vertex);
  }

  private split(decoder: RangeDecoder, stage: Stage, vertex: number): boolean {
    const { surface, ring } = this;
    const blue = surface.vertexCount;
    if (blue === this.capacity) this.reserve(Math.max(2 * blue, LEAST_GROWN));
    surface.walk(vertex, ring);
    this.splits.read(decoder, vertex, ring, stage === Stage.Base);
    const { split } = this.splits;
    if (decoder.isExhausted) return false;
    check(isInside(this.frame, split.blue) && isInside(this.frame, split.red), "a vertex is outside the bounds");
    check(surface.split(vertex, ring, split, split.blue), "a star cannot be cut so");
    setPoint(surface.positions, vertex, split.red);
    this.representatives[blue] = stage === Stage.Base ? blue : vertex;
    setPoint(this.madeAt, blue, split.blue);
    setPoint(this.restored, blue, stage === Stage.Base ? split.blue : split.red);
    this.enqueue(blue);
    this.enqueue(vertex);
    for (let place = 0; place < ring.vertexCount; place++) this.enqueue(ring.vertices[place]!);
    return true;
  }

  private enqueue(vertex: number): void {
    if (this.isQueued[vertex] === 1) return;
    if (this.queued === this.queue.length) this.queue = grown(this.queue, 2 * this.queued);
    this.queue[this.queued++] = vertex;
    this.isQueued[vertex] = 1;
  }

  /** Makes room for so many vertices. */
  private reserve(vertices: number): void {
    this.capacity = vertices;
    this.madeAt = grown(this.madeAt, 3 * vertices);
    this.restored = grown(this.restored, 3 * vertices);
    this.representatives = grown(this.representatives, vertices);
    this.queue = grown(this.queue, vertices);
    this.isQueued = grown(this.isQueued, vertices);
    this.surface.reserve(vertices);
    this.splits.reserve(vertices);
  }
}
