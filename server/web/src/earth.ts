// Places on the Earth; geodesics are GeographicLib's (Karney 2013).

import geodesic from "geographiclib-geodesic";
import type { Coordinates, Place } from "./coordinates.ts";

const { WGS84 } = geodesic.Geodesic;

/** Degrees from north to the east, from -180 to 180, in which the geodesic to another place begins. */
export function azimuthOf(from: Place, to: Place): number {
  return WGS84.Inverse(from.latitude, from.longitude, to.latitude, to.longitude).azi1!;
}

/** Degrees, and geodesics on the ellipsoid. */
export const EARTH: Coordinates = {
  isLocal: false,
  columns: ["longitude", "latitude"],
  decimals: 7,
  numbersOf: ({ longitude, latitude }) => [longitude, latitude],
  placeOf: ([longitude, latitude]) => ({ longitude, latitude }),
  textOf: ({ longitude, latitude }) =>
    `${Math.abs(latitude).toFixed(5)}° ${latitude < 0 ? "S" : "N"}, ${Math.abs(longitude).toFixed(5)}° ${longitude < 0 ? "W" : "E"}`,
  way: (from, to) => {
    const line = WGS84.InverseLine(from.latitude, from.longitude, to.latitude, to.longitude);
    const at = (metres: number): Place => {
      const { lat2, lon2 } = line.Position(metres);
      return { longitude: lon2!, latitude: lat2! };
    };
    return { length: line.s13, at };
  },
  area: (corners) => {
    const polygon = WGS84.Polygon(false);
    for (const { longitude, latitude } of corners) polygon.AddPoint(latitude, longitude);
    return Math.abs(polygon.Compute(false, true).area ?? 0);
  },
};
