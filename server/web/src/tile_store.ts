// The tiles of one tileset: which exist, which are loaded, and the loading of more.

import { keyOf, type Address } from "./address.ts";
import { tileBounds, type Bounds, type Frame } from "./frame.ts";
import { grown, type OrientedBox } from "./oriented_box.ts";
import { triangleCount } from "./partition.ts";
import type { Hierarchy, Level } from "./select.ts";
import { decodeTile, interiorLevels, type Tile } from "./spt.ts";
import { TileMesh, type SharedUniforms } from "./tile_mesh.ts";
import type { Tileset } from "./tileset.ts";

const PARALLEL_REQUESTS = 6;
/** Textures and indices kept, the tiles in use included. */
export const CACHE_BYTES = 256 * 2 ** 20;
/** Of a tile that is not loaded, some: an index and half a vertex, of which there are two places. */
const BYTES_PER_TRIANGLE = 40;
const RETRY_MILLISECONDS = 5000;

interface LoadedTile {
  readonly tile: Tile;
  readonly mesh: TileMesh;
  readonly levels: readonly Level[];
  /** Number of the selection that last asked for it. */
  lastAsked: number;
}

/** Loads tiles and answers what the selection asks. */
export class TileStore implements Hierarchy {
  readonly roots: readonly Address[];
  bytesLoaded = 0;
  /** What went wrong last, in one line; undefined once loading works again. */
  failure: string | undefined;
  private readonly loaded = new Map<string, LoadedTile>();
  private readonly underway = new Map<string, AbortController>();
  private readonly retryAt = new Map<string, number>();
  private readonly boxes = new Map<string, OrientedBox>();
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

  /** Metres that the exaggeration raises the highest point of the data. */
  get raise(): number {
    const [lowest, highest] = this.tileset.metadata.heights;
    return (this.shared.exaggeration.value - 1) * (highest - lowest);
  }

  /** Of the tile's own heights once it is loaded, before that of all heights; raised with the exaggeration. */
  bounds(address: Address): OrientedBox {
    const key = keyOf(address);
    const box = this.boxes.get(key) ?? this.boxBetween(address, this.tileset.metadata.heights);
    this.boxes.set(key, box);
    return this.raise === 0 ? box : grown(box, Math.abs(this.raise));
  }

  /** The selection asks for those of every tile that it looks at, which is therefore not dropped. */
  levels(address: Address): readonly Level[] {
    const found = this.loaded.get(keyOf(address));
    if (found === undefined) return this.expectedLevels(address);
    found.lastAsked = this.selection;
    return found.levels;
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
    const bytes = await this.tileset.source.tile(address, signal);
    const tile = decodeTile(bytes);
    if (keyOf(tile.address) !== keyOf(address)) throw new Error(`there is tile ${keyOf(tile.address)}`);
    this.bytesLoaded += bytes.length;
    return tile;
  }

  private keep(key: string, tile: Tile): void {
    const mesh = new TileMesh(tile, this.frame, this.shared);
    const fineSides = [true, true, true, true];
    const levels = tile.levels.slice(0, interiorLevels(tile)).map(({ error }, interior) => {
      const isFinest = interior + 1 === interiorLevels(tile);
      const triangles = triangleCount(tile, { interior, fineSides: isFinest ? fineSides : [] });
      return { error, triangles, bytes: mesh.byteLength };
    });
    this.loaded.set(key, { tile, mesh, levels, lastAsked: this.selection });
    this.boxes.set(key, this.boxOf(tile));
  }

  /** Holds the tile and all below it: whatever is drawn there is as near to the source as the tile's finest surface is. */
  private boxOf({ address, positions, levels }: Tile): OrientedBox {
    const margin = 2 * (levels.at(-1)?.error ?? 0);
    let [lowest, highest] = [Infinity, -Infinity];
    for (let at = 2; at < positions.length; at += 3) {
      lowest = Math.min(lowest, positions[at]!);
      highest = Math.max(highest, positions[at]!);
    }
    return this.boxBetween(address, [lowest - margin, highest + margin]);
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

  /** What the metadata say of all tiles of a zoom. */
  private expectedLevels({ zoom }: Address): readonly Level[] {
    const known = this.tileset.metadata.zooms.find((entry) => entry.zoom === zoom);
    if (known === undefined) throw new Error(`the archive has no zoom ${zoom}`);
    const triangles = known.triangles / known.tiles;
    return [{ error: known.finest_error, triangles, bytes: BYTES_PER_TRIANGLE * triangles }];
  }

  private boxBetween(address: Address, heights: readonly [number, number]): OrientedBox {
    return this.frame.orientedBox(overlap(tileBounds(address), this.tileset.metadata.bounds), heights);
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
