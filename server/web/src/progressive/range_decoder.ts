// The adaptive binary range decoder under the levels of a tile; docs/formats/spm.md is the definition.

const LEAST_RANGE = 2 ** 24;
const EVEN_BITS = 16;
const AHEAD = 4;
const RATES = [1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 6];

/** How likely a bit is 1, in 65,536ths, and how many answers that was learned from. */
export interface Probability {
  one: number;
  answers: number;
}

/** As many fresh probabilities. */
export function probabilities(count: number): Probability[] {
  return Array.from({ length: count }, () => ({ one: 32768, answers: 0 }));
}

/** Reads bits. */
export class RangeDecoder {
  private next = 0;
  private code = 0;
  private range = 2 ** 32 - 1;

  constructor(private readonly bytes: Uint8Array) {
    for (let count = 0; count < AHEAD; count++) this.shift();
  }

  /** Whether more was read than there is. */
  get isExhausted(): boolean {
    return this.next > this.bytes.length + AHEAD;
  }

  /** A bit whose probability is learned. */
  bit(probability: Probability): boolean {
    const bit = this.decide(Math.floor(this.range / 65536) * Math.max(probability.one, 1));
    const rate = RATES[probability.answers]!;
    probability.one += bit ? (65535 - probability.one) >> rate : -(probability.one >> rate);
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
      this.range *= 256;
      this.shift();
    }
  }

  private shift(): void {
    this.code = (this.code * 256 + (this.bytes[this.next++] ?? 0)) % 2 ** 32;
  }
}
