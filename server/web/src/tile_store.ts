// The tiles of one tileset: which exist, which are loaded, and the loading of more.

import { keyOf, type Address } from "./address.ts";
import { tileBounds, type Bounds, type Frame } from "./frame.ts";
import { grown, type OrientedBox } from "./oriented_box.ts";
import { triangleCount } from "./partition.ts";
import type { Hierarchy, Level, TileRequest } from "./select.ts";
import { placed, type PlacedTile } from "./spots.ts";
import { DecodeError, HeaderCut } from "./decode_error.ts";
import { interiorLevels, type Level as TileLevel, type Tile } from "./tile.ts";
import { tileDecoders, type Decoding } from "./tile_decoders.ts";
import { TileMesh, type Cells, type SharedUniforms } from "./tile_mesh.ts";
import type { Tileset } from "./tileset.ts";
import { Water } from "./water.ts";

const PARALLEL_REQUESTS = 6;
/** What is asked for first of a tile: most tiles' headers and coarsest levels are shorter. */
const FIRST_BYTES = 2048;
/** Textures and indices kept, the tiles in use included. */
export const CACHE_BYTES = 256 * 2 ** 20;
/** Of a tile that is not loaded, some: an index and half a vertex, of which there are two places. */
const BYTES_PER_TRIANGLE = 40;
const RETRY_MILLISECONDS = 5000;
const ALL_SIDES = [true, true, true, true];

/** What of a tile is drawn. */
interface Drawable extends PlacedTile {
  readonly mesh: TileMesh;
  readonly cells: Cells;
  /** How many levels it has. */
  readonly there: number;
  /** The interior ones of the whole tile. */
  readonly levels: readonly Level[];
}

interface LoadedTile {
  decoding: Decoding;
  /** Behind what was decoded until there is a time to take it up. */
  drawable: Drawable;
  /** Number of the selection that last asked for it. */
  lastAsked: number;
}

/** Loads tiles, level by level, and answers what the selection asks. */
export class TileStore implements Hierarchy {
  readonly roots: readonly Address[];
  bytesLoaded = 0;
  /** What went wrong last, in one line; undefined once loading works again, or nothing is missing. */
  failure: string | undefined;
  private readonly loaded = new Map<string, LoadedTile>();
  /** Tiles that are decoded further, or from the beginning again, than what is drawn of them. */
  private readonly ahead = new Set<string>();
  private readonly underway = new Map<string, AbortController>();
  private readonly retryAt = new Map<string, number>();
  /** Tiles that are loaded in part, and whose next bytes could not be decoded: they have to begin anew. */
  private readonly broken = new Set<string>();
  private readonly boxes = new Map<string, OrientedBox>();
  private readonly water: Water;
  private selection = 0;
  /** What was asked for last. */
  private missing: readonly TileRequest[] = [];
  private isClosed = false;

  /** `onLoad` is called after each tile that came in or failed. */
  constructor(
    private readonly tileset: Tileset,
    private readonly frame: Frame,
    private readonly shared: SharedUniforms,
    private readonly onLoad: () => void,
  ) {
    this.water = new Water(tileset.metadata.water ?? []);
    this.roots = [0, 1].map((x) => ({ zoom: 0, x, y: 0 })).filter((root) => this.exists(root));
  }

  get isLoading(): boolean {
    return this.underway.size > 0;
  }

  /** Whether levels have come in that are to be taken up. */
  get hasMore(): boolean {
    return this.ahead.size > 0;
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
    return found.drawable.levels;
  }

  levelsThere(address: Address): number {
    return this.loaded.get(keyOf(address))?.drawable.there ?? 0;
  }

  /** A loaded tile and what draws it. */
  get(address: Address): Drawable | undefined {
    return this.loaded.get(keyOf(address))?.drawable;
  }

  /** What a tile's header says of its levels, the four sides among them. */
  allLevels(address: Address): readonly TileLevel[] {
    return this.loaded.get(keyOf(address))?.decoding.levels ?? [];
  }

  /** Lets levels be drawn that have come in since. It takes the place of tiles and meshes, so that what is drawn has to be shown anew. */
  takeUp(): void {
    for (const key of this.ahead) {
      const { decoding, drawable } = this.loaded.get(key)!;
      drawable.mesh.dispose();
      this.keep(key, decoding, decoding.tile!);
    }
  }

  /** Call before each selection: what it does not ask for may be dropped. */
  startSelection(): void {
    this.selection++;
  }

  /** Loads the most urgent tiles, gives up requests for tiles no longer missing, and drops what is long unused. */
  request(missing: readonly TileRequest[]): void {
    const keys = new Set(missing.map(({ address }) => keyOf(address)));
    for (const [key, controller] of this.underway) if (!keys.has(key)) controller.abort();
    this.missing = missing;
    if (missing.length === 0) this.failure = undefined;
    this.loadNext();
    this.evict();
  }

  close(): void {
    this.isClosed = true;
    for (const controller of this.underway.values()) controller.abort();
    for (const key of [...this.loaded.keys()]) this.drop(key);
  }

