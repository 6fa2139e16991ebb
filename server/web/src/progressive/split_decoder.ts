// One vertex split out of bits. All predictions are sums, products, quotients of doubles in the order of docs/formats/spm.md.

import { grown } from "./arrays.ts";
import { NO_SIGN, NumberModel } from "./number_model.ts";
import { probabilities, type RangeDecoder } from "./range_decoder.ts";
import { MOST_NEIGHBOURS, Side, type Cuts, type Point, type Ring, type Surface } from "./surface.ts";

const RANKS = 8;
const LEADS = Float64Array.of(0.25, 0.5, 1, 2, 5, 1e20);
const CLARITIES = LEADS.length + 1;
const NEWS = 0.6;
const OWN = 0.3;
const RED_SHARE = 0.4;
const WRONG_SIDE = 1e30;
const SAME = 0;
const FREE = 4;
const [FITS, FIT_SYMBOLS] = [5, 8];
/** Flags of red, by their places. */
const [MOVES, IS_MIDWAY, ROUNDS_X, ROUNDS_Y] = [0, 1, 2, 3];

/** Columns and rows of the samples along the lattice's axes: where one is, and how far it is to the next. */
export interface Sampling {
  readonly origin: readonly [number, number];
  readonly step: readonly [number, number];
}

/** How a vertex, *red*, splits; one object for all splits. */
export class Split implements Cuts {
  side: Side = Side.Inner;
  first = 0;
  second = 0;
  /** Where red was, and where it is from now on. */
  readonly centre: Point = new Float64Array(3);
  readonly red: Point = new Float64Array(3);
  /** Where the new vertex, *blue*, is. */
  readonly blue: Point = new Float64Array(3);
}

/** Added and taken away again, it leaves the nearest whole number, the even one of two. */
const HALVES_ARE_LOST = 1.5 * 2 ** 52;

const nearest = (number: number): number => number + HALVES_ARE_LOST - HALVES_ARE_LOST;

/** What is known of all splits. */
export interface SplitFrame {
  readonly sampling: Sampling | undefined;
  readonly opensHoles: boolean;
  readonly isHeightField: boolean;
}

/** Axes in the order in which a split is told: two across the surface, then its height. */
type Axes = readonly [number, number, number];
const PLAN: Axes = [0, 1, 2];
/** By the axis of the height: seen from its upper end, and from its lower one. */
const TURNED: readonly (readonly [Axes, Axes])[] = [0, 1, 2].map((height) => {
  const [first, second] = [(height + 1) % 3, (height + 2) % 3];
  return [[first, second, height], [second, first, height]];
});

/** Reads splits, one after the other. */
export class SplitDecoder {
  private readonly sampling: Sampling | undefined;
  private readonly opensHoles: boolean;
  private readonly isHeightField: boolean;
  /** What was read last. */
  readonly split = new Split();
  private readonly sides = probabilities(4);
  private readonly holes = probabilities(2);
  private readonly isHoleSecond = probabilities(1);
  private readonly fits = probabilities(4 * FITS * FIT_SYMBOLS);
  private readonly steps = [new NumberModel(), new NumberModel()] as const;
  private readonly units = [new NumberModel(), new NumberModel()] as const;
  private readonly heights = [new NumberModel(), new NumberModel()] as const;
  private readonly redFlags = probabilities(4);
  private readonly redDistances = new NumberModel();
  private readonly redHeights = [new NumberModel(), new NumberModel()] as const;
  private readonly ranks = probabilities(2 * RANKS * CLARITIES);
  private roughness: Float64Array;
  /** How the first coordinate of each vertex lies to the samples. */
  private firstFits: Uint8Array;
  /** The neighbours of the vertex that splits, less the vertex: three coordinates each. */
  private readonly spokes = new Float64Array(3 * MOST_NEIGHBOURS);
  private readonly misfits = new Float64Array(MOST_NEIGHBOURS);
  /** What is expected of the coordinate that is read next: how far it is, in an array of one, and to which side. */
  private readonly distance = new Float64Array(1);
  private sign = NO_SIGN;

  constructor(
    { sampling, opensHoles, isHeightField }: SplitFrame,
    private readonly surface: Surface,
  ) {
    [this.sampling, this.opensHoles, this.isHeightField] = [sampling, opensHoles, isHeightField];
    this.roughness = new Float64Array(surface.vertexCount);
    this.firstFits = Uint8Array.from({ length: surface.vertexCount }, (_, vertex) => this.fit(0, surface.positions[3 * vertex]!));
  }

