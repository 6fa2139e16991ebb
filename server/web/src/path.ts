// Lengths and areas on the Earth, and heights along a path; geodesics are GeographicLib's (Karney 2013).

import geodesic from "geographiclib-geodesic";

const { WGS84 } = geodesic.Geodesic;

/** Degrees. */
export interface Place {
  readonly longitude: number;
  readonly latitude: number;
}

/** A place on the way, metres after its beginning. */
export interface Waypoint extends Place {
  readonly distance: number;
}

/** A place of a profile; without a height where no ground is drawn. */
export interface ProfilePoint extends Waypoint {
  /** Metres. */
  readonly height: number | undefined;
  /** Certified, metres; none where the ground was filled. */
  readonly error: number | undefined;
}

/** Metres of each part of a path, from corner to corner. */
export function lengths(corners: readonly Place[]): number[] {
  return corners.slice(1).map((to, at) => lineBetween(corners[at]!, to).s13);
}

/** Square metres inside a path that is closed from its last corner to its first. */
export function area(corners: readonly Place[]): number {
  const polygon = WGS84.Polygon(false);
  for (const { longitude, latitude } of corners) polygon.AddPoint(latitude, longitude);
  return Math.abs(polygon.Compute(false, true).area ?? 0);
}

/** So many places along a path, equally far apart, and its corners. */
export function along(corners: readonly Place[], count: number): Waypoint[] {
  const parts = lengths(corners);
  const total = parts.reduce((sum, part) => sum + part, 0);
  const start = corners[0];
  const places: Waypoint[] = start === undefined ? [] : [{ ...placeOf(start), distance: 0 }];
  let passed = 0;
  parts.forEach((length, part) => {
    const steps = Math.max(1, Math.round((count * length) / total));
    const line = lineBetween(corners[part]!, corners[part + 1]!);
    for (let step = 1; step <= steps; step++) {
      const { lat2, lon2 } = line.Position((length * step) / steps);
      places.push({ longitude: lon2!, latitude: lat2!, distance: passed + (length * step) / steps });
    }
    passed += length;
  });
  return places;
}

/** A table with one row a place. */
export function csvOf(profile: readonly ProfilePoint[]): string {
  const rows = profile.map(({ distance, longitude, latitude, height, error }) =>
    [
      distance.toFixed(2), longitude.toFixed(7), latitude.toFixed(7), height?.toFixed(2) ?? "", error === undefined ? "" : roundedUp(error),
      height === undefined ? "void" : error === undefined ? "filled" : "measured",
    ].join(","),
  );
  return ["distance_m,longitude,latitude,height_m,certified_error_m,status", ...rows, ""].join("\r\n");
}

/** The path as a line of three coordinates a place, and its figures. Places without ground are left out. */
export function geoJsonOf(profile: readonly ProfilePoint[], corners: readonly Place[], heightsAbove: string): string {
  const known = profile.filter(({ height }) => height !== undefined);
  const feature = {
    type: "Feature",
    geometry: {
      type: "LineString",
      coordinates: known.map(({ longitude, latitude, height }) => [round(longitude, 7), round(latitude, 7), round(height!, 2)]),
    },
    properties: {
      length_m: round(profile.at(-1)?.distance ?? 0, 2),
      ...(corners.length > 2 ? { area_m2: round(area(corners), 1) } : {}),
      heights_above: heightsAbove,
      certified_errors_m: known.map(({ error }) => (error === undefined ? null : Number(roundedUp(error)))),
    },
  };
  return JSON.stringify({ type: "FeatureCollection", features: [feature] }, undefined, 1);
}

const placeOf = ({ longitude, latitude }: Place): Place => ({ longitude, latitude });
const round = (value: number, digits: number) => Number(value.toFixed(digits));
/** An error is never told to be smaller than it is. */
const roundedUp = (metres: number) => (Math.ceil(metres * 100) / 100).toFixed(2);

function lineBetween(from: Place, to: Place) {
  return WGS84.InverseLine(from.latitude, from.longitude, to.latitude, to.longitude);
}