  /** As many as may be under way. */
  private loadNext(): void {
    const now = Date.now();
    const ready = this.missing.filter(({ address, levels }) => {
      const key = keyOf(address);
      const isThere = (this.loaded.get(key)?.decoding.levelsThere ?? 0) >= levels;
      return !isThere && !this.underway.has(key) && (this.retryAt.get(key) ?? 0) <= now;
    });
    for (const tile of ready.slice(0, Math.max(0, PARALLEL_REQUESTS - this.underway.size))) void this.load(tile);
  }

  private async load({ address, levels }: TileRequest): Promise<void> {
    const key = keyOf(address);
    const controller = new AbortController();
    this.underway.set(key, controller);
    let decoding = this.broken.has(key) ? undefined : this.loaded.get(key)?.decoding;
    try {
      decoding ??= await this.begin(address, controller.signal);
      decoding = await this.goOn(decoding, levels, controller.signal);
      if (decoding.levelsThere < Math.min(levels, decoding.ends.length)) throw new Error("the levels are cut off");
      this.failure = undefined;
    } catch (error) {
      if (error instanceof DecodeError) this.broken.add(key);
      if (!controller.signal.aborted) this.fail(key, error);
    }
    if (decoding !== undefined) this.accept(key, decoding);
    this.underway.delete(key);
    if (this.isClosed) return;
    // The line is not idle until the next frame.
    this.loadNext();
    this.onLoad();
  }

  /** The first bytes of a tile, at least its header. */
  private async begin(address: Address, signal: AbortSignal): Promise<Decoding> {
    for (let count = FIRST_BYTES; ; count *= 4) {
      const bytes = await this.bytes(address, 0, count, signal);
      try {
        const decoding = await tileDecoders.begin(bytes);
        if (keyOf(decoding.address) !== keyOf(address)) throw new Error(`there is tile ${keyOf(decoding.address)}`);
        return decoding;
      } catch (error) {
        if (!(error instanceof HeaderCut) || bytes.length < count) throw error;
      }
    }
  }

  /** Loads a tile's bytes up to the end of so many levels. */
  private async goOn(decoding: Decoding, levels: number, signal: AbortSignal): Promise<Decoding> {
    const end = decoding.ends[Math.min(levels, decoding.ends.length) - 1]!;
    if (decoding.bytesThere >= end) return decoding;
    const bytes = await this.bytes(decoding.address, decoding.bytesThere, end - decoding.bytesThere, signal);
    return tileDecoders.goOn(decoding, bytes);
  }

  private async bytes(address: Address, from: number, count: number, signal: AbortSignal): Promise<Uint8Array> {
    const bytes = await this.tileset.source.tile(address, from, count, signal);
    // What was given up meanwhile may be forgotten by those who would decode it.
    signal.throwIfAborted();
    this.bytesLoaded += bytes.length;
    return bytes;
  }

  /** What is drawn of a tile already is only replaced by {@link takeUp}. */
  private accept(key: string, decoding: Decoding): void {
    const known = this.loaded.get(key);
    if (known?.decoding === decoding) return;
    this.broken.delete(key);
    if (this.isClosed || decoding.tile === undefined) tileDecoders.forget(decoding);
    else if (known === undefined) this.keep(key, decoding, decoding.tile);
    else {
      known.decoding = decoding;
      if (decoding.levelsThere === known.drawable.there) this.ahead.delete(key);
      else this.ahead.add(key);
    }
  }

  private keep(key: string, decoding: Decoding, decoded: Tile): void {
    const tile = placed(decoded, this.frame);
    const known = this.loaded.get(key)?.drawable;
    const water = known === undefined ? this.water.texels(tileBounds(decoded.address)) : known.cells.water;
    const cells = { filled: decoding.filled, water };
    const mesh = new TileMesh(tile, cells, this.frame, this.shared);
    const drawable = { ...tile, mesh, cells, there: decoding.levelsThere, levels: levelsOf(decoding, mesh) };
    this.loaded.set(key, { decoding, drawable, lastAsked: this.loaded.get(key)?.lastAsked ?? this.selection });
    this.boxes.set(key, this.boxOf(decoded));
    this.ahead.delete(key);
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
    let bytes = oldestFirst.reduce((sum, [, { drawable }]) => sum + drawable.mesh.byteLength, 0);
    for (const [key, { drawable, lastAsked }] of oldestFirst) {
      if (bytes <= CACHE_BYTES || lastAsked === this.selection) return;
      bytes -= drawable.mesh.byteLength;
      this.drop(key);
    }
  }

  private drop(key: string): void {
    const dropped = this.loaded.get(key);
    if (dropped === undefined) return;
    this.underway.get(key)?.abort();
    tileDecoders.forget(dropped.decoding);
    dropped.drawable.mesh.dispose();
    this.loaded.delete(key);
    this.ahead.delete(key);
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

/** The interior levels of a tile; the finest with all sides fine. Its mesh holds those that are there. */
function levelsOf({ levels }: Decoding, mesh: TileMesh): readonly Level[] {
  const count = interiorLevels({ levels });
  return levels.slice(0, count).map(({ error }, interior) => {
    const triangles = triangleCount({ levels }, { interior, fineSides: interior + 1 === count ? ALL_SIDES : [] });
    return { error, triangles, bytes: mesh.byteLength };
  });
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
