// Where there is water, as an archive knows it: polygons, and which cells of a tile they cover.

import type { Bounds } from "./frame.ts";

/** Cells along a side of a tile. */
export const WATER_CELLS = 256;

/** Rings of longitudes and latitudes in degrees: what is inside of an odd number of them is water. Longitudes go on past ±180°. */
export type WaterPolygon = readonly (readonly (readonly [number, number])[])[];

export class Water {
  private readonly areas: readonly { readonly polygon: WaterPolygon; readonly bounds: Bounds }[];

  constructor(polygons: readonly WaterPolygon[]) {
    this.areas = polygons.map((polygon) => ({ polygon, bounds: boundsOf(polygon) }));
  }

  /** A texel a cell, rows from the south, 255 where the cell's middle is water; undefined where no middle is. */
  texels(tile: Bounds): Uint8Array<ArrayBuffer> | undefined {
    const texels = new Uint8Array(WATER_CELLS * WATER_CELLS);
    for (const turn of [-360, 0, 360]) {
      const [west, east] = [tile[0] + turn, tile[2] + turn];
      for (const { polygon, bounds } of this.areas) {
        const isApart = bounds[0] > east || bounds[2] < west || bounds[1] > tile[3] || bounds[3] < tile[1];
        if (!isApart) fill(texels, polygon, [west, tile[1], east, tile[3]]);
      }
    }
    return texels.includes(255) ? texels : undefined;
  }
}

function boundsOf(polygon: WaterPolygon): Bounds {
  const bounds: [number, number, number, number] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const ring of polygon) {
    for (const [x, y] of ring) {
      bounds[0] = Math.min(bounds[0], x);
      bounds[1] = Math.min(bounds[1], y);
      bounds[2] = Math.max(bounds[2], x);
      bounds[3] = Math.max(bounds[3], y);
    }
  }
  return bounds;
}

/** Row by row, between every first and second crossing of a ring with the line through the middles of the row's cells. */
function fill(texels: Uint8Array, polygon: WaterPolygon, [west, south, east, north]: Bounds): void {
  const crossings: number[][] = Array.from({ length: WATER_CELLS }, () => []);
  const cell = ([x, y]: readonly [number, number]) => [((x - west) / (east - west)) * WATER_CELLS - 0.5, ((y - south) / (north - south)) * WATER_CELLS - 0.5] as const;
  for (const ring of polygon) {
    for (let at = 0; at < ring.length; at++) {
      const ends = [cell(ring[at]!), cell(ring[(at + 1) % ring.length]!)] as const;
      const [lower, upper] = ends[0][1] < ends[1][1] ? ends : ([ends[1], ends[0]] as const);
      for (let row = Math.max(0, Math.ceil(lower[1])); row < Math.min(WATER_CELLS, upper[1]); row++) {
        crossings[row]!.push(lower[0] + ((upper[0] - lower[0]) * (row - lower[1])) / (upper[1] - lower[1]));
      }
    }
  }
  for (const [row, places] of crossings.entries()) {
    places.sort((a, b) => a - b);
    for (let at = 0; at + 1 < places.length; at += 2) {
      const [first, last] = [Math.max(0, Math.ceil(places[at]!)), Math.min(WATER_CELLS, Math.ceil(places[at + 1]!))];
      if (first < last) texels.fill(255, row * WATER_CELLS + first, row * WATER_CELLS + last);
    }
  }
}
