// Tiles from a terrain-server.

import { keyOf } from "./address.ts";
import { checkedMetadata, type Tileset } from "./tileset.ts";

const PARTIAL_CONTENT = 206;

/** What the server lists of one archive. */
interface Listed {
  readonly name: string;
  /** Of the archive's content; tiles that are asked for by it never change. */
  readonly version: string;
  readonly metadata: unknown;
}

/** The archives of the terrain-server at an address, by default the page's own; the error says what is wrong in one line. */
export async function listTilesets(server = ""): Promise<Tileset[]> {
  const base = server === "" || server.endsWith("/") ? server : `${server}/`;
  const response = await fetch(`${base}tilesets`).catch((cause: unknown) => {
    throw new Error("The terrain server does not answer.", { cause });
  });
  if (!response.ok) throw new Error(`The terrain server has no list of tilesets (HTTP ${response.status}).`);
  const listed: unknown = await response.json().catch((cause: unknown) => {
    throw new Error("The server's list of tilesets is no JSON: is this a terrain server?", { cause });
  });
  if (!Array.isArray(listed) || listed.length === 0) throw new Error("The terrain server has no tileset to show.");
  return listed.map((entry) => tilesetOf(base, entry));
}

function tilesetOf(base: string, { name, version, metadata }: Listed): Tileset {
  if (typeof name !== "string" || typeof version !== "string") throw new Error("The server lists a tileset without a name.");
  const folder = `${base}${encodeURIComponent(name)}`;
  const query = `?v=${encodeURIComponent(version)}`;
  return {
    name,
    metadata: checkedMetadata(name, metadata),
    source: {
      tile: (address, from, count, signal) => bytesOf(`${folder}/${keyOf(address)}.spt${query}`, from, count, signal),
      normals: async (address, signal) => (await answer(`${folder}/gradients/${keyOf(address)}.png${query}`, { signal })).blob(),
    },
  };
}

/** A part of a file; a server that knows no ranges answers with the whole. */
async function bytesOf(url: string, from: number, count: number, signal: AbortSignal): Promise<Uint8Array> {
  const response = await answer(url, { signal, headers: { Range: `bytes=${from}-${from + count - 1}` } });
  const bytes = new Uint8Array(await response.arrayBuffer());
  return response.status === PARTIAL_CONTENT ? bytes : bytes.subarray(from);
}

async function answer(url: string, init: RequestInit): Promise<Response> {
  const response = await fetch(url, init);
  if (!response.ok) throw new Error(`the server answers ${response.status}`);
  return response;
}
