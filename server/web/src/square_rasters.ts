// Rasters over the squares of tiles, such as normals or imagery. Optional: where one is missing, a coarser one does.

import type * as THREE from "three";
import { keyOf, parentOf, type Address } from "./address.ts";

const RETRY_MILLISECONDS = 5000;

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

interface Settings<R extends SquareRaster> {
  /** Gets a raster; undefined if there is none to get. What fails is tried again later. */
  load(demand: RasterDemand, signal: AbortSignal): Promise<R | undefined>;
  readonly parallelRequests: number;
  readonly mostBytes: number;
}

/** Loads rasters of what is drawn, coarse squares first, and keeps those used last. */
export class SquareRasters<R extends SquareRaster> {
  bytesLoaded = 0;
  /** What went wrong last, in one line; undefined once a raster came in again. */
  failure: string | undefined;
  /** In the order of last use; without a raster where there is none. */
  private readonly loaded = new Map<string, { readonly detail: number; readonly raster: R | undefined }>();
  private readonly underway = new Set<string>();
  private readonly retryAt = new Map<string, number>();
  private readonly aborting = new AbortController();

  /** `onLoad` is called after each raster that came in or failed. */
  constructor(
    private readonly settings: Settings<R>,
    private readonly onLoad: () => void,
  ) {}

  get isLoading(): boolean {
    return this.underway.size > 0;
  }

  /** Whether there is none of any of the squares that were asked for. */
  get isEmpty(): boolean {
    return this.loaded.size > 0 && [...this.loaded.values()].every(({ raster }) => raster === undefined);
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
    const coarseFirst = [...demands].sort((a, b) => a.address.zoom - b.address.zoom);
    for (const demand of coarseFirst) {
      const key = keyOf(demand.address);
      const isDue = (this.retryAt.get(key) ?? 0) <= Date.now();
      const isThere = (this.loaded.get(key)?.detail ?? -Infinity) >= demand.detail;
      if (this.underway.size >= this.settings.parallelRequests) return;
      if (isDue && !isThere && !this.underway.has(key)) void this.load(key, demand);
    }
  }

  close(): void {
    this.aborting.abort();
    for (const { raster } of this.loaded.values()) raster?.texture.dispose();
    this.loaded.clear();
  }

  private use(key: string): R | undefined {
    const found = this.loaded.get(key);
    if (found === undefined) return undefined;
    this.loaded.delete(key);
    this.loaded.set(key, found);
    return found.raster;
  }

  private async load(key: string, demand: RasterDemand): Promise<void> {
    this.underway.add(key);
    try {
      const raster = await this.settings.load(demand, this.aborting.signal);
      if (this.aborting.signal.aborted) raster?.texture.dispose();
      else this.keep(key, demand.detail, raster);
      this.failure = undefined;
    } catch (error) {
      this.failure = error instanceof Error ? error.message : String(error);
      this.retryAt.set(key, Date.now() + RETRY_MILLISECONDS);
      setTimeout(() => this.aborting.signal.aborted || this.onLoad(), RETRY_MILLISECONDS);
    }
    this.underway.delete(key);
    if (!this.aborting.signal.aborted) this.onLoad();
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
