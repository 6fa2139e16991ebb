// The raster that an archive was made of, in WGS 84 degrees: what clients show is held against it.

import { readFile } from "node:fs/promises";
import { fromArrayBuffer } from "geotiff";

/** Places on a grid inside the sample. */
export const PLACES = Array.from({ length: 25 }, (_, i) => [-84.36 + 0.05 * (i % 5), 36.2 + 0.05 * Math.floor(i / 5)]);

/** Heights of the source at places: bilinear between samples, undefined beside them. */
export async function readDem(path) {
  const file = await readFile(path);
  const image = await (await fromArrayBuffer(file.buffer.slice(file.byteOffset, file.byteOffset + file.length))).getImage();
  const [west, south, east, north] = image.getBoundingBox();
  const [samples] = await image.readRasters();
  const columns = image.getWidth(), rows = image.getHeight();
  return (longitude, latitude) => {
    const x = (longitude - west) / (east - west) * columns - 0.5;
    const y = (north - latitude) / (north - south) * rows - 0.5;
    if (x < 0 || y < 0 || x > columns - 1 || y > rows - 1) return undefined;
    const [column, row] = [Math.min(Math.floor(x), columns - 2), Math.min(Math.floor(y), rows - 2)];
    const at = (dx, dy) => samples[(row + dy) * columns + column + dx];
    const [u, v] = [x - column, y - row];
    return (at(0, 0) * (1 - u) + at(1, 0) * u) * (1 - v) + (at(0, 1) * (1 - u) + at(1, 1) * u) * v;
  };
}

/** How far a height is off along the vertical at least, if it may be that of a place some metres away. */
export function offNearby(dem, longitude, latitude, height, metres) {
  let least = Math.abs(height - dem(longitude, latitude));
  const degree = 111_000;
  for (let direction = 0; direction < 16; direction++) {
    for (const share of [0.5, 1]) {
      const [east, north] = [Math.cos, Math.sin].map((f) => f(direction * Math.PI / 8) * share * metres / degree);
      const expected = dem(longitude + east / Math.cos(latitude * Math.PI / 180), latitude + north);
      if (expected !== undefined) least = Math.min(least, Math.abs(height - expected));
    }
  }
  return least;
}
