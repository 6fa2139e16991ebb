// Whole numbers of either sign, of which the order of magnitude is guessed beforehand.

import { probabilities, type RangeDecoder } from "./range_decoder.ts";

const CLASSES = 16;
const BELOW = 9;
const LENGTH_BITS = 6;
const SMALL_GUESSES = 8;
const SIGNS = 9;
/** Of two, up to those of the longest numbers. */
const POWERS = Float64Array.from({ length: 2 ** LENGTH_BITS }, (_, bits) => 2 ** bits);
/** The kind of sign that says nothing of it. */
export const NO_SIGN = 4;

/** Statistics of one kind of number. */
export class NumberModel {
  private readonly classes = probabilities(SMALL_GUESSES * CLASSES);
  /** Of the bit behind the first one, by the class. */
  private readonly seconds = probabilities(CLASSES);
  private readonly signs = probabilities(SIGNS);

  /** Reads a number that is expected to be as large as `guess`. */
  read(decoder: RangeDecoder, guess: number, sign: number): number {
    const expected = bitLength(guess);
    const kind = decoder.symbol(this.classes, Math.min(expected, SMALL_GUESSES - 1) * CLASSES, CLASSES);
    const isEscape = kind === 0 || kind === CLASSES - 1;
    const length = isEscape ? decoder.evenBits(LENGTH_BITS) : Math.max(kind + expected - BELOW, 0);
    if (length === 0) return 0;
    const magnitude = length === 1 ? 1 : this.readMagnitude(decoder, kind, length - 2);
    return decoder.bit(this.signs, sign) === 1 ? -magnitude : magnitude;
  }

  /** With so many bits behind the second one. */
  private readMagnitude(decoder: RangeDecoder, kind: number, rest: number): number {
    const high = 2 + decoder.bit(this.seconds, kind);
    return high * POWERS[rest]! + decoder.evenBits(rest);
  }
}

/** How many bits a number's whole part has; 0 has none. */
function bitLength(value: number): number {
  return value < 2 ** 32 ? 32 - Math.clz32(value) : 32 + bitLength(value / 2 ** 32);
}
