// An archive as a client sees it: its name, what it says of itself, and where its tiles come from.

import type { Address } from "./address.ts";
import type { Bounds } from "./frame.ts";
import type { WaterPolygon } from "./water.ts";

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
  /** Lowest and highest height of any surface, metres; coarse ones go beyond the data. */
  readonly heights: readonly [number, number];
  readonly max_zoom: number;
  /** What the archive was made with. */
  readonly asked?: {
    readonly reading?: {
      /** The ground is nowhere on the Earth: its plane is laid around 0° N, 0° E. */
      readonly local?: boolean;
    };
  };
  readonly zooms: readonly Zoom[];
  /** Where it is known that there is water. */
  readonly water?: readonly WaterPolygon[];
  readonly source?: {
    readonly vertical_datum?: string;
    readonly heights_above?: string;
    /** Lowest and highest sample, metres. */
    readonly heights?: readonly [number, number] | null;
    readonly geoid?: string | null;
  };
}

/** Where tiles come from: a server, or the archive itself. What it cannot get is an error of one line. */
export interface TileSource {
  /** The bytes of a tile that exists from one on: at least so many, or all that there are. */
  tile(address: Address, from: number, count: number, signal: AbortSignal): Promise<Uint8Array>;
  /** The picture of the normals of a tile's square; undefined where the source has none at all. */
  readonly normals: ((address: Address, signal: AbortSignal) => Promise<Blob>) | undefined;
}

/** One archive. */
export interface Tileset {
  readonly name: string;
  readonly metadata: Metadata;
  readonly source: TileSource;
}

/** Data that are wider are seen from all around. */
const GLOBE_DEGREES = 60;

/** Whether the data are so much of the Earth that there is no up which is nearly the same for all of them. */
export function isGlobe({ bounds: [west, south, east, north] }: Metadata): boolean {
  return Math.max(east - west, north - south) > GLOBE_DEGREES;
}

/** Whether the ground of a tileset is nowhere on the Earth. */
export function isLocal({ asked }: Metadata): boolean {
  return asked?.reading?.local === true;
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
  if (isLocal(metadata)) return "Metres on a plane that is nowhere on the Earth";
  const grid = source?.geoid ? ` by ${source.geoid}` : "";
  return above === datum ? `Heights above: ${above}` : `Heights above: ${above}, from ${datum}${grid}`;
}

/** The same value, once it is sure that it describes an archive that can be shown. */
export function checkedMetadata(name: string, value: unknown): Metadata {
  const metadata = value as Metadata | undefined;
  const isNumbers = (list: unknown, length: number) =>
    Array.isArray(list) && list.length === length && list.every(Number.isFinite);
  const isZoom = ({ finest_error, available }: Zoom) =>
    Number.isFinite(finest_error) && Array.isArray(available) && available.every((range) => isNumbers(range, 4));
  const isLists = (list: unknown, isItem: (item: unknown) => boolean) => Array.isArray(list) && list.every(isItem);
  const isRing = (ring: unknown) => isLists(ring, (place) => isNumbers(place, 2));
  const isWater = (water: unknown) => isLists(water, (polygon) => isLists(polygon, isRing));
  const valid =
    isNumbers(metadata?.bounds, 4) &&
    isNumbers(metadata?.heights, 2) &&
    isNumbers(metadata?.source?.heights ?? metadata?.heights, 2) &&
    Array.isArray(metadata?.zooms) &&
    metadata.zooms.every(isZoom) &&
    isWater(metadata.water ?? []);
  if (!valid) throw new Error(`${name} describes itself in a way that is not understood here.`);
  if (metadata.scheme !== "geographic-tms") throw new Error(`${name}: scheme ${metadata.scheme} is not shown here.`);
  return metadata;
}