  /** Makes room for so many vertices. */
  reserve(vertices: number): void {
    this.roughness = grown(this.roughness, vertices);
    this.firstFits = grown(this.firstFits, vertices);
  }

  /** Reads how a vertex splits, into `split`. */
  read(decoder: RangeDecoder, vertex: number, ring: Ring, isStill: boolean): void {
    const { centre, blue, red } = this.split;
    const made = this.surface.vertexCount;
    for (let axis = 0; axis < 3; axis++) centre[axis] = this.surface.positions[3 * vertex + axis]!;
    this.measureSpokes(ring);
    const axes = this.isHeightField ? PLAN : this.axesOf(ring);
    if (axes !== PLAN) {
      reorder(centre, 0, axes);
      for (let place = 0; place < ring.vertexCount; place++) reorder(this.spokes, 3 * place, axes);
    }
    const side = ring.isClosed ? this.readHole(decoder, isStill) : (decoder.symbol(this.sides, 0, 4) as Side);
    this.split.side = side;
    this.readPlan(decoder, vertex, ring.vertexCount);
    const height = centre[2]! + nearest(this.heightAt(ring, side, blue[0]! - centre[0]!, blue[1]! - centre[1]!));
    const guess = this.expectedDifference(vertex, ring);
    const difference = this.heights[isStill ? 1 : 0].read(decoder, guess, NO_SIGN);
    blue[2] = height + difference;
    const before = this.roughness[vertex]!;
    const roughness = before + (Math.abs(difference) - before) * NEWS;
    this.roughness[vertex] = roughness;
    this.roughness[made] = roughness;
    red.set(centre);
    if (!isStill) this.readRed(decoder, roughness * RED_SHARE + Math.abs(difference) * RED_SHARE, difference);
    if (red[0] !== centre[0]) this.firstFits[vertex] = this.fit(0, red[0]!);
    this.readCuts(decoder, ring);
    if (axes !== PLAN) for (const point of [blue, red]) restore(point, axes);
  }

  /** The axis last along which the star is seen from its front with the largest area. */
  private axesOf({ vertexCount, isClosed }: Ring): Axes {
    const { spokes } = this;
    let [x, y, z] = [0, 0, 0];
    for (let place = 0; place < (isClosed ? vertexCount : vertexCount - 1); place++) {
      const [a, b] = [3 * place, 3 * ((place + 1) % vertexCount)];
      x += spokes[a + 1]! * spokes[b + 2]! - spokes[b + 1]! * spokes[a + 2]!;
      y += spokes[a + 2]! * spokes[b]! - spokes[b + 2]! * spokes[a]!;
      z += spokes[a]! * spokes[b + 1]! - spokes[b]! * spokes[a + 1]!;
    }
    const sizes = [Math.abs(x), Math.abs(y), Math.abs(z)] as const;
    const height = sizes[2] >= sizes[0] && sizes[2] >= sizes[1] ? 2 : sizes[1] >= sizes[0] ? 1 : 0;
    return TURNED[height]![[x, y, z][height]! >= 0 ? 0 : 1];
  }

  private measureSpokes(ring: Ring): void {
    const { spokes } = this;
    const { positions } = this.surface;
    const { centre } = this.split;
    const count = ring.vertexCount;
    for (let place = 0; place < count; place++) {
      const neighbour = 3 * ring.vertices[place]!;
      spokes[3 * place] = positions[neighbour]! - centre[0]!;
      spokes[3 * place + 1] = positions[neighbour + 1]! - centre[1]!;
      spokes[3 * place + 2] = positions[neighbour + 2]! - centre[2]!;
    }
  }

  /** Reads whether a closed star opens into a hole, and at which cut. */
  private readHole(decoder: RangeDecoder, isStill: boolean): Side {
    if (!this.opensHoles || decoder.bit(this.holes, isStill ? 1 : 0) === 0) return Side.Inner;
    return decoder.bit(this.isHoleSecond, 0) === 1 ? Side.HoleSecond : Side.HoleFirst;
  }

  /** Reads the place in plan of the new vertex, where there are so many spokes. */
  private readPlan(decoder: RangeDecoder, vertex: number, count: number): void {
    const { side, centre, blue } = this.split;
    const kind = side === Side.Front || side === Side.Back ? 2 : 0;
    const from = side === Side.Back ? count - 1 : 0;
    const to = side === Side.Front ? 1 : count;
    const before = this.firstFits[vertex]!;
    const fit = this.readFit(decoder, kind, before);
    blue[0] = this.readCoordinate(decoder, 0, fit, from, to, 0);
    this.firstFits[this.surface.vertexCount] = fit === SAME ? before : fit;
    const fitOfY = this.readFit(decoder, kind + 1, fit);
    blue[1] = this.readCoordinate(decoder, 1, fitOfY, from, to, blue[0] - centre[0]!);
  }

