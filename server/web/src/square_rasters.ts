// Rasters over the squares of tiles, such as normals or imagery. Optional: where one is missing, a coarser one does.

import type * as THREE from "three";
import { keyOf, parentOf, type Address } from "./address.ts";
import { backOff, CircuitBreaker, CLOCK, faultOf, NotAsked, type Clock, type Job } from "./circuit_breaker.ts";

/** Of a square that failed while others came. */
const [FIRST_RETRY_MILLISECONDS, LONGEST_RETRY_MILLISECONDS] = [2000, 64_000];

/** A raster of one square. */
export interface SquareRaster {
  readonly texture: THREE.Texture;
  /** Of the file or files that it came from. */
  readonly bytesLoaded: number;
  /** On the graphics card. */
  readonly bytesKept: number;
}

/** Where a square is in the raster that it is drawn with: how wide in it, and its south-west corner. */
export interface RasterPlace<R extends SquareRaster> {
  readonly raster: R;
  readonly of: Address;
  readonly size: number;
  readonly x: number;
  readonly y: number;
}

/** A square, and how fine a raster it should have: any number, larger ones finer. */
export interface RasterDemand {
  readonly address: Address;
  readonly detail: number;
}

/** A raster to be loaded. */
export interface RasterOrder extends RasterDemand {
  /** How fine a raster was asked for before, and came or was not there; less than all that is asked for if none was. */
  readonly known: number;
  readonly signal: AbortSignal;
  /** Makes one request to the server, when it may be made. */
  ask<T>(get: () => Promise<T>): Promise<T>;
}

interface Settings<R extends SquareRaster> {
  /** Gets a raster; undefined if there is none to get. What fails is tried again later. */
  load(order: RasterOrder): Promise<R | undefined>;
  readonly parallelSquares: number;
  readonly parallelRequests: number;
  readonly mostBytes: number;
}

/** A square that failed. */
interface Failed {
  readonly times: number;
  readonly retryAt: number;
  readonly fault: string;
}

/**
 * Loads rasters of what is drawn, coarse squares first, and keeps those used last. Where a square has none, that of a square above it is
 * loaded. What fails is tried again ever later, and while the server fails it is asked for one thing at a time.
 */
export class SquareRasters<R extends SquareRaster> {
  bytesLoaded = 0;
  /** Why something that was asked for last is not here, in one line. */
  failure: string | undefined;
  /** In the order of last use; without a raster where there is none. */
  private readonly loaded = new Map<string, { readonly detail: number; readonly raster: R | undefined }>();
  private readonly underway = new Map<string, Job>();
  private readonly failed = new Map<string, Failed>();
  private readonly breaker: CircuitBreaker;
  private readonly aborting = new AbortController();
  private cancelAlarm = () => {};

  /** `onLoad` is called after each raster that came in or failed, and when one may be tried again. */
  constructor(
    private readonly settings: Settings<R>,
    private readonly onLoad: () => void,
    private readonly clock: Clock = CLOCK,
  ) {
    this.breaker = new CircuitBreaker(settings.parallelRequests, clock, () => this.failed.clear());
  }

  get isLoading(): boolean {
    return this.underway.size > 0;
  }

  /** Whether there is no raster here at all. */
  get isBlank(): boolean {
    return [...this.loaded.values()].every(({ raster }) => raster === undefined);
  }

  /** Whether there is none to get of any of the squares that were asked for. */
  get isEmpty(): boolean {
    return this.loaded.size > 0 && !this.isLoading && this.isBlank;
  }

  /** The finest raster that there is of a square. */
  finest(address: Address): RasterPlace<R> | undefined {
    let [of, size, x, y] = [address, 1, 0, 0];
    for (;;) {
      const raster = this.use(keyOf(of));
      if (raster !== undefined) return { raster, of, size, x, y };
      if (of.zoom === 0) return undefined;
      [size, x, y] = [size / 2, (x + (of.x % 2)) / 2, (y + (of.y % 2)) / 2];
      of = parentOf(of);
    }
  }

