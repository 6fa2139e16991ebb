// A local east-north-up frame on WGS84, in metres, in which the whole scene is drawn.

import { Box3, Vector3 } from "three";
import { degreesOf, type Address } from "./address.ts";

/** Semi-major axis in metres and flattening (NIMA TR8350.2, table 3.1). */
const SEMI_MAJOR = 6378137;
const FLATTENING = 1 / 298.257223563;
const ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING);

/** West, south, east, north in degrees. */
export type Bounds = readonly [number, number, number, number];

/** A rigid motion of Earth-centred coordinates: x east, y north, z up at its origin on the ellipsoid. */
export class Frame {
  /** Direction of the Earth's axis, northwards, in this frame. */
  readonly axis: Vector3;
  /** The Earth's centre in this frame, metres. */
  readonly earthCentre: Vector3;
  private readonly origin: Vector3;
  private readonly east: Vector3;
  private readonly north: Vector3;
  private readonly up: Vector3;

  /** Longitude and latitude of the origin in degrees. */
  constructor(longitude: number, latitude: number) {
    this.origin = earthCentred(longitude, latitude, 0);
    this.up = normal(longitude, latitude);
    this.east = normal(longitude + 90, 0);
    this.north = this.up.clone().cross(this.east);
    this.axis = this.rotate(new Vector3(0, 0, 1));
    this.earthCentre = this.rotate(this.origin.clone().negate());
  }

  /** Degrees and metres above the ellipsoid to metres in this frame, in double precision. */
  position(longitude: number, latitude: number, height: number): Vector3 {
    return this.rotate(earthCentred(longitude, latitude, height).sub(this.origin));
  }

  /** Holds the part of the Earth's surface between two heights over `bounds`, bulge included. */
  box([west, south, east, north]: Bounds, heights: readonly [number, number]): Box3 {
    const box = new Box3();
    const steps = 8;
    for (let row = 0; row <= steps; row++) {
      for (let column = 0; column <= steps; column++) {
        const longitude = west + ((east - west) * column) / steps;
        const latitude = south + ((north - south) * row) / steps;
        for (const height of heights) box.expandByPoint(this.position(longitude, latitude, height));
      }
    }
    const halfCell = ((Math.PI / 180) * Math.max(east - west, north - south)) / steps / 2;
    return box.expandByScalar(SEMI_MAJOR * (1 - Math.cos(halfCell)));
  }

  /** The inverse of `position`, in Earth-centred metres. */
  earthCentredOf({ x, y, z }: Vector3): Vector3 {
    return this.origin.clone().addScaledVector(this.east, x).addScaledVector(this.north, y).addScaledVector(this.up, z);
  }

  private rotate(vector: Vector3): Vector3 {
    return new Vector3(this.east.dot(vector), this.north.dot(vector), this.up.dot(vector));
  }
}

/** West, south, east, north of a tile. */
export function tileBounds({ zoom, x, y }: Address): Bounds {
  const degrees = degreesOf(zoom);
  const [west, south] = [x * degrees - 180, y * degrees - 90];
  return [west, south, west + degrees, south + degrees];
}

/** The ellipsoid's outward normal at a longitude and latitude in degrees. */
function normal(longitude: number, latitude: number): Vector3 {
  const [lambda, phi] = [(longitude * Math.PI) / 180, (latitude * Math.PI) / 180];
  return new Vector3(Math.cos(phi) * Math.cos(lambda), Math.cos(phi) * Math.sin(lambda), Math.sin(phi));
}

function earthCentred(longitude: number, latitude: number, height: number): Vector3 {
  const up = normal(longitude, latitude);
  const primeVertical = SEMI_MAJOR / Math.sqrt(1 - ECCENTRICITY_SQUARED * up.z * up.z);
  const horizontal = primeVertical + height;
  const polar = primeVertical * (1 - ECCENTRICITY_SQUARED) + height;
  return new Vector3(horizontal * up.x, horizontal * up.y, polar * up.z);
}
