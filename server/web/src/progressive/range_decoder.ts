// The adaptive binary range decoder under the levels of a tile; docs/formats/spm.md is the definition.

const WORD = 2 ** 16;
const LEAST_RANGE = 2 ** 32;
const EVEN_BITS = 16;
const AHEAD = 6;
const LEAST = 32;
const RATES = [1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 6];

/** How likely a bit is 1, in 65,536ths, and how many answers that was learned from. */
export interface Probability {
  one: number;
  answers: number;
}

/** As many fresh probabilities. */
export function probabilities(count: number): Probability[] {
  return Array.from({ length: count }, () => ({ one: 32768, answers: 0 }));
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

  /** A bit whose probability is learned. */
  bit(probability: Probability): boolean {
    const bit = this.decide(Math.floor(this.range / WORD) * probability.one);
    const target = bit ? WORD - LEAST : LEAST;
    probability.one += (target - probability.one) >> RATES[probability.answers]!;
    probability.answers = Math.min(probability.answers + 1, RATES.length - 1);
    return bit;
  }

  /** A number of as many bits, the highest first, each as likely 0 as 1: sixteen at a time. */
  evenBits(count: number): number {
    let value = 0;
    for (; count > EVEN_BITS; count -= EVEN_BITS) value = value * 2 ** EVEN_BITS + this.fewEvenBits(EVEN_BITS);
    return value * 2 ** count + this.fewEvenBits(count);
  }

  /** One of as many symbols as there are probabilities, a power of two. */
  symbol(tree: Probability[]): number {
    let node = 1;
    while (node < tree.length) node = 2 * node + Number(this.bit(tree[node]!));
    return node - tree.length;
  }

  private fewEvenBits(count: number): number {
    this.range = Math.floor(this.range / 2 ** count);
    const value = Math.min(Math.floor(this.code / this.range), 2 ** count - 1);
    this.code -= value * this.range;
    this.narrow();
    return value;
  }

  private decide(bound: number): boolean {
    const bit = this.code < bound;
    if (bit) {
      this.range = bound;
    } else {
      this.code -= bound;
      this.range -= bound;
    }
    this.narrow();
    return bit;
  }

  private narrow(): void {
    while (this.range < LEAST_RANGE) {
      this.range *= WORD;
      this.shift();
    }
  }

  private shift(): void {
    const [high, low] = [this.bytes[this.next] ?? 0, this.bytes[this.next + 1] ?? 0];
    this.code = this.code * WORD + high * 256 + low;
    this.next += 2;
  }
}
