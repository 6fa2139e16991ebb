// Heights along a path, and files of them.

import type { Coordinates, Place, Way } from "./coordinates.ts";

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

/** Metres from the first corner of a path to its last one. */
export function lengthOf(corners: readonly Place[], coordinates: Coordinates): number {
  return waysOf(corners, coordinates).reduce((sum, { length }) => sum + length, 0);
}

/** So many places along a path, equally far apart, and its corners. */
export function along(corners: readonly Place[], count: number, coordinates: Coordinates): Waypoint[] {
  const ways = waysOf(corners, coordinates);
  const total = ways.reduce((sum, { length }) => sum + length, 0);
  const start = corners[0];
  const places: Waypoint[] = start === undefined ? [] : [{ longitude: start.longitude, latitude: start.latitude, distance: 0 }];
  let passed = 0;
  for (const { length, at } of ways) {
    const steps = Math.max(1, Math.round((count * length) / total));
    for (let step = 1; step <= steps; step++) {
      const metres = (length * step) / steps;
      places.push({ ...at(metres), distance: passed + metres });
    }
    passed += length;
  }
  return places;
}

/** A table with one row a place. */
export function csvOf(profile: readonly ProfilePoint[], coordinates: Coordinates): string {
  const { columns, decimals } = coordinates;
  const rows = profile.map(({ distance, height, error, ...place }) =>
    [
      distance.toFixed(2), ...coordinates.numbersOf(place).map((number) => number.toFixed(decimals)), height?.toFixed(2) ?? "", error === undefined ? "" : roundedUp(error),
      height === undefined ? "void" : error === undefined ? "filled" : "measured",
    ].join(","),
  );
  return [`distance_m,${columns.join()},height_m,certified_error_m,status`, ...rows, ""].join("\r\n");
}

/** The path as a line of three coordinates a place, and its figures. Places without ground are left out. */
export function geoJsonOf(profile: readonly ProfilePoint[], corners: readonly Place[], heightsAbove: string, coordinates: Coordinates): string {
  const known = profile.filter(({ height }) => height !== undefined);
  const feature = {
    type: "Feature",
    geometry: {
      type: "LineString",
      coordinates: known.map((point) => [...coordinates.numbersOf(point).map((number) => round(number, coordinates.decimals)), round(point.height!, 2)]),
    },
    properties: {
      length_m: round(profile.at(-1)?.distance ?? 0, 2),
      ...(corners.length > 2 ? { area_m2: round(coordinates.area(corners), 1) } : {}),
      ...(coordinates.isLocal ? { coordinates: "metres on a plane" } : {}),
      heights_above: heightsAbove,
      certified_errors_m: known.map(({ error }) => (error === undefined ? null : Number(roundedUp(error)))),
    },
  };
  return JSON.stringify({ type: "FeatureCollection", features: [feature] }, undefined, 1);
}

const round = (value: number, digits: number) => Number(value.toFixed(digits));
/** An error is never told to be smaller than it is. */
const roundedUp = (metres: number) => (Math.ceil(metres * 100) / 100).toFixed(2);

function waysOf(corners: readonly Place[], coordinates: Coordinates): Way[] {
  return corners.slice(1).map((to, at) => coordinates.way(corners[at]!, to));
}
