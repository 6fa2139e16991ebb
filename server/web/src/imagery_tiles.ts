// Tiles of imagery: squares of the web mercator scheme, rows from the north.

import { keyOf, parentOf, type Address } from "./address.ts";
import type { RasterOrder } from "./square_rasters.ts";

/** The picture of a tile, and the bytes of its file. */
export interface ImageryTile {
  readonly image: ImageBitmap;
  readonly bytes: number;
}

/** Where a tile is in the picture of one above it, or in its own: how wide in it, and its north-west corner. */
export interface TilePart<T> {
  readonly tile: T;
  readonly size: number;
  readonly x: number;
  readonly y: number;
}

/** Loads tiles, and remembers which are not there. */
export class ImageryTiles {
  private readonly absent = new Set<string>();

  constructor(private readonly template: string) {}

  /** Undefined where the server has none. */
  async get(address: Address, { ask, signal }: Pick<RasterOrder, "ask" | "signal">): Promise<ImageryTile | undefined> {
    const key = keyOf(address);
    if (this.absent.has(key)) return undefined;
    const tile = await ask(() => fetchTile(this.template, address, signal));
    if (tile === undefined) this.absent.add(key);
    return tile;
  }
}

/** The tiles of one picture, each loaded once. */
export class TilesOfPicture {
  private readonly tiles = new Map<string, Promise<ImageryTile | undefined>>();

  constructor(
    private readonly all: ImageryTiles,
    private readonly order: RasterOrder,
  ) {}

  readonly get = (address: Address): Promise<ImageryTile | undefined> => {
    const key = keyOf(address);
    const tile = this.tiles.get(key) ?? this.all.get(address, this.order);
    this.tiles.set(key, tile);
    return tile;
  };

  /** Those that are under way are closed when they come. */
  close(): void {
    for (const tile of this.tiles.values()) tile.then((there) => there?.image.close()).catch(() => {});
  }
}

/** The part of the nearest tile that there is, at an address or above it, that shows what is at the address. */
export async function nearestAbove<T>(address: Address, get: (address: Address) => Promise<T | undefined>): Promise<TilePart<T> | undefined> {
  const tile = await get(address);
  if (tile !== undefined) return { tile, size: 1, x: 0, y: 0 };
  const above = address.zoom === 0 ? undefined : await nearestAbove(parentOf(address), get);
  return above && { tile: above.tile, size: above.size / 2, x: above.x + (address.x % 2) * (above.size / 2), y: above.y + (address.y % 2) * (above.size / 2) };
}

async function fetchTile(template: string, { zoom, x, y }: Address, signal: AbortSignal): Promise<ImageryTile | undefined> {
  const numbers: Record<string, number> = { z: zoom, x, y };
  const response = await fetch(template.replace(/\{([zxy])\}/g, (_, name: string) => String(numbers[name])), { signal }).catch(() => undefined);
  if (response === undefined) throw new Error("its server cannot be reached, or allows no other pages to read it");
  if (response.status === 204 || response.status === 404) return undefined;
  if (!response.ok) throw new Error(`its server answers ${response.status}`);
  const file = await response.blob();
  const image = await createImageBitmap(file).catch(() => undefined);
  if (image === undefined) throw new Error("its server answers with what is no picture");
  return { image, bytes: file.size };
}
