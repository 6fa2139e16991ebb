// The adaptive binary range decoder under the levels of a tile; docs/formats/spm.md is the definition.

const WORD = 2 ** 16;
const LEAST_RANGE = 2 ** 32;
const EVEN_BITS = 16;
const AHEAD = 6;
const LEAST = 32;
const RATES = Uint8Array.of(1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 6);
/** Bits of a probability's number that count answers, of which there are as many as rates. */
const ANSWER_BITS = 5;
const MOST_ANSWERS = 31;

/** How likely bits are 1: each number holds that in 65,536ths, and in its lowest bits how many answers it was learned from. */
export type Probabilities = Int32Array;

/** As many fresh probabilities. */
export function probabilities(count: number): Probabilities {
  return new Int32Array(count).fill(32768 << ANSWER_BITS);
}

/** Reads bits. The range has 48 bits, so that its products with probabilities are exact. */
export class RangeDecoder {
  private readonly end: number;
  private next = 0;
  private code = 0;
  private range = 2 ** 48 - 1;

  /** Whatever follows the bytes is 0; unless they are cut, then it may not be read. */
  constructor(private readonly bytes: Uint8Array, isCut: boolean) {
    this.end = bytes.length + (isCut ? 0 : AHEAD);
    for (let count = 0; count < AHEAD; count += 2) this.shift();
  }

  /** Whether more was read than there is. */
  get isExhausted(): boolean {
    return this.next > this.end;
  }

  /** A bit, 0 or 1, whose probability is learned. */
  bit(of: Probabilities, at: number): number {
    const known = of[at]!;
    const one = known >> ANSWER_BITS;
    const answers = known & MOST_ANSWERS;
    const bound = Math.floor(this.range / WORD) * one;
    const bit = this.code < bound ? 1 : 0;
    if (bit === 1) {
      this.range = bound;
    } else {
      this.code -= bound;
      this.range -= bound;
    }
    const target = bit === 1 ? WORD - LEAST : LEAST;
    const learned = one + ((target - one) >> RATES[answers]!);
    of[at] = (learned << ANSWER_BITS) | (answers < MOST_ANSWERS ? answers + 1 : answers);
    if (this.range < LEAST_RANGE) this.widen();
    return bit;
  }

  /** A number of as many bits, the highest first, each as likely 0 as 1: sixteen at a time. */
  evenBits(count: number): number {
    let value = 0;
    for (; count > EVEN_BITS; count -= EVEN_BITS) value = value * WORD + this.fewEvenBits(EVEN_BITS);
    return count === 0 ? value : value * (1 << count) + this.fewEvenBits(count);
  }

  /** One of `count` symbols, a power of two, by as many probabilities from one on. */
  symbol(of: Probabilities, from: number, count: number): number {
    let node = 1;
    while (node < count) node = 2 * node + this.bit(of, from + node);
    return node - count;
  }

  private fewEvenBits(count: number): number {
    this.range = Math.floor(this.range / (1 << count));
    const value = Math.min(Math.floor(this.code / this.range), (1 << count) - 1);
    this.code -= value * this.range;
    if (this.range < LEAST_RANGE) this.widen();
    return value;
  }

  private widen(): void {
    do {
      this.range *= WORD;
      this.shift();
    } while (this.range < LEAST_RANGE);
  }

  private shift(): void {
    const { bytes, next } = this;
    const high = next < bytes.length ? bytes[next]! : 0;
    const low = next + 1 < bytes.length ? bytes[next + 1]! : 0;
    this.code = this.code * WORD + high * 256 + low;
    this.next += 2;
  }
}
