// A circuit breaker: a server that fails again and again is left alone for a while, longer each time, and comes back by itself.
//
//   closed ──failures in a row──▶ open ──the wait is over──▶ half-open: one request, a probe
//      ▲                            ▲                            │
//      │                            └────────── it fails ────────┤
//      └─────────────────────────────────────── it works ────────┘

const FAILURES_IN_A_ROW = 4;
const [FIRST_WAIT_MILLISECONDS, LONGEST_WAIT_MILLISECONDS] = [1000, 16_000];

/** A clock and its alarm, milliseconds. */
export interface Clock {
  now(): number;
  /** Calls back later, unless what is returned is called before. */
  after(milliseconds: number, call: () => void): () => void;
}

export const CLOCK: Clock = {
  now: () => Date.now(),
  after: (milliseconds, call) => {
    const timer = setTimeout(call, milliseconds);
    return () => clearTimeout(timer);
  },
};

/** Exponential back-off: how long to wait after so many failures, milliseconds. */
export function backOff(failures: number, first: number, longest: number): number {
  return Math.min(first * 2 ** (failures - 1), longest);
}

/** An error in a line. */
export function faultOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** Why a request was not made: the server fails, or nobody wants the answer any more. */
export class NotAsked extends Error {}

/** What requests are made for. */
export interface Job {
  isWanted: boolean;
}

/** Lets requests to one server through, some at once. */
export class CircuitBreaker {
  /** When the server may be asked again, by the clock. */
  retryAt = 0;
  private failuresInARow = 0;
  private lastFailure: string | undefined;
  private running = 0;
  /** Calls of those that wait for their turn. */
  private waiting: (() => void)[] = [];

  constructor(
    private readonly parallelRequests: number,
    private readonly clock: Clock,
    private readonly onRecovery: () => void,
  ) {}

  /** What the server's failures are, in a line; undefined while it works. */
  get fault(): string | undefined {
    return this.failuresInARow >= FAILURES_IN_A_ROW ? this.lastFailure : undefined;
  }

  /** Whether the server is left alone for now. */
  get isOpen(): boolean {
    return this.fault !== undefined && this.clock.now() < this.retryAt;
  }

  /** Makes a request of a job when it is its turn; {@link NotAsked} where it is not made. A job whose request fails is not wanted any more. */
  async run<T>(ask: () => Promise<T>, job: Job): Promise<T> {
    // After a failure one at a time, until one works.
    while (this.running >= (this.failuresInARow === 0 ? this.parallelRequests : 1)) await new Promise<void>((resolve) => this.waiting.push(resolve));
    if (!job.isWanted) throw new NotAsked("nobody wants it any more");
    if (this.isOpen) throw new NotAsked(this.fault);
    this.running++;
    try {
      const answer = await ask();
      const isRecovered = this.fault !== undefined;
      this.failuresInARow = 0;
      if (isRecovered) this.onRecovery();
      return answer;
    } catch (error) {
      this.fail(error, job);
      throw error;
    } finally {
      this.running--;
      for (const resolve of this.waiting.splice(0)) resolve();
    }
  }

  private fail(error: unknown, job: Job): void {
    this.lastFailure = faultOf(error);
    // What was asked before the circuit opened tells nothing new, nor does a second failure of one job.
    const isNew = job.isWanted && !this.isOpen;
    job.isWanted = false;
    if (!isNew) return;
    this.failuresInARow++;
    const waits = this.failuresInARow - FAILURES_IN_A_ROW + 1;
    if (waits > 0) this.retryAt = this.clock.now() + backOff(waits, FIRST_WAIT_MILLISECONDS, LONGEST_WAIT_MILLISECONDS);
  }
}
