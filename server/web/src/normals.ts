// Rasters of normals, which light the ground in more detail than its triangles have. Without one there are facets.

import * as THREE from "three";
import { SquareRasters, type SquareRaster } from "./square_rasters.ts";
import type { TileSource } from "./tileset.ts";

/** 256 rasters of 257² normals of four bytes each. */
const MOST_BYTES = 256 * 257 * 257 * 4;

/** The normals that a source has; none where it has none. */
export function normalsOf({ normals }: TileSource, onLoad: () => void): SquareRasters<SquareRaster> {
  const load = async ({ address }: { address: Parameters<NonNullable<typeof normals>>[0] }, signal: AbortSignal) => {
    const file = await normals?.(address, signal);
    return file && { texture: await decodeNormals(file), bytesLoaded: file.size, bytesKept: 257 * 257 * 4 };
  };
  return new SquareRasters({ load, parallelRequests: 2, mostBytes: MOST_BYTES }, onLoad);
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
