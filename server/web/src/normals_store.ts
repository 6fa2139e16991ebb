// Rasters of normals, which light the ground in more detail than its triangles have. Optional: without one there are facets.

import * as THREE from "three";
import { keyOf, parentOf, type Address } from "./address.ts";
import type { TileMesh } from "./tile_mesh.ts";
import type { TileSource } from "./tileset.ts";

const PARALLEL_REQUESTS = 2;
/** Rasters kept: 257² normals of four bytes each. */
const MOST_RASTERS = 256;
const RETRY_MILLISECONDS = 5000;

/** Loads rasters of normals of what is drawn, coarse ones first. */
export class NormalsStore {
  bytesLoaded = 0;
  isEnabled = true;
  /** In the order of last use. */
  private readonly loaded = new Map<string, THREE.DataTexture>();
  private readonly underway = new Set<string>();
  private readonly retryAt = new Map<string, number>();
  private readonly aborting = new AbortController();

  /** `onLoad` is called after each raster that came in or failed. */
  constructor(
    private readonly source: TileSource,
    private readonly onLoad: () => void,
  ) {}

  get isLoading(): boolean {
    return this.underway.size > 0;
  }

  /** Gives a mesh the finest raster that there is of its square, and asks for its own. */
  light(address: Address, mesh: TileMesh): void {
    const [source, size, x, y] = this.isEnabled ? this.finest(address) : [undefined, 0, 0, 0];
    mesh.setNormals(source ?? null, source === undefined ? 0 : size, x, y);
  }

  /** Loads what is missing of the squares drawn. */
  request(addresses: readonly Address[]): void {
    const { normals } = this.source;
    if (!this.isEnabled || normals === undefined) return;
    const coarseFirst = [...addresses].sort((a, b) => a.zoom - b.zoom);
    for (const address of coarseFirst) {
      const key = keyOf(address);
      const isDue = (this.retryAt.get(key) ?? 0) <= Date.now();
      if (this.underway.size >= PARALLEL_REQUESTS) return;
      if (isDue && !this.loaded.has(key) && !this.underway.has(key)) void this.load(key, normals(address, this.aborting.signal));
    }
  }

  close(): void {
    this.aborting.abort();
    for (const texture of this.loaded.values()) texture.dispose();
    this.loaded.clear();
  }

  private finest(address: Address): [THREE.DataTexture | undefined, number, number, number] {
    let [at, size, x, y] = [address, 1, 0, 0];
    for (;;) {
      const texture = this.loaded.get(keyOf(at));
      if (texture !== undefined) {
        this.loaded.delete(keyOf(at));
        this.loaded.set(keyOf(at), texture);
        return [texture, size, x, y];
      }
      if (at.zoom === 0) return [undefined, 0, 0, 0];
      [size, x, y] = [size / 2, (x + (at.x % 2)) / 2, (y + (at.y % 2)) / 2];
      at = parentOf(at);
    }
  }

  private async load(key: string, picture: Promise<Blob>): Promise<void> {
    this.underway.add(key);
    try {
      const file = await picture;
      const texture = await decodeNormals(file);
      if (!this.aborting.signal.aborted) this.keep(key, texture);
      this.bytesLoaded += file.size;
    } catch {
      this.retryAt.set(key, Date.now() + RETRY_MILLISECONDS);
      setTimeout(() => this.aborting.signal.aborted || this.onLoad(), RETRY_MILLISECONDS);
    }
    this.underway.delete(key);
    if (!this.aborting.signal.aborted) this.onLoad();
  }

  private keep(key: string, texture: THREE.DataTexture): void {
    this.loaded.set(key, texture);
    for (const [oldest, unused] of this.loaded) {
      if (this.loaded.size <= MOST_RASTERS) return;
      unused.dispose();
      this.loaded.delete(oldest);
    }
  }
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
