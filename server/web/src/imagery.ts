// Imagery in tiles of the web mercator scheme, as a picture for each square of the terrain.
//
// A square of zoom z is as wide as 2^k mercator tiles of zoom z + 1 + k, and those that it touches are put together row by row:
//
//        ┌───┬───┐  top of the picture
//      ┌─┼───┼───┼─┐  north of the square
//      │ ├───┼───┤ │
//      │ ├───┼───┤ │  so the picture's rows are mercator's; the shader finds the row of a latitude
//      └─┼───┼───┼─┘  south of the square
//        └───┴───┘

import * as THREE from "three";
import type { Address } from "./address.ts";
import { tileBounds } from "./frame.ts";
import { SquareRasters, type RasterDemand, type SquareRaster } from "./square_rasters.ts";

/** Where imagery comes from. */
export interface Imagery {
  /** An address with `{z}`, `{x}` and `{y}`, rows from the north. */
  readonly template: string;
  /** Whose it is, to be shown beside it. */
  readonly attribution: string;
}

/** A picture and which part of the Earth it shows. */
export interface Picture extends SquareRaster {
  /** Latitude that mercator rows are told from, radians: the square's south, or the end of the scheme. */
  readonly base: number;
  /** Mercator units of the picture's bottom above the base, and of its height. */
  readonly bottom: number;
  readonly height: number;
}

/** The scheme's square ends at this latitude, in degrees and in radians. */
const END = 85.0511287;
export const MERCATOR_END = THREE.MathUtils.degToRad(END);
const MOST_BYTES = 384 * 2 ** 20;
const TILE_PIXELS = 256;
/** Of 2^k tiles across. */
const FINEST_DETAIL = 2;
const FINEST_ZOOM = 22;

/** The pictures of an imagery. */
export function picturesOf({ template }: Imagery, onLoad: () => void): SquareRasters<Picture> {
  const load = (demand: RasterDemand, signal: AbortSignal) => pictureOf(template, demand, signal);
  return new SquareRasters({ load, parallelRequests: 4, mostBytes: MOST_BYTES }, onLoad);
}

/** Why there is none to be seen, in a line. */
export function imageryFault({ failure, isEmpty }: SquareRasters<Picture>): string | undefined {
  return failure ?? (isEmpty ? "its server has no tiles here" : undefined);
}

/** How fine a picture a square needs that is so many pixels wide on the screen. */
export function detailFor(pixels: number, { zoom }: Address): number {
  const finest = Math.min(FINEST_DETAIL, FINEST_ZOOM - zoom - 1);
  return THREE.MathUtils.clamp(Math.ceil(Math.log2(pixels / TILE_PIXELS)), 0, Math.max(0, finest));
}

/** Undefined where there are no tiles. */
async function pictureOf(template: string, { address, detail }: RasterDemand, signal: AbortSignal): Promise<Picture | undefined> {
  const zoom = address.zoom + 1 + detail;
  const [, south, , north] = tileBounds(address);
  if (south >= END || north <= -END) return undefined;
  const size = (2 * Math.PI) / 2 ** zoom;
  const rowAt = (latitude: number) => (Math.PI - mercator(latitude)) / size;
  const first = Math.max(0, Math.floor(rowAt(Math.min(north, END)) + 1e-9));
  const last = Math.min(2 ** zoom, Math.ceil(rowAt(Math.max(south, -END)) - 1e-9));
  const columns = 2 ** detail;
  const canvas = new OffscreenCanvas(columns * TILE_PIXELS, (last - first) * TILE_PIXELS);
  const context = canvas.getContext("2d")!;
  const places = Array.from({ length: columns * (last - first) }, (_, at) => [at % columns, Math.floor(at / columns)] as const);
  const sizes = await Promise.all(
    places.map(async ([column, row]) => {
      const file = await fetchTile(template, zoom, address.x * columns + column, first + row, signal);
      if (file === undefined) return undefined;
      const image = await createImageBitmap(file);
      context.drawImage(image, column * TILE_PIXELS, row * TILE_PIXELS, TILE_PIXELS, TILE_PIXELS);
      image.close();
      return file.size;
    }),
  );
  if (sizes.every((bytes) => bytes === undefined)) return undefined;
  const base = Math.max(south, -END);
  return {
    texture: textureOf(canvas),
    bytesLoaded: sizes.reduce<number>((sum, bytes) => sum + (bytes ?? 0), 0),
    bytesKept: (canvas.width * canvas.height * 4 * 4) / 3,
    base: THREE.MathUtils.degToRad(base),
    bottom: Math.PI - last * size - mercator(base),
    height: (last - first) * size,
  };
}

function textureOf(canvas: OffscreenCanvas): THREE.Texture {
  const texture = new THREE.CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = THREE.ClampToEdgeWrapping;
  texture.anisotropy = 8;
  return texture;
}

/** Undefined where the server has none. */
async function fetchTile(template: string, zoom: number, x: number, y: number, signal: AbortSignal): Promise<Blob | undefined> {
  const numbers: Record<string, number> = { z: zoom, x, y };
  const response = await fetch(template.replace(/\{([zxy])\}/g, (_, name: string) => String(numbers[name])), { signal }).catch(() => undefined);
  if (response === undefined) throw new Error("its server cannot be reached, or allows no other pages to read it");
  if (response.status === 204 || response.status === 404) return undefined;
  if (!response.ok) throw new Error(`its server answers ${response.status}`);
  return response.blob();
}

function mercator(latitude: number): number {
  return Math.asinh(Math.tan(THREE.MathUtils.degToRad(latitude)));
}

/** What is wrong with a template, in a line. */
export function templateFault(template: string): string | undefined {
  const missing = ["{z}", "{x}", "{y}"].filter((part) => !template.includes(part));
  return missing.length === 0 ? undefined : `The address of imagery has to have ${missing.join(" and ")} in it.`;
}
