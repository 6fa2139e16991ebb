// One vertex split out of bits. All predictions are sums, products, quotients of doubles in the order of docs/formats/spm.md.

import { NO_SIGN, NumberModel } from "./number_model.ts";
import { probabilities, type Probability, type RangeDecoder } from "./range_decoder.ts";
import { Side, type Cuts, type Point, type Ring, type Surface } from "./surface.ts";

const RANKS = 8;
const LEADS = [0.25, 0.5, 1, 2, 5, 1e20];
const NEWS = 0.6;
const OWN = 0.3;
const RED_SHARE = 0.4;
const WRONG_SIDE = 1e30;
const SAME = 0;
const FREE = 4;

/** Columns and rows of the samples along the lattice's axes: where one is, and how far it is to the next. */
export interface Sampling {
  readonly origin: readonly [number, number];
  readonly step: readonly [number, number];
}

export interface Split {
  readonly cuts: Cuts;
  /** Where the new vertex is. */
  readonly blue: Point;
  /** Where the other one is from now on. */
  readonly red: Point;
}

interface Expected {
  readonly distance: number;
  readonly sign: number;
}

/** Added and taken away again, it leaves the nearest whole number, the even one of two. */
const HALVES_ARE_LOST = 1.5 * 2 ** 52;

const nearest = (number: number): number => number + HALVES_ARE_LOST - HALVES_ARE_LOST;
const trees = (...counts: number[]): Probability[][] => counts.map(probabilities);
const cross = (a: Point, b: Point): number => a[0] * b[1] - a[1] * b[0];
const minus = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

/** Reads the splits of height fields, one after the other. */
export class SplitDecoder {
  private readonly sides = probabilities(4);
  private readonly holes = probabilities(2);
  private readonly isHoleSecond = probabilities(1);
  private readonly fits = Array.from({ length: 4 }, () => trees(8, 8, 8, 8, 8));
  private readonly steps = [new NumberModel(), new NumberModel()] as const;
  private readonly units = [new NumberModel(), new NumberModel()] as const;
  private readonly heights = [new NumberModel(), new NumberModel()] as const;
  private readonly redFlags = probabilities(4);
  private readonly redDistances = new NumberModel();
  private readonly redHeights = [new NumberModel(), new NumberModel()] as const;
  private readonly ranks = [0, 1].map(() => Array.from({ length: RANKS }, () => probabilities(LEADS.length + 1)));
  private readonly roughness: number[];
  /** How the first coordinate of each vertex lies to the samples. */
  private readonly firstFits: number[];

  constructor(
    private readonly sampling: Sampling | undefined,
    base: readonly Point[],
    private readonly opensHoles: boolean,
  ) {
    this.roughness = base.map(() => 0);
    this.firstFits = base.map(([x]) => this.fit(0, x));
  }

  read(decoder: RangeDecoder, surface: Surface, vertex: number, ring: Ring, isStill: boolean): Split {
    const centre = surface.positions[vertex]!;
    const spokes = ring.vertices.map((neighbour) => minus(surface.positions[neighbour]!, centre));
    const side = ring.isClosed ? this.readHole(decoder, isStill) : (decoder.symbol(this.sides) as Side);
    const toward = side === Side.Front ? spokes.slice(0, 1) : side === Side.Back ? spokes.slice(-1) : spokes;
    const [x, y, fit] = this.readPlan(decoder, side, centre, this.firstFits[vertex]!, toward);
    this.firstFits.push(fit);
    const place: Point = [x - centre[0], y - centre[1], 0];
    const height = centre[2] + nearest(heightAt(spokes, toward, side, ring.isClosed, place));
    const guess = this.expectedDifference(vertex, ring);
    const difference = this.heights[isStill ? 1 : 0].read(decoder, guess, NO_SIGN);
    const blue: Point = [x, y, height + difference];
    const before = this.roughness[vertex]!;
    const roughness = before + (Math.abs(difference) - before) * NEWS;
    this.roughness[vertex] = roughness;
    this.roughness.push(roughness);
    const change = roughness * RED_SHARE + Math.abs(difference) * RED_SHARE;
    const red = isStill ? centre : this.readRed(decoder, centre, blue, change, difference);
    if (red[0] !== centre[0]) this.firstFits[vertex] = this.fit(0, red[0]);
    const ends = [minus(red, centre), minus(blue, centre)] as const;
    const cuts = this.readCuts(decoder, spokes, ring.isClosed, side, side === Side.Outer ? [ends[1], ends[0]] : ends);
    return { cuts, blue, red };
  }

