// Rasters of normals, which light the ground in more detail than its triangles have. Without one there are facets.

import * as THREE from "three";
import { parentOf, type Address } from "./address.ts";
import { SquareRasters, type RasterOrder, type SquareRaster } from "./square_rasters.ts";
import type { TileSource } from "./tileset.ts";

/** Along a side of a raster as it is drawn; as it comes, there are half as many. */
export const CELLS = 256;
/** Kept of tiles' own; finer light may take as much again. */
const MOST_RASTERS = 128;
/** What a cell may cover on the screen. */
const MOST_PIXELS = 2;

/** The normals that a source has; none where it has none. */
export function normalsOf(source: TileSource, onLoad: () => void): SquareRasters<SquareRaster> {
  return new SquareRasters({ load: rasterLoader(source), parallelSquares: 2, parallelRequests: 2, mostBytes: rasterBytes(MOST_RASTERS) }, onLoad);
}

/** Gets the raster of a square. */
export function rasterLoader({ normals }: TileSource): (order: RasterOrder) => Promise<SquareRaster | undefined> {
  return async ({ address, ask, signal }) => {
    const file = normals && (await ask(() => normals(address, signal)));
    return file && { texture: await decodeNormals(file), bytesLoaded: file.size, bytesKept: rasterBytes(1) };
  };
}

/** Of so many rasters: a normal at each corner of their cells, of four bytes each. */
export function rasterBytes(count: number): number {
  return count * (CELLS + 1) ** 2 * 4;
}

/**
 * Whose raster is fine enough for a square that is so many pixels wide on the screen, if a cell may cover so many: its own, or that of a
 * square above, which has four, sixteen, … squares in as many bytes.
 */
export function squareForLight(address: Address, pixels: number, mostPixels = MOST_PIXELS): Address {
  const isFine = pixels <= (mostPixels * CELLS) / 2;
  return isFine && address.zoom > 0 ? squareForLight(parentOf(address), 2 * pixels, mostPixels) : address;
}

async function decodeNormals(file: Blob): Promise<THREE.DataTexture> {
  const image = await createImageBitmap(file, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  const context = new OffscreenCanvas(image.width, image.height).getContext("2d", { willReadFrequently: true })!;
  context.drawImage(image, 0, 0);
  const { data, width } = context.getImageData(0, 0, image.width, image.height);
  const greys = new Uint8Array(data.length / 4);
  for (let pixel = 0; pixel < greys.length; pixel++) greys[pixel] = data[4 * pixel]!;
  return normalsTexture(normalTexels(greys, width), 2 * width - 1, 2 * width - 1);
}

/** Of the parts to the east and to the north, as half floats, rows from the south. */
export function normalsTexture(texels: Uint16Array<ArrayBuffer>, width: number, height: number): THREE.DataTexture {
  const texture = new THREE.DataTexture(texels, width, height, THREE.RGFormat, THREE.HalfFloatType);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

/**
 * The parts of normals to the east and to the north, as half floats, rows from the south, and one between each two that are told. Of
 * two squares of so many greys along a side, rows from the north, that of the parts to the north below the other: 128 ± 127 √|n|.
 */
export function normalTexels(greys: Uint8Array, side: number): Uint16Array<ArrayBuffer> {
  const fine = 2 * side - 1;
  const texels = new Uint16Array(2 * fine * fine);
  const parts = new Float32Array(fine * fine);
  for (const part of [0, 1]) {
    for (let row = 0; row < side; row++) {
      const fromNorth = (part * side + side - 1 - row) * side;
      for (let column = 0; column < side; column++) {
        const root = (greys[fromNorth + column]! - 128) / 127;
        parts[2 * (row * fine + column)] = root * Math.abs(root);
      }
      fillBetween(parts, 2 * row * fine, 1, fine);
    }
    for (let column = 0; column < fine; column++) fillBetween(parts, column, fine, fine);
    for (let texel = 0; texel < parts.length; texel++) texels[2 * texel + part] = THREE.DataUtils.toHalfFloat(parts[texel]!);
  }
  return texels;
}

/** Every second of a line of numbers, from the two on each side of it by a cubic, from three by a parabola at the ends. */
function fillBetween(numbers: Float32Array, first: number, step: number, count: number): void {
  const at = (index: number) => numbers[first + index * step]!;
  const last = count - 1;
  for (let between = 3; between < last - 1; between += 2) {
    numbers[first + between * step] = (9 * (at(between - 1) + at(between + 1)) - at(between - 3) - at(between + 3)) / 16;
  }
  numbers[first + step] = (3 * at(0) + 6 * at(2) - at(4)) / 8;
  numbers[first + (last - 1) * step] = (3 * at(last) + 6 * at(last - 2) - at(last - 4)) / 8;
}