  /** Loads what is missing of the squares drawn. */
  request(demands: readonly RasterDemand[]): void {
    this.cancelAlarm();
    const missing = demands.map((demand) => this.available(demand)).filter((demand) => !this.isThere(demand));
    missing.sort((a, b) => a.address.zoom - b.address.zoom);
    const failures = missing.flatMap(({ address }) => this.failed.get(keyOf(address)) ?? []);
    this.failure = missing.length === 0 ? undefined : (this.breaker.fault ?? failures[0]?.fault);
    if (missing.length === 0) return;
    if (this.breaker.isOpen) return this.wakeAt(this.breaker.retryAt);
    for (const demand of missing) {
      const key = keyOf(demand.address);
      if (this.underway.size >= (this.breaker.fault === undefined ? this.settings.parallelSquares : 1)) return;
      const isDue = (this.failed.get(key)?.retryAt ?? -Infinity) <= this.clock.now();
      if (isDue && !this.underway.has(key)) void this.load(key, demand);
    }
    const later = failures.map(({ retryAt }) => retryAt).filter((retryAt) => retryAt > this.clock.now());
    if (later.length > 0) this.wakeAt(Math.min(...later));
  }

  close(): void {
    this.cancelAlarm();
    this.aborting.abort();
    for (const job of this.underway.values()) job.isWanted = false;
    for (const { raster } of this.loaded.values()) raster?.texture.dispose();
    this.loaded.clear();
  }

  /** What stands for a square: itself, or the nearest one above it of which it is not known that there is none. */
  private available(demand: RasterDemand): RasterDemand {
    const known = this.loaded.get(keyOf(demand.address));
    const hasNone = known !== undefined && known.raster === undefined && known.detail >= demand.detail;
    return hasNone && demand.address.zoom > 0 ? this.available({ address: parentOf(demand.address), detail: 0 }) : demand;
  }

  private isThere({ address, detail }: RasterDemand): boolean {
    return (this.loaded.get(keyOf(address))?.detail ?? -Infinity) >= detail;
  }

  private wakeAt(time: number): void {
    this.cancelAlarm = this.clock.after(Math.max(0, time - this.clock.now()), this.onLoad);
  }

  private use(key: string): R | undefined {
    const found = this.loaded.get(key);
    if (found === undefined) return undefined;
    this.loaded.delete(key);
    this.loaded.set(key, found);
    return found.raster;
  }

  private async load(key: string, demand: RasterDemand): Promise<void> {
    const job: Job = { isWanted: true };
    this.underway.set(key, job);
    const { signal } = this.aborting;
    const ask = <T>(get: () => Promise<T>) => this.breaker.run(get, job);
    try {
      const known = this.loaded.get(key)?.detail ?? -Infinity;
      const raster = await this.settings.load({ ...demand, known, signal, ask });
      if (signal.aborted) raster?.texture.dispose();
      else this.keep(key, demand.detail, raster);
      this.failed.delete(key);
    } catch (error) {
      if (!(error instanceof NotAsked)) this.fail(key, error);
    }
    this.underway.delete(key);
    if (!signal.aborted) this.onLoad();
  }

  private fail(key: string, error: unknown): void {
    const times = (this.failed.get(key)?.times ?? 0) + 1;
    const retryAt = this.clock.now() + backOff(times, FIRST_RETRY_MILLISECONDS, LONGEST_RETRY_MILLISECONDS);
    this.failed.set(key, { times, retryAt, fault: faultOf(error) });
  }

  /** A finer raster takes the place of a coarser one; that there is no finer one leaves the coarser. */
  private keep(key: string, detail: number, raster: R | undefined): void {
    const before = this.loaded.get(key)?.raster;
    this.loaded.delete(key);
    this.loaded.set(key, { detail, raster: raster ?? before });
    if (raster === undefined) return;
    before?.texture.dispose();
    this.bytesLoaded += raster.bytesLoaded;
    let bytes = [...this.loaded.values()].reduce((sum, entry) => sum + (entry.raster?.bytesKept ?? 0), 0);
    for (const [oldest, entry] of this.loaded) {
      if (bytes <= this.settings.mostBytes || oldest === key) return;
      bytes -= entry.raster?.bytesKept ?? 0;
      entry.raster?.texture.dispose();
      this.loaded.delete(oldest);
    }
  }
}
