// Tiles straight from an archive on any web server that answers range requests; docs/formats/archive.md is the definition.

import { EtagMismatch, findTile, PMTiles, ResolvedValueCache, zxyToTileId, type Entry, type Header } from "pmtiles";
import type { Address } from "./address.ts";
import { checkedMetadata, type Tileset } from "./tileset.ts";

const FORMAT = "surface-partition-tiles";
const VERSION = 3;

/** Opens the archive at an address; the error says what is wrong in one line. */
export async function openArchive(url: string): Promise<Tileset> {
  const name = nameOf(url);
  // This cache, unlike the usual one, does not keep what failed.
  const archive = new PMTiles(url, new ResolvedValueCache());
  const described = await archive.getMetadata().catch((cause: unknown) => {
    throw new Error(`${name} cannot be read: ${cause instanceof Error ? cause.message : String(cause)}`, { cause });
  });
  const { format, version } = (described ?? {}) as { format?: unknown; version?: unknown };
  if (format !== FORMAT || version !== VERSION) {
    throw new Error(`${name} is a PMTiles archive, but not of ${FORMAT} version ${VERSION}.`);
  }
  const files = new Files(archive);
  return {
    name,
    metadata: checkedMetadata(name, described),
    source: { tile: (address, from, count, signal) => files.bytes(address, from, count, signal), normals: undefined },
  };
}

/** The tiles as files inside an archive. */
class Files {
  /** Parts of the directory that are on their way, by their place in the archive. */
  private readonly underway = new Map<number, Promise<Entry[]>>();

  constructor(private readonly archive: PMTiles) {}

  /** A part of a tile: so many bytes from one on, or as many as there are. */
  async bytes(address: Address, from: number, count: number, signal: AbortSignal): Promise<Uint8Array> {
    const { tileDataOffset, etag } = await this.archive.getHeader();
    const { offset, length } = await this.find(address);
    const most = Math.min(count, length - from);
    if (most <= 0) return new Uint8Array();
    signal.throwIfAborted();
    const { data } = await this.archive.source.getBytes(tileDataOffset + offset + from, most, signal, etag).catch((error: unknown) => {
      throw error instanceof EtagMismatch ? new Error("the archive is another one by now: load the page again", { cause: error }) : error;
    });
    return new Uint8Array(data);
  }

  /** PMTiles has one root and rows from the north: the two roots here are the northern half of its zoom 1. */
  private async find({ zoom, x, y }: Address): Promise<Entry> {
    const id = zxyToTileId(zoom + 1, x, 2 ** zoom - 1 - y);
    const header = await this.archive.getHeader();
    let [offset, length] = [header.rootDirectoryOffset, header.rootDirectoryLength];
    for (let depth = 0; depth < DEEPEST_DIRECTORY; depth++) {
      const entry = findTile(await this.directory(header, offset, length), id);
      if (entry === null) throw new Error("the archive does not have it");
      if (entry.runLength > 0) return entry;
      [offset, length] = [header.leafDirectoryOffset + entry.offset, entry.length];
    }
    throw new Error("the archive's directory is too deep");
  }

  private directory(header: Header, offset: number, length: number): Promise<Entry[]> {
    const { archive, underway } = this;
    const asked = underway.get(offset);
    if (asked !== undefined) return asked;
    const found = archive.cache.getDirectory(archive.source, offset, length, header).finally(() => underway.delete(offset));
    underway.set(offset, found);
    return found;
  }
}

/** As in the specification of PMTiles. */
const DEEPEST_DIRECTORY = 4;

/** The file's name, without its extension. */
function nameOf(url: string): string {
  const file = new URL(url, "http://localhost/").pathname.split("/").at(-1) ?? "";
  return decodeURIComponent(file).replace(/\.pmtiles$/, "") || url;
}
