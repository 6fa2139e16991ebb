// What stands before the levels of a tile or a model, in numbers of any length; docs/formats/spm.md is the definition.

import { check, DecodeError } from "./decode_error.ts";
import type { Sampling } from "./split_decoder.ts";

const LONGEST_NUMBER = 6;
const SAMPLING_BYTES = 32;
/** Samples lie at least so far from each other and at most so far from the corner, in lattice units. */
const [LEAST_STEP, GREATEST_DISTANCE] = [2 ** -16, 2 ** 41];

/** What bytes may ask of the browser. */
export interface LevelLimits {
  readonly levels: number;
  readonly vertices: number;
  readonly triangles: number;
}

/** How far the arrays reach for one level, and what its surface is good for. */
export interface Level {
  /** Vertices of this level and all before it. */
  readonly vertexEnd: number;
  /** Triangles of this level and all before it. */
  readonly triangleEnd: number;
  /** Certified vertical error of the surface so far, metres. */
  readonly error: number;
}

/** What the directory tells of a level. */
export interface Entry extends Level {
  /** Bytes of its splits. */
  readonly length: number;
}

/** The bytes end before the levels begin. */
export class HeaderCut extends DecodeError {}

/** Reads one number of any length after the other: seven bits a byte, the lowest first. */
export class Numbers {
  constructor(
    private readonly bytes: Uint8Array,
    public at: number,
  ) {}

  /** A number below 2^32. */
  next(): number {
    const number = this.variable();
    check(number < 2 ** 32, "a number is out of range");
    return number;
  }

  /** A number of either sign: even ones are twice it, odd ones are for those below 0. */
  signed(): number {
    const number = this.variable();
    return number % 2 === 0 ? number / 2 : -(number + 1) / 2;
  }

  private variable(): number {
    let number = 0;
    for (let place = 0; place < LONGEST_NUMBER; place++) {
      const byte = this.bytes[this.at++];
      if (byte === undefined) throw new HeaderCut("the header is cut off");
      number += (byte % 128) * 128 ** place;
      if (byte < 128) return number;
    }
    throw new DecodeError("a number is out of range");
  }
}

export function readSampling(view: DataView, numbers: Numbers): Sampling {
  const { at } = numbers;
  numbers.at += SAMPLING_BYTES;
  if (numbers.at > view.byteLength) throw new HeaderCut("the header is cut off");
  const number = (index: number) => view.getFloat64(at + 8 * index, true);
  const sampling = { origin: [number(0), number(1)], step: [number(2), number(3)] } as const;
  const isNear = sampling.origin.every((coordinate) => Math.abs(coordinate) <= GREATEST_DISTANCE);
  const isApart = sampling.step.every((step) => step >= LEAST_STEP && step <= GREATEST_DISTANCE);
  check(isNear && isApart, "the samples are out of range");
  return sampling;
}

/** Each entry tells what is new since the one before; errors by their bits. */
export function readDirectory(numbers: Numbers, levelCount: number, limits: LevelLimits, hasOutlineErrors: boolean): Entry[] {
  const entries: Entry[] = [];
  let [vertexEnd, triangleEnd, bits, previous] = [0, 0, 0, Infinity];
  for (let index = 0; index < levelCount; index++) {
    const name = `level ${index}`;
    const length = numbers.next();
    const vertices = numbers.next();
    vertexEnd += vertices;
    const triangles = 2 * vertices - numbers.signed();
    triangleEnd += triangles;
    bits += numbers.signed();
    if (hasOutlineErrors) numbers.signed();
    const error = new Float32Array(Uint32Array.of(bits).buffer)[0]!;
    check(vertexEnd <= limits.vertices, `${name}: bad vertex count`);
    check(triangles >= 0 && triangleEnd <= limits.triangles, `${name}: bad triangle count`);
    check(bits >= 0 && bits < 2 ** 31 && error <= previous, `${name}: bad error ${error}`);
    entries.push({ length, vertexEnd, triangleEnd, error });
    previous = error;
  }
  return entries;
}

/** Where each level ends, if the first begins at `start`. */
export function endsOf(entries: readonly Entry[], start: number): number[] {
  let end = start;
  return entries.map(({ length }) => (end += length));
}
