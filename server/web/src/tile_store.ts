// The tiles of one tileset: which exist, which are loaded, and the loading of more.

import { Box3 } from "three";
import { keyOf, type Address } from "./address.ts";
import { tileBounds, type Bounds, type Frame } from "./frame.ts";
import type { Tiles } from "./select.ts";
import { decodeTile, interiorLevels, type Tile } from "./spt.ts";
import { TileMesh, type SharedUniforms } from "./tile_mesh.ts";
import { tileUrl, type Tileset } from "./tileset.ts";

const PARALLEL_REQUESTS = 6;
/** Textures and indices kept, the tiles in use included. */
const CACHE_BYTES = 256 * 2 ** 20;
const RETRY_MILLISECONDS = 5000;

interface LoadedTile {
  readonly tile: Tile;
  readonly mesh: TileMesh;
  readonly errors: readonly number[];
  /** Number of the selection that last asked for it. */
  lastAsked: number;
}

/** Loads tiles and answers what the selection asks. */
export class TileStore implements Tiles {
  readonly roots: readonly Address[];
  bytesLoaded = 0;
  /** What went wrong last, in one line; undefined once loading works again. */
  failure: string | undefined;
  private readonly loaded = new Map<string, LoadedTile>();
  private readonly underway = new Map<string, AbortController>();
  private readonly retryAt = new Map<string, number>();
  private readonly boxes = new Map<string, Box3>();
  private selection = 0;
  private isClosed = false;

  /** `onLoad` is called after each tile that came in or failed. */
  constructor(
    private readonly tileset: Tileset,
    private readonly frame: Frame,
    private readonly shared: SharedUniforms,
    private readonly onLoad: () => void,
  ) {
    this.roots = [0, 1].map((x) => ({ zoom: 0, x, y: 0 })).filter((root) => this.exists(root));
  }

  get isLoading(): boolean {
    return this.underway.size > 0;
  }

  exists({ zoom, x, y }: Address): boolean {
    const ranges = this.tileset.metadata.zooms.find((entry) => entry.zoom === zoom)?.available ?? [];
    return ranges.some(([firstX, firstY, lastX, lastY]) => x >= firstX && x <= lastX && y >= firstY && y <= lastY);
  }

  /** The tile's own box once it is loaded, before that one of its square; raised with the exaggeration. */
  box(address: Address): Box3 {
    const box = this.loaded.get(keyOf(address))?.mesh.box ?? this.expectedBox(address);
    const exaggeration = this.shared.exaggeration.value;
    const [lowest, highest] = this.tileset.metadata.heights;
    return exaggeration === 1 ? box : box.clone().expandByScalar((exaggeration - 1) * (highest - lowest));
  }

  errors(address: Address): readonly number[] | undefined {
    const found = this.loaded.get(keyOf(address));
    if (found !== undefined) found.lastAsked = this.selection;
    return found?.errors;
  }

  finestError(zoom: number): number {
    return this.tileset.metadata.zooms.find((entry) => entry.zoom === zoom)?.finest_error ?? Infinity;
  }

  /** A loaded tile and what draws it. */
  get(address: Address): { tile: Tile; mesh: TileMesh } | undefined {
    return this.loaded.get(keyOf(address));
  }

  /** Call before each selection: what it does not ask for may be dropped. */
  startSelection(): void {
    this.selection++;
  }

  /** Loads the most urgent tiles, gives up requests for tiles no longer missing, and drops what is long unused. */
  request(missing: readonly Address[]): void {
    const keys = new Set(missing.map(keyOf));
    for (const [key, controller] of this.underway) if (!keys.has(key)) controller.abort();
    const now = Date.now();
    const ready = missing.filter((tile) => {
      const key = keyOf(tile);
      return !this.underway.has(key) && (this.retryAt.get(key) ?? 0) <= now;
    });
    for (const tile of ready.slice(0, Math.max(0, PARALLEL_REQUESTS - this.underway.size))) void this.load(tile);
    this.evict();
  }

  close(): void {
    this.isClosed = true;
    for (const controller of this.underway.values()) controller.abort();
    for (const key of [...this.loaded.keys()]) this.drop(key);
  }

  private async load(address: Address): Promise<void> {
    const key = keyOf(address);
    const controller = new AbortController();
    this.underway.set(key, controller);
    try {
      const tile = await this.fetchTile(address, controller.signal);
      if (!this.isClosed) this.keep(key, tile);
      this.failure = undefined;
    } catch (error) {
      if (!controller.signal.aborted) this.fail(key, error);
    }
    this.underway.delete(key);
    if (!this.isClosed) this.onLoad();
  }

  private async fetchTile(address: Address, signal: AbortSignal): Promise<Tile> {
    const response = await fetch(tileUrl(this.tileset, keyOf(address)), { signal });
    if (!response.ok) throw new Error(`the server answers ${response.status}`);
    const bytes = new Uint8Array(await response.arrayBuffer());
    const tile = decodeTile(bytes);
    if (keyOf(tile.address) !== keyOf(address)) throw new Error(`the server sent tile ${keyOf(tile.address)}`);
    this.bytesLoaded += bytes.length;
    return tile;
  }

  private keep(key: string, tile: Tile): void {
    const mesh = new TileMesh(tile, this.frame, this.shared);
    const errors = tile.levels.slice(0, interiorLevels(tile)).map(({ error }) => error);
    this.loaded.set(key, { tile, mesh, errors, lastAsked: this.selection });
    this.boxes.delete(key);
  }

  /** The coarser tile stays on screen; the selection will ask again. */
  private fail(key: string, error: unknown): void {
    this.failure = `Tile ${key}: ${error instanceof Error ? error.message : String(error)}`;
    this.retryAt.set(key, Date.now() + RETRY_MILLISECONDS);
    setTimeout(() => this.isClosed || this.onLoad(), RETRY_MILLISECONDS);
  }

  private evict(): void {
    const oldestFirst = [...this.loaded].sort(([, a], [, b]) => a.lastAsked - b.lastAsked);
    let bytes = oldestFirst.reduce((sum, [, { mesh }]) => sum + mesh.byteLength, 0);
    for (const [key, { mesh, lastAsked }] of oldestFirst) {
      if (bytes <= CACHE_BYTES || lastAsked === this.selection) return;
      bytes -= mesh.byteLength;
      this.drop(key);
    }
  }

  private drop(key: string): void {
    this.loaded.get(key)?.mesh.dispose();
    this.loaded.delete(key);
  }

  private expectedBox(address: Address): Box3 {
    const key = keyOf(address);
    const { bounds, heights } = this.tileset.metadata;
    const box = this.boxes.get(key) ?? this.frame.box(overlap(tileBounds(address), bounds), heights);
    this.boxes.set(key, box);
    return box;
  }
}

/** The part of a tile that holds data, or the whole tile where the data cross the antimeridian. */
function overlap(tile: Bounds, data: Bounds): Bounds {
  const part: Bounds = [
    Math.max(tile[0], data[0]),
    Math.max(tile[1], data[1]),
    Math.min(tile[2], data[2]),
    Math.min(tile[3], data[3]),
  ];
  return part[0] < part[2] && part[1] < part[3] ? part : tile;
}