  /** Reads whether a closed star opens into a hole, and at which cut. */
  private readHole(decoder: RangeDecoder, isStill: boolean): Side {
    if (!this.opensHoles || !decoder.bit(this.holes[isStill ? 1 : 0]!)) return Side.Inner;
    return decoder.bit(this.isHoleSecond[0]!) ? Side.HoleSecond : Side.HoleFirst;
  }

  /** Reads the place in plan, and how its first coordinate lies to the samples. */
  private readPlan(
    decoder: RangeDecoder, side: Side, centre: Point, before: number, toward: readonly Point[],
  ): [number, number, number] {
    const along = side === Side.Front || side === Side.Back ? 2 : 0;
    const [x, fit] = this.readCoordinate(decoder, 0, along, before, centre[0], expected(toward.map((spoke) => spoke[0])));
    const ahead = x - centre[0];
    const onThatSide = toward.filter((spoke) => spoke[0] * ahead > 0);
    const hints = (onThatSide.length > 0 ? onThatSide : toward).map((spoke) => spoke[1]);
    const [y] = this.readCoordinate(decoder, 1, along, fit, centre[1], expected(hints));
    return [x, y, fit === SAME ? before : fit];
  }

  private readCoordinate(
    decoder: RangeDecoder, axis: 0 | 1, along: number, before: number, from: number, { distance, sign }: Expected,
  ): [number, number] {
    const fit = Math.min(decoder.symbol(this.fits[along + axis]![before]!), FREE);
    if (fit === SAME) return [from, fit];
    if (fit === FREE || this.sampling === undefined) return [from + this.units[axis].read(decoder, distance, sign), fit];
    const parts = 2 ** (fit - 1);
    const guess = distance * (1 / this.sampling.step[axis]) * parts;
    const steps = this.steps[axis].read(decoder, guess, sign);
    return [this.coordinate(this.sampling, axis, parts, this.index(this.sampling, axis, parts, from) + steps), fit];
  }

  /** How a coordinate lies to the samples: on one, at a half or a quarter between two, or free. */
  private fit(axis: 0 | 1, coordinate: number): number {
    const { sampling } = this;
    if (sampling === undefined) return FREE;
    const liesOn = (parts: number) =>
      this.coordinate(sampling, axis, parts, this.index(sampling, axis, parts, coordinate)) === coordinate;
    const halvings = [1, 2, 4].findIndex(liesOn);
    return halvings < 0 ? FREE : halvings + 1;
  }

  private index({ origin, step }: Sampling, axis: 0 | 1, parts: number, coordinate: number): number {
    return nearest((coordinate - origin[axis]) * (1 / step[axis]) * parts);
  }

  private coordinate({ origin, step }: Sampling, axis: 0 | 1, parts: number, index: number): number {
    return nearest(origin[axis] + step[axis] * (index / parts));
  }

  private expectedDifference(vertex: number, ring: Ring): number {
    let sum = 0;
    for (const neighbour of ring.vertices) sum += this.roughness[neighbour]!;
    return this.roughness[vertex]! * OWN + (sum / ring.vertices.length) * (1 - OWN);
  }