  private readFit(decoder: RangeDecoder, kind: number, before: number): number {
    return Math.min(decoder.symbol(this.fits, (kind * FITS + before) * FIT_SYMBOLS, FIT_SYMBOLS), FREE);
  }

  private readCoordinate(decoder: RangeDecoder, axis: 0 | 1, fit: number, from: number, to: number, ahead: number): number {
    const centre = this.split.centre[axis]!;
    if (fit === SAME) return centre;
    this.expect(axis, from, to, ahead);
    const distance = this.distance[0]!;
    if (fit === FREE || this.sampling === undefined) return centre + this.units[axis].read(decoder, distance, this.sign);
    const parts = 1 << (fit - 1);
    const guess = distance * (1 / this.sampling.step[axis]) * parts;
    const steps = this.steps[axis].read(decoder, guess, this.sign);
    return coordinateOf(this.sampling, axis, parts, indexOf(this.sampling, axis, parts, centre) + steps);
  }

  /**
   * How far spokes from one place to another are along an axis on the average, and to which side they lean, in eighths; only of those
   * that are ahead along the first axis, if there are any.
   */
  private expect(axis: 0 | 1, from: number, to: number, ahead: number): void {
    const { spokes } = this;
    let sum = 0;
    let size = 0;
    let count = 0;
    for (let place = from; place < to; place++) {
      if (ahead !== 0 && !(spokes[3 * place]! * ahead > 0)) continue;
      const along = spokes[3 * place + axis]!;
      sum += along;
      size += Math.abs(along);
      count++;
    }
    if (count === 0 && ahead !== 0) return this.expect(axis, from, to, 0);
    this.distance[0] = size / count;
    this.sign = Math.floor(((size > 0 ? sum / size : 0) + 1) * 4 + 0.5);
  }

  /** How a coordinate lies to the samples: on one, at a half or a quarter between two, or free. */
  private fit(axis: 0 | 1, coordinate: number): number {
    const { sampling } = this;
    if (sampling === undefined) return FREE;
    for (let halvings = 0; halvings < 3; halvings++) {
      const parts = 1 << halvings;
      if (coordinateOf(sampling, axis, parts, indexOf(sampling, axis, parts, coordinate)) === coordinate) return halvings + 1;
    }
    return FREE;
  }

  private expectedDifference(vertex: number, ring: Ring): number {
    let sum = 0;
    for (let place = 0; place < ring.vertexCount; place++) sum += this.roughness[ring.vertices[place]!]!;
    return this.roughness[vertex]! * OWN + (sum / ring.vertexCount) * (1 - OWN);
  }

  /** Height of the star's triangles at a place, all against the centre's. */
  private heightAt(ring: Ring, side: Side, x: number, y: number): number {
    const { spokes } = this;
    if (side === Side.Front || side === Side.Back) {
      const at = side === Side.Front ? 0 : 3 * (ring.vertexCount - 1);
      const alongX = spokes[at]!;
      const alongY = spokes[at + 1]!;
      const length = alongX * alongX + alongY * alongY;
      return length > 0 ? ((alongX * x + alongY * y) / length) * spokes[at + 2]! : 0;
    }
    // Stars in space may have several triangles over a place: of a closed walk, the one that closes it comes first.
    let a = ring.isClosed ? 3 * (ring.vertexCount - 1) : 0;
    for (let b = ring.isClosed ? 0 : 3; b < 3 * ring.vertexCount; a = b, b += 3) {
      const fromA = spokes[a]! * y - spokes[a + 1]! * x;
      if (!(fromA >= 0)) continue;
      const toB = x * spokes[b + 1]! - y * spokes[b]!;
      const area = spokes[a]! * spokes[b + 1]! - spokes[a + 1]! * spokes[b]!;
      if (toB > 0 && area > 0) return (toB * spokes[a + 2]! + fromA * spokes[b + 2]!) / area;
    }
    return 0;
  }

