// Tiles from a terrain-server.

import { keyOf } from "./address.ts";
import { checkedMetadata, type Tileset } from "./tileset.ts";

const [PARTIAL_CONTENT, NOT_FOUND] = [206, 404];

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

function tilesetOf(base: string, listed: Listed): Tileset {
  const { name, version, metadata } = listed;
  if (typeof name !== "string" || typeof version !== "string") throw new Error("The server lists a tileset without a name.");
  const folder = `${base}${encodeURIComponent(name)}`;
  const query = `?v=${encodeURIComponent(version)}`;
  const ask = async (url: string, init: RequestInit) => {
    const response = await fetch(url, init);
    if (await isOfAnother(response, base, listed)) throw new Error("the server has another archive of this name by now: load the page again");
    return checked(response);
  };
  return {
    name,
    metadata: checkedMetadata(name, metadata),
    source: {
      tile: (address, from, count, signal) => bytesOf(`${folder}/${keyOf(address)}.spt${query}`, from, count, signal, ask),
      normals: async (address, signal) => (await ask(`${folder}/gradients/${keyOf(address)}.png${query}`, { signal })).blob(),
    },
  };
}

/** A part of a file; a server that knows no ranges answers with the whole. */
async function bytesOf(url: string, from: number, count: number, signal: AbortSignal, ask: (url: string, init: RequestInit) => Promise<Response>): Promise<Uint8Array> {
  const response = await ask(url, { signal, headers: { Range: `bytes=${from}-${from + count - 1}` } });
  const bytes = new Uint8Array(await response.arrayBuffer());
  return response.status === PARTIAL_CONTENT ? bytes : bytes.subarray(from);
}

/** What a server does not find, or lets nobody keep, may be of another archive than was asked for: then it lists another version, or none. */
async function isOfAnother(response: Response, base: string, { name, version }: Listed): Promise<boolean> {
  const isOdd = response.status === NOT_FOUND || response.headers.get("Cache-Control")?.includes("no-cache") === true;
  if (!isOdd) return false;
  const now = (await checked(await fetch(`${base}tilesets`)).json()) as readonly Listed[];
  return !now.some((entry) => entry.name === name && entry.version === version);
}

function checked(response: Response): Response {
  if (!response.ok) throw new Error(`the server answers ${response.status}`);
  return response;
}
