// Tiles straight from an archive on any web server that answers range requests; docs/formats/archive.md is the definition.

import { PMTiles } from "pmtiles";
import type { Address } from "./address.ts";
import { checkedMetadata, type Tileset } from "./tileset.ts";

const FORMAT = "surface-partition-tiles";
const VERSION = 3;

/** Opens the archive at an address; the error says what is wrong in one line. */
export async function openArchive(url: string): Promise<Tileset> {
  const name = nameOf(url);
  const archive = new PMTiles(url);
  const described = await archive.getMetadata().catch((cause: unknown) => {
    throw new Error(`${name} cannot be read: ${cause instanceof Error ? cause.message : String(cause)}`, { cause });
  });
  const { format, version } = (described ?? {}) as { format?: unknown; version?: unknown };
  if (format !== FORMAT || version !== VERSION) {
    throw new Error(`${name} is a PMTiles archive, but not of ${FORMAT} version ${VERSION}.`);
  }
  return {
    name,
    metadata: checkedMetadata(name, described),
    source: { tile: (address, signal) => tileOf(archive, address, signal), normals: undefined },
  };
}

/** PMTiles has one root and rows from the north: the two roots here are the northern half of its zoom 1. */
async function tileOf(archive: PMTiles, { zoom, x, y }: Address, signal: AbortSignal): Promise<Uint8Array> {
  const found = await archive.getZxy(zoom + 1, x, 2 ** zoom - 1 - y, signal);
  if (found === undefined) throw new Error("the archive does not have it");
  return new Uint8Array(found.data);
}

/** The file's name, without its extension. */
function nameOf(url: string): string {
  const file = new URL(url, "http://localhost/").pathname.split("/").at(-1) ?? "";
  return decodeURIComponent(file).replace(/\.pmtiles$/, "") || url;
}