  private readRed(decoder: RangeDecoder, change: number, difference: number): void {
    const { centre, blue, red } = this.split;
    const hasMoved = decoder.bit(this.redFlags, MOVES) === 1;
    if (hasMoved && decoder.bit(this.redFlags, IS_MIDWAY) === 1) {
      red[0] = 2 * centre[0]! - blue[0]! - decoder.bit(this.redFlags, ROUNDS_X);
      red[1] = 2 * centre[1]! - blue[1]! - decoder.bit(this.redFlags, ROUNDS_Y);
      red[2] = 2 * centre[2]! - blue[2]!;
    } else if (hasMoved) {
      red[0]! += this.redDistances.read(decoder, Math.abs(blue[0]! - centre[0]!), NO_SIGN);
      red[1]! += this.redDistances.read(decoder, Math.abs(blue[1]! - centre[1]!), NO_SIGN);
    }
    const sign = difference < 0 ? 1 : difference > 0 ? 2 : NO_SIGN;
    red[2]! += this.redHeights[hasMoved ? 1 : 0].read(decoder, change, sign);
  }

  private readCuts(decoder: RangeDecoder, ring: Ring): void {
    const { split } = this;
    const { side } = split;
    const outer = side === Side.Outer ? split.blue : split.red;
    const inner = side === Side.Outer ? split.red : split.blue;
    const count = ring.vertexCount;
    split.first = 0;
    split.second = 0;
    if (side !== Side.Front) {
      // Seen from the other side, the first cut is ranked as the second one is.
      this.rank(inner, outer, 0, count);
      split.first = this.readCut(decoder, 0, 0, count);
    }
    if (side === Side.Back) return;
    const from = side === Side.Front || ring.isClosed ? 0 : split.first + 1;
    this.rank(outer, inner, from, count);
    if (ring.isClosed) this.misfits[split.first] = NaN;
    split.second = this.readCut(decoder, 1, from, count);
  }

  /** How badly each place of a star suits a cut: the cotangent of the angle under which it sees the new edge, from its right end to its left one. */
  private rank(right: Point, left: Point, from: number, to: number): void {
    const { spokes, misfits } = this;
    const { centre } = this.split;
    const rightX = right[0]! - centre[0]!;
    const rightY = right[1]! - centre[1]!;
    const leftX = left[0]! - centre[0]!;
    const leftY = left[1]! - centre[1]!;
    for (let place = from; place < to; place++) {
      const toRightX = rightX - spokes[3 * place]!;
      const toRightY = rightY - spokes[3 * place + 1]!;
      const toLeftX = leftX - spokes[3 * place]!;
      const toLeftY = leftY - spokes[3 * place + 1]!;
      const area = toRightX * toLeftY - toRightY * toLeftX;
      const dot = toRightX * toLeftX + toRightY * toLeftY;
      misfits[place] = area > 0 ? dot / area : WRONG_SIDE + Math.abs(dot);
    }
  }

  /** Reads which of the places from one to another it is, the best first; those without a misfit are none. */
  private readCut(decoder: RangeDecoder, which: number, from: number, to: number): number {
    const { misfits } = this;
    let best = bestOf(misfits, from, to);
    for (let rank = 0; ; rank++) {
      if (best < 0) return 0;
      const misfit = misfits[best]!;
      misfits[best] = NaN;
      const next = bestOf(misfits, from, to);
      if (next < 0) return best;
      const lead = misfits[next]! - misfit;
      let clarity = 0;
      while (clarity < LEADS.length && lead > LEADS[clarity]!) clarity++;
      if (decoder.bit(this.ranks, (which * RANKS + Math.min(rank, RANKS - 1)) * CLARITIES + clarity) === 1) return best;
      best = next;
    }
  }
}

/** Puts three coordinates in the order of axes. */
function reorder(points: Float64Array, at: number, axes: Axes): void {
  const [x, y, z] = [points[at + axes[0]]!, points[at + axes[1]]!, points[at + axes[2]]!];
  points[at] = x;
  points[at + 1] = y;
  points[at + 2] = z;
}

/** And back. */
function restore(point: Point, axes: Axes): void {
  const [x, y, z] = [point[0]!, point[1]!, point[2]!];
  point[axes[0]] = x;
  point[axes[1]] = y;
  point[axes[2]] = z;
}

/** The place of the least number, the first of equal ones; -1 if there is none. */
function bestOf(numbers: Float64Array, from: number, to: number): number {
  let best = -1;
  let least = Infinity;
  for (let place = from; place < to; place++) {
    const number = numbers[place]!;
    if (!(number < least)) continue;
    best = place;
    least = number;
  }
  return best;
}

function indexOf({ origin, step }: Sampling, axis: 0 | 1, parts: number, coordinate: number): number {
  return nearest((coordinate - origin[axis]) * (1 / step[axis]) * parts);
}

function coordinateOf({ origin, step }: Sampling, axis: 0 | 1, parts: number, index: number): number {
  return nearest(origin[axis] + step[axis] * (index / parts));
}
