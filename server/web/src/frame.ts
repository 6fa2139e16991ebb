// A local east-north-up frame on WGS84, in metres, in which the whole scene is drawn.

import { Box3, Matrix4, Vector3 } from "three";
import { degreesOf, type Address } from "./address.ts";
import { boxAround, type OrientedBox } from "./oriented_box.ts";
import type { Ellipsoid } from "./sight.ts";

/** Semi-major axis in metres and flattening (NIMA TR8350.2, table 3.1). */
const SEMI_MAJOR = 6378137;
const FLATTENING = 1 / 298.257223563;
const ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING);

/** Cells along a side of the grid that boxes are made around. */
const GRID_STEPS = 8;

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

  /** Directions to the east, to the north and upwards at a longitude and latitude. */
  axesAt(longitude: number, latitude: number): { east: Vector3; north: Vector3; up: Vector3 } {
    const [east, up] = [this.rotate(normal(longitude + 90, 0)), this.rotate(normal(longitude, latitude))];
    return { east, north: up.clone().cross(east), up };
  }

  /** Holds the part of the Earth's surface between two heights over `bounds`, bulge included. */
  box(bounds: Bounds, heights: readonly [number, number]): Box3 {
    return new Box3().setFromPoints(this.gridOver(bounds, heights)).expandByScalar(bulgeOver(bounds));
  }

  /** The same as a box along east, north and up in the middle of `bounds`. */
  orientedBox(bounds: Bounds, heights: readonly [number, number]): OrientedBox {
    const [longitude, latitude] = [(bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2];
    const [east, up] = [normal(longitude + 90, 0), normal(longitude, latitude)].map((axis) => this.rotate(axis));
    const axes = [east!, up!.clone().cross(east!), up!] as const;
    return boxAround(axes, this.gridOver(bounds, heights), bulgeOver(bounds));
  }

  /** The ellipsoid whose semi-axes are longer than the Earth's by a height. */
  ellipsoid(height: number): Ellipsoid {
    const [equatorial, polar] = [SEMI_MAJOR, SEMI_MAJOR * (1 - FLATTENING)].map((axis) => axis + height);
    return { centre: this.earthCentre, axis: this.axis, equatorial: equatorial!, polar: polar! };
  }

  /** The inverse of `position`, in Earth-centred metres. */
  earthCentredOf({ x, y, z }: Vector3): Vector3 {
    return this.origin.clone().addScaledVector(this.east, x).addScaledVector(this.north, y).addScaledVector(this.up, z);
  }

  /** From metres in this frame to metres in another one. */
  matrixTo(other: Frame): Matrix4 {
    const [x, y, z] = [this.east, this.north, this.up].map((axis) => other.rotate(axis));
    const origin = other.rotate(this.origin.clone().sub(other.origin));
    return new Matrix4().makeBasis(x!, y!, z!).setPosition(origin);
  }

  private gridOver([west, south, east, north]: Bounds, heights: readonly [number, number]): Vector3[] {
    const shares = Array.from({ length: GRID_STEPS + 1 }, (_, step) => step / GRID_STEPS);
    return shares.flatMap((row) =>
      shares.flatMap((column) =>
        heights.map((height) => this.position(west + (east - west) * column, south + (north - south) * row, height)),
      ),
    );
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

/** How far the Earth's surface is beyond the points of a grid over `bounds`, metres. */
function bulgeOver([west, south, east, north]: Bounds): number {
  const halfCell = ((Math.PI / 180) * Math.max(east - west, north - south)) / GRID_STEPS / 2;
  return SEMI_MAJOR * (1 - Math.cos(halfCell));
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
