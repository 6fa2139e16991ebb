// Rasters of normals, which light the ground in more detail than its triangles have. Without one there are facets.

import * as THREE from "three";
import { parentOf, type Address } from "./address.ts";
import { SquareRasters, type SquareRaster } from "./square_rasters.ts";
import type { TileSource } from "./tileset.ts";

/** Along a side of a raster. */
const CELLS = 256;
/** 256 rasters, a normal at each corner of their cells, of four bytes each. */
const MOST_BYTES = 256 * (CELLS + 1) ** 2 * 4;
/** What a cell may cover on the screen. */
const MOST_PIXELS = 2;

/** The normals that a source has; none where it has none. */
export function normalsOf({ normals }: TileSource, onLoad: () => void): SquareRasters<SquareRaster> {
  const load = async ({ address }: { address: Address }, signal: AbortSignal) => {
    const file = await normals?.(address, signal);
    return file && { texture: await decodeNormals(file), bytesLoaded: file.size, bytesKept: (CELLS + 1) ** 2 * 4 };
  };
  return new SquareRasters({ load, parallelRequests: 2, mostBytes: MOST_BYTES }, onLoad);
}

/**
 * Whose raster is fine enough for a square that is so many pixels wide on the screen: its own, or that of a square above, which has four,
 * sixteen, … squares in as many bytes.
 */
export function squareForLight(address: Address, pixels: number): Address {
  const isFine = pixels <= (MOST_PIXELS * CELLS) / 2;
  return isFine && address.zoom > 0 ? squareForLight(parentOf(address), 2 * pixels) : address;
}

/** Rows from the north become rows from the south; red and green are 128 ± 127 √|n|. */
async function decodeNormals(file: Blob): Promise<THREE.DataTexture> {
  const image = await createImageBitmap(file, { imageOrientation: "flipY", colorSpaceConversion: "none", premultiplyAlpha: "none" });
  const context = new OffscreenCanvas(image.width, image.height).getContext("2d", { willReadFrequently: true })!;
  context.drawImage(image, 0, 0);
  const { data, width, height } = context.getImageData(0, 0, image.width, image.height);
  const normals = new Uint16Array(2 * width * height);
  for (let texel = 0; texel < width * height; texel++) {
    for (const channel of [0, 1]) {
      const root = (data[4 * texel + channel]! - 128) / 127;
      normals[2 * texel + channel] = THREE.DataUtils.toHalfFloat(root * Math.abs(root));
    }
  }
  const texture = new THREE.DataTexture(normals, width, height, THREE.RGFormat, THREE.HalfFloatType);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}
