// A flat Earth to select tiles of, and views of it.

import { Vector3 } from "three";
import { degreesOf, type Address } from "../src/address.ts";
import type { Demand, Hierarchy } from "../src/select.ts";
import type { Camera } from "../src/sight.ts";
import type { Pyramid } from "./grid_pyramid.ts";

export const PYRAMID: Pyramid = {
  leafZoom: 6,
  cells: 4,
  leafError: 1,
  // The same at both ends of the antimeridian.
  height: (longitude, latitude) => 40 * Math.sin((longitude * Math.PI) / 20) * Math.cos(1.7 * latitude),
};

export const AXES = [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1)] as const;

/** A flat Earth of one metre a degree, all of whose tiles exist. West of the middle, errors are `calm` times those of the east. */
export function flatEarth(calm = 1, levelsThere: Hierarchy["levelsThere"] = () => Infinity): Hierarchy {
  const roughness = ({ zoom, x }: Address) => (x < 2 ** zoom ? calm : 1);
  return {
    roots: [0, 1].map((x) => ({ zoom: 0, x, y: 0 })),
    exists: ({ zoom }) => zoom <= PYRAMID.leafZoom,
    levelsThere: (tile) => (tile.zoom <= PYRAMID.leafZoom ? levelsThere(tile) : 0),
    bounds: ({ zoom, x, y }) => {
      const half = degreesOf(zoom) / 2;
      return { centre: new Vector3((2 * x + 1) * half, (2 * y + 1) * half, 0), axes: AXES, halfSizes: [half, half, 0] };
    },
    levels: (tile) => {
      const finest = roughness(tile) * 2 ** (PYRAMID.leafZoom - tile.zoom);
      return [2, 1.5, 1].map((factor, level) => ({ error: factor * finest, triangles: 8 << level, bytes: 1000 }));
    },
  };
}

export interface View {
  camera: Camera;
  demand: Demand;
}

export function viewFrom(x: number, y: number, z: number, tolerance = 2): View {
  return {
    camera: { eye: new Vector3(x, y, z), pixelsPerRadian: 10, farthest: Infinity, frustum: [], ground: undefined },
    demand: { tolerance, keep: 1, triangles: Infinity, bytes: Infinity },
  };
}
