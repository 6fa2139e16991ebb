// The levels of a tile out of their bytes: a base mesh, then vertex splits; docs/formats/spm.md is the definition.

import { NumberModel } from "./number_model.ts";
import { probabilities, RangeDecoder } from "./range_decoder.ts";
import { SplitDecoder, type Sampling, type Split } from "./split_decoder.ts";
import { Surface, type Point } from "./surface.ts";

const VALENCES = 12;
const MAX_VALENCE = 1024;
const USUAL_DISTANCE = 16384;
const USUAL_GAP = 4;

/** Makes the surface of level 0, any level after it, one in which only vertices of the boundary split. */
const Stage = { Base: 0, Level: 1, Boundary: 2 } as const;
type Stage = (typeof Stage)[keyof typeof Stage];

/** What is known of the levels before their bytes are read. */
export interface Frame {
  readonly low: Point;
  readonly high: Point;
  readonly sampling: Sampling | undefined;
  /** The first of the levels that split vertices of the boundary only. */
  readonly boundaryFrom: number;
  readonly baseVertices: number;
  readonly baseTriangles: number;
  /** Whether any split may open a hole. */
  readonly opensHoles: boolean;
}

/** One level: its bytes as far as they are there, and how many vertices and triangles there are by its end. */
export interface Run {
  readonly bytes: Uint8Array;
  /** Whether there are more bytes, which are not there. */
  readonly isCut: boolean;
  readonly vertexEnd: number;
  readonly triangleEnd: number;
}

/** All levels as one partition; see {@link Tile}. Of a level that is cut it has the splits that are whole. */
export interface Levels {
  readonly madeAt: readonly Point[];
  readonly restored: readonly Point[];
  readonly representatives: readonly number[];
  readonly corners: readonly number[];
}

/** Bytes that make no surface. */
export class LevelError extends Error {
  override readonly name = "LevelError";
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
    if (this.reader === undefined) throw new LevelError("no level");
    return this.reader.levels();
  }
}

function check(condition: boolean, message: string): asserts condition {
  if (!condition) throw new LevelError(message);
}

function isInside({ low, high }: Frame, position: Point): boolean {
  return position.every((coordinate, axis) => coordinate >= low[axis]! && coordinate <= high[axis]!);
}

function readBase(decoder: RangeDecoder, frame: Frame): Surface {
  const [models, gaps] = [[0, 1, 2].map(() => new NumberModel()), new NumberModel()];
  const positions: Point[] = [];
  let previous = frame.low;
  for (let vertex = 0; vertex < frame.baseVertices; vertex++) {
    previous = previous.map((from, axis) => from + models[axis]!.read(decoder, USUAL_DISTANCE, 0)) as unknown as Point;
    check(isInside(frame, previous) && !decoder.isExhausted, `base vertex ${vertex} is out of range`);
    positions.push(previous);
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
    const isTriangle = a !== b && b !== c && c !== a && next <= positions.length;
    check(isTriangle && !decoder.isExhausted, `base triangle ${triangle} is none`);
  }
  return new Surface(positions, corners);
}

class LevelReader {
  private readonly madeAt: Point[];
  private readonly restored: Point[];
  private readonly representatives: number[];
  private readonly splits: SplitDecoder;
  private readonly answers = Array.from({ length: 12 }, () => probabilities(VALENCES));
  private queue: number[] = [];
  private isQueued: boolean[] = [];

  constructor(
    private readonly frame: Frame,
    private readonly surface: Surface,
  ) {
    this.madeAt = [...surface.positions];
    this.restored = [...surface.positions];
    this.representatives = surface.positions.map((_, vertex) => vertex);
    this.splits = new SplitDecoder(frame.sampling, surface.positions, frame.opensHoles);
  }

  levels(): Levels {
    const { madeAt, restored, representatives, surface } = this;
    return { madeAt, restored, representatives, corners: surface.origins };
  }

  read(decoder: RangeDecoder, stage: Stage, { vertexEnd, triangleEnd, isCut }: Run): void {
    check(vertexEnd >= this.madeAt.length, "a level has fewer vertices than its base");
    const count = this.madeAt.length;
    this.queue = this.madeAt.map((_, vertex) => vertex);
    this.isQueued = this.madeAt.map(() => true);
    for (let asked = 0; this.madeAt.length < vertexEnd; asked++) {
      const vertex = this.queue[asked];
      if (!decoder.isExhausted) check(vertex !== undefined, "too few vertices split");
      const isDone = vertex === undefined || !this.ask(decoder, stage, vertex, asked >= count);
      if (isDone && isCut) return;
      check(!isDone, "the bytes of a level end early");
    }
    check(this.surface.origins.length === 3 * triangleEnd, "a level has another number of triangles");
  }

  /** Reads whether a vertex splits, and how; false where the bytes end. */
  private ask(decoder: RangeDecoder, stage: Stage, vertex: number, isAskedAgain: boolean): boolean {
    this.isQueued[vertex] = false;
    if (!this.canSplit(stage, vertex)) return true;
    const context = 4 * stage + 2 * Number(this.surface.isClosed(vertex)) + Number(isAskedAgain);
    const valence = Math.min(this.surface.valence(vertex), VALENCES - 1);
    return !decoder.bit(this.answers[context]![valence]!) || this.split(decoder, stage, vertex);
  }

  private canSplit(stage: Stage, vertex: number): boolean {
    const valence = this.surface.valence(vertex);
    return valence >= 2 && valence <= MAX_VALENCE && (stage !== Stage.Boundary || !this.surface.isClosed(vertex));
  }

  private split(decoder: RangeDecoder, stage: Stage, vertex: number): boolean {
    const ring = this.surface.walk(vertex);
    const split = this.splits.read(decoder, this.surface, vertex, ring, stage === Stage.Base);
    if (decoder.isExhausted) return false;
    check(isInside(this.frame, split.blue) && isInside(this.frame, split.red), "a vertex is outside the tile");
    check(this.surface.split(vertex, ring, split.cuts, split.blue), "a star cannot be cut so");
    this.surface.positions[vertex] = split.red;
    this.note(stage, vertex, split);
    for (const neighbour of [this.madeAt.length - 1, vertex, ...ring.vertices]) {
      if (this.isQueued[neighbour] !== true) this.queue.push(neighbour);
      this.isQueued[neighbour] = true;
    }
    return true;
  }

  private note(stage: Stage, vertex: number, { blue, red }: Split): void {
    this.representatives.push(stage === Stage.Base ? this.madeAt.length : vertex);
    this.madeAt.push(blue);
    this.restored.push(stage === Stage.Base ? blue : red);
  }
}
