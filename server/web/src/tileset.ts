// What the server lists: names and metadata of its archives.

import type { Bounds } from "./frame.ts";

/** The tiles of one zoom. */
export interface Zoom {
  readonly zoom: number;
  readonly tiles: number;
  /** Of their finest surfaces. */
  readonly triangles: number;
  /** Largest certified errors of their finest and coarsest surfaces, metres. */
  readonly finest_error: number;
  readonly coarsest_error: number;
  /** Rectangles of tiles that exist: first x, first y, last x, last y, all inclusive. */
  readonly available: readonly (readonly [number, number, number, number])[];
}

/** An archive's description of itself, as far as the page needs it. */
export interface Metadata {
  readonly format: string;
  readonly scheme: string;
  readonly bounds: Bounds;
  /** Lowest and highest height, metres. */
  readonly heights: readonly [number, number];
  readonly max_zoom: number;
  readonly zooms: readonly Zoom[];
  readonly source?: {
    readonly vertical_datum?: string;
    readonly heights_above?: string;
    readonly geoid?: string | null;
  };
}

/** One archive of the server. */
export interface Tileset {
  readonly name: string;
  /** Of the archive's content; tiles asked for by it never change. */
  readonly version: string;
  readonly metadata: Metadata;
}

/** The archives that the server at the page's own address has; the error says what is wrong in one line. */
export async function listTilesets(): Promise<Tileset[]> {
  const response = await fetch("tilesets").catch((cause: unknown) => {
    throw new Error("The terrain server does not answer.", { cause });
  });
  if (!response.ok) throw new Error(`The terrain server has no list of tilesets (HTTP ${response.status}).`);
  const listed: unknown = await response.json().catch((cause: unknown) => {
    throw new Error("The server's list of tilesets is no JSON: is this a terrain server?", { cause });
  });
  if (!Array.isArray(listed) || listed.length === 0) throw new Error("The terrain server has no tileset to show.");
  return listed.map(checked);
}

/** What the heights of a tileset are above. */
export function datumOf({ source }: Metadata): string {
  return source?.heights_above || source?.vertical_datum || "unspecified";
}

/** What the heights of a tileset are above, and what made them so, in a line. */
export function heightsAbove(metadata: Metadata): string {
  const { source } = metadata;
  const datum = source?.vertical_datum || "unspecified";
  const above = datumOf(metadata);
  const grid = source?.geoid ? ` by ${source.geoid}` : "";
  return above === datum ? `Heights above: ${above}` : `Heights above: ${above}, from ${datum}${grid}`;
}

/** URL of a tile of an archive, relative to the page. */
export function tileUrl(tileset: Tileset, key: string): string {
  return `${encodeURIComponent(tileset.name)}/${key}.spt?v=${encodeURIComponent(tileset.version)}`;
}

/** URL of the raster of normals of a tile's square, relative to the page. */
export function normalsUrl(tileset: Tileset, key: string): string {
  return `${encodeURIComponent(tileset.name)}/gradients/${key}.webp?v=${encodeURIComponent(tileset.version)}`;
}

function checked(value: Tileset): Tileset {
  const metadata: Metadata | undefined = value?.metadata;
  const isNumbers = (list: unknown, length: number) =>
    Array.isArray(list) && list.length === length && list.every(Number.isFinite);
  const isZoom = ({ finest_error, available }: Zoom) =>
    Number.isFinite(finest_error) && Array.isArray(available) && available.every((range) => isNumbers(range, 4));
  const valid =
    typeof value?.name === "string" &&
    typeof value.version === "string" &&
    isNumbers(metadata?.bounds, 4) &&
    isNumbers(metadata?.heights, 2) &&
    Array.isArray(metadata?.zooms) &&
    metadata.zooms.every(isZoom);
  if (!valid) throw new Error("The server describes a tileset in a way this page does not understand.");
  if (metadata.scheme !== "geographic-tms") throw new Error(`${value.name}: scheme ${metadata.scheme} is not shown here.`);
  return value;
}