  private readRed(decoder: RangeDecoder, centre: Point, blue: Point, change: number, difference: number): Point {
    const [moves, isMidway, roundsX, roundsY] = this.redFlags as [Probability, Probability, Probability, Probability];
    let [x, y, z] = centre;
    const hasMoved = decoder.bit(moves);
    if (hasMoved && decoder.bit(isMidway)) {
      x = 2 * centre[0] - blue[0] - Number(decoder.bit(roundsX));
      y = 2 * centre[1] - blue[1] - Number(decoder.bit(roundsY));
      z = 2 * centre[2] - blue[2];
    } else if (hasMoved) {
      x += this.redDistances.read(decoder, Math.abs(blue[0] - centre[0]), NO_SIGN);
      y += this.redDistances.read(decoder, Math.abs(blue[1] - centre[1]), NO_SIGN);
    }
    const sign = difference < 0 ? 1 : difference > 0 ? 2 : NO_SIGN;
    return [x, y, z + this.redHeights[hasMoved ? 1 : 0].read(decoder, change, sign)];
  }

  private readCuts(
    decoder: RangeDecoder, spokes: readonly Point[], isClosed: boolean, side: Side, edge: readonly [Point, Point],
  ): Cuts {
    const places = spokes.map((_, place) => place);
    const first = side === Side.Front ? 0 : this.readCut(decoder, 0, rank(spokes, edge, places, false));
    if (side === Side.Back) return { side, first, second: 0 };
    const isLeft = (place: number) => side === Side.Front || (isClosed ? place !== first : place > first);
    const second = this.readCut(decoder, 1, rank(spokes, edge, places.filter(isLeft), true));
    return { side, first, second };
  }

  private readCut(decoder: RangeDecoder, which: number, ranked: readonly { misfit: number; place: number }[]): number {
    for (let rank = 0; rank + 1 < ranked.length; rank++) {
      const lead = ranked[rank + 1]!.misfit - ranked[rank]!.misfit;
      const clarity = LEADS.filter((least) => lead > least).length;
      if (decoder.bit(this.ranks[which]![Math.min(rank, RANKS - 1)]![clarity]!)) return ranked[rank]!.place;
    }
    return ranked[ranked.length - 1]?.place ?? 0;
  }
}

/** How far differences are on the average, and to which side they lean, in eighths. */
function expected(differences: readonly number[]): Expected {
  let [sum, distance] = [0, 0];
  for (const difference of differences) {
    sum += difference;
    distance += Math.abs(difference);
  }
  const lean = distance > 0 ? sum / distance : 0;
  return { distance: distance / differences.length, sign: Math.floor((lean + 1) * 4 + 0.5) };
}

/** Height of the star's triangles at a place, against the centre's. */
function heightAt(spokes: readonly Point[], toward: readonly Point[], side: Side, isClosed: boolean, place: Point): number {
  if (side === Side.Front || side === Side.Back) {
    const along = toward[0]!;
    const length = along[0] * along[0] + along[1] * along[1];
    return length > 0 ? ((along[0] * place[0] + along[1] * place[1]) / length) * along[2] : 0;
  }
  const last = spokes.length - 1;
  for (let index = 0; index < spokes.length; index++) {
    if (index === last && !isClosed) break;
    const [a, b] = [spokes[index]!, spokes[index === last ? 0 : index + 1]!];
    const [fromA, toB, area] = [cross(a, place), cross(place, b), cross(a, b)];
    if (fromA >= 0 && toB > 0 && area > 0) return (toB * a[2] + fromA * b[2]) / area;
  }
  return 0;
}

/** The places at which a star may be cut, the best first: by the cotangent of the angle under which they see the new edge. */
function rank(
  spokes: readonly Point[], [red, blue]: readonly [Point, Point], places: readonly number[], isSecond: boolean,
): { misfit: number; place: number }[] {
  const ranked = places.map((place) => {
    const [toRed, toBlue] = [minus(red, spokes[place]!), minus(blue, spokes[place]!)];
    const area = isSecond ? cross(toRed, toBlue) : cross(toBlue, toRed);
    const dot = toRed[0] * toBlue[0] + toRed[1] * toBlue[1];
    return { misfit: area > 0 ? dot / area : WRONG_SIDE + Math.abs(dot), place };
  });
  return ranked.sort((a, b) => a.misfit - b.misfit);
}
