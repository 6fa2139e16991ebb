// Whole numbers of either sign, of which the order of magnitude is guessed beforehand.

import { probabilities, type Probability, type RangeDecoder } from "./range_decoder.ts";

const CLASSES = 16;
const BELOW = 9;
const LENGTH_BITS = 6;
const SMALL_GUESSES = 8;
const SIGNS = 9;
/** The kind of sign that says nothing of it. */
export const NO_SIGN = 4;

/** Statistics of one kind of number. */
export class NumberModel {
  private readonly classes = Array.from({ length: SMALL_GUESSES }, () => probabilities(CLASSES));
  private readonly mantissas = Array.from({ length: CLASSES }, () => probabilities(2));
  private readonly signs: Probability[] = probabilities(SIGNS);

  /** Reads a number that is expected to be as large as `guess`. */
  read(decoder: RangeDecoder, guess: number, sign: number): number {
    const expected = bitLength(Math.floor(guess));
    const kind = decoder.symbol(this.classes[Math.min(expected, SMALL_GUESSES - 1)]!);
    const isEscape = kind === 0 || kind === CLASSES - 1;
    const length = isEscape ? decoder.evenBits(LENGTH_BITS) : Math.max(kind + expected - BELOW, 0);
    if (length === 0) return 0;
    let magnitude = 1;
    const learned = Math.min(length - 1, 1);
    for (let place = 0; place < learned; place++) {
      magnitude = 2 * magnitude + Number(decoder.bit(this.mantissas[kind]![magnitude]!));
    }
    const rest = length - 1 - learned;
    magnitude = magnitude * 2 ** rest + decoder.evenBits(rest);
    return decoder.bit(this.signs[sign]!) ? -magnitude : magnitude;
  }
}

/** How many bits a whole number has; 0 has none. */
function bitLength(value: number): number {
  let length = 0;
  for (; value >= 1; value = Math.floor(value / 2)) length++;
  return length;
}
