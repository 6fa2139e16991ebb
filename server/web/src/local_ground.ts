// Ground that is nowhere on the Earth: metres on a plane, which terrain-ingest lays on the ellipsoid around 0° N, 0° E by a transverse
// Mercator projection.

import proj4 from "proj4";
import type { Coordinates, Place } from "./coordinates.ts";

const PLANE = proj4("+proj=tmerc +lat_0=0 +lon_0=0 +k=1 +x_0=0 +y_0=0 +ellps=WGS84 +units=m +no_defs");

/** Metres on the plane. */
export const PLANE_METRES: Coordinates = {
  isLocal: true,
  columns: ["x_m", "y_m"],
  decimals: 3,
  numbersOf: metresOf,
  placeOf: degreesOf,
  textOf: (place) => {
    const [x, y] = metresOf(place);
    return `x ${x.toFixed(2)} m, y ${y.toFixed(2)} m`;
  },
  way: (from, to) => {
    const [[fromX, fromY], [toX, toY]] = [metresOf(from), metresOf(to)];
    const length = Math.hypot(toX - fromX, toY - fromY);
    const at = (metres: number) => {
      const share = length === 0 ? 0 : metres / length;
      return degreesOf([fromX + (toX - fromX) * share, fromY + (toY - fromY) * share]);
    };
    return { length, at };
  },
  area: (corners) => {
    const points = corners.map(metresOf);
    const twice = points.reduce((sum, [x, y], at) => {
      const [nextX, nextY] = points[(at + 1) % points.length]!;
      return sum + x * nextY - nextX * y;
    }, 0);
    return Math.abs(twice) / 2;
  },
};

function metresOf({ longitude, latitude }: Place): readonly [number, number] {
  return PLANE.forward([longitude, latitude]) as [number, number];
}

function degreesOf([x, y]: readonly [number, number]): Place {
  const [longitude, latitude] = PLANE.inverse([x, y]) as [number, number];
  return { longitude, latitude };
}
