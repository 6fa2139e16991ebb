// Where there is water, as an archive knows it: polygons, and which cells of a tile they cover.

import type { Bounds } from "./frame.ts";

/** Cells along a side of a tile. */
export const WATER_CELLS = 256;

/** Rings of longitudes and latitudes in degrees: what is inside of an odd number of them is water. Longitudes go on past ±180°. */
export type WaterPolygon = readonly (readonly (readonly [number, number])[])[];

/** Vertices that are looked at together. */
const RUN = 64;

/** Edges one after the other, from a vertex of a ring to another, and the box around them. */
interface Run {
  readonly first: number;
  readonly last: number;
  readonly bounds: Bounds;
}

/** Longitude and latitude of each vertex, the first one once more at the end. */
interface Ring {
  readonly vertices: Float64Array;
  readonly runs: readonly Run[];
}

interface Area {
  readonly rings: readonly Ring[];
  readonly bounds: Bounds;
}

/** The same as `Water` in `tiles/src/water.rs`, to the bit: both pass the tests of `tests/water/cases.json`. */
export class Water {
  private readonly areas: readonly Area[];

  constructor(polygons: readonly WaterPolygon[]) {
    this.areas = polygons.map((polygon) => {
      const rings = polygon.filter(({ length }) => length > 0).map(ringOf);
      return { rings, bounds: boundsAround(rings.flatMap(({ runs }) => runs.map(({ bounds }) => bounds))) };
    });
  }

  /** A texel a cell, rows from the south, 255 where the cell's middle is water; undefined where no middle is. */
  texels(tile: Bounds): Uint8Array<ArrayBuffer> | undefined {
    const texels = new Uint8Array(WATER_CELLS * WATER_CELLS);
    for (const turn of [-360, 0, 360]) {
      const [west, east] = [tile[0] + turn, tile[2] + turn];
      for (const { rings, bounds } of this.areas) {
        const isApart = bounds[0] > east || bounds[2] < west || bounds[1] > tile[3] || bounds[3] < tile[1];
        if (!isApart) fill(texels, rings, bounds, [west, tile[1], east, tile[3]]);
      }
    }
    return texels.includes(255) ? texels : undefined;
  }
}

function ringOf(places: WaterPolygon[number]): Ring {
  const vertices = new Float64Array(2 * places.length + 2);
  const runs: Run[] = [];
  for (let first = 0; first < places.length; first += RUN) {
    const last = Math.min(first + RUN, places.length);
    let [west, south, east, north] = [Infinity, Infinity, -Infinity, -Infinity];
    for (let at = first; at <= last; at++) {
      const [x, y] = places[at % places.length]!;
      vertices[2 * at] = x;
      vertices[2 * at + 1] = y;
      west = Math.min(west, x);
      south = Math.min(south, y);
      east = Math.max(east, x);
      north = Math.max(north, y);
    }
    runs.push({ first, last, bounds: [west, south, east, north] });
  }
  return { vertices, runs };
}

function boundsAround(boxes: readonly Bounds[]): Bounds {
  const least = (side: number) => boxes.reduce((least, box) => Math.min(least, box[side]!), Infinity);
  const most = (side: number) => boxes.reduce((most, box) => Math.max(most, box[side]!), -Infinity);
  return [least(0), least(1), most(2), most(3)];
}

/** Row by row, between every first and second crossing of a ring with the line through the middles of the row's cells. */
function fill(texels: Uint8Array, rings: readonly Ring[], bounds: Bounds, [west, south, east, north]: Bounds): void {
  const [cellsAcross, cellsDown] = [WATER_CELLS / (east - west), WATER_CELLS / (north - south)];
  // Cells from the west and from the north, whose middles are at whole numbers.
  const columnOf = (longitude: number) => (longitude - west) * cellsAcross - 0.5;
  const rowOf = (latitude: number) => (north - latitude) * cellsDown - 0.5;
  const clampedRow = (row: number) => Math.min(Math.max(Math.ceil(row), 0), WATER_CELLS);
  const [firstRow, endRow] = [clampedRow(rowOf(bounds[3])), clampedRow(rowOf(bounds[1]))];
  if (firstRow === endRow) return;
  const crossings: number[][] = Array.from({ length: endRow - firstRow }, () => []);
  for (const { vertices, runs } of rings) {
    for (const { first, last, bounds } of runs) {
      if (clampedRow(rowOf(bounds[3])) === clampedRow(rowOf(bounds[1]))) continue;
      // Beside the tile it only matters whether a row is crossed an odd number of times, as it is by one edge from end to end.
      const step = bounds[2] < west || bounds[0] > east ? last - first : 1;
      let [column, row] = [columnOf(vertices[2 * first]!), rowOf(vertices[2 * first + 1]!)];
      for (let at = first + step; at <= last; at += step) {
        const [nextColumn, nextRow] = [columnOf(vertices[2 * at]!), rowOf(vertices[2 * at + 1]!)];
        const end = clampedRow(Math.max(row, nextRow));
        for (let crossed = clampedRow(Math.min(row, nextRow)); crossed < end; crossed++) {
          crossings[crossed - firstRow]!.push(column + ((nextColumn - column) * (crossed - row)) / (nextRow - row));
        }
        [column, row] = [nextColumn, nextRow];
      }
    }
  }
  for (const [index, places] of crossings.entries()) {
    places.sort((a, b) => a - b);
    const start = (WATER_CELLS - 1 - firstRow - index) * WATER_CELLS;
    for (let at = 0; at + 1 < places.length; at += 2) {
      const [from, to] = [Math.max(0, Math.ceil(places[at]!)), Math.min(WATER_CELLS, Math.ceil(places[at + 1]!))];
      if (from < to) texels.fill(255, start + from, start + to);
    }
  }
}
