// How a view is turned: as angles, and as directions.

import * as THREE from "three";
import type { Frame } from "./frame.ts";

/**
 * Degrees from north to the east, down from the level, and that the picture is turned to the right from upright. Where one looks straight
 * down, the azimuth is that of the picture's up. Without a roll, the picture is as upright as what turns it lets it be.
 */
export interface Turn {
  readonly azimuth: number;
  readonly down: number;
  readonly roll?: number;
}

/** Where a view is, degrees and metres of the eye, and how it is turned there. */
export interface Pose extends Turn {
  readonly longitude: number;
  readonly latitude: number;
  readonly height: number;
}

/** Directions to the east, to the north and upwards. */
export type Axes = ReturnType<Frame["axesAt"]>;

/** Where one looks, and what is to the right in the picture. */
export interface Look {
  readonly ahead: THREE.Vector3;
  readonly right: THREE.Vector3;
}

/** So near to straight down or up, in degrees, what is ahead does not tell where to. */
const STRAIGHT = 0.005;

export function lookOf({ azimuth, down, roll = 0 }: Turn, { east, north, up }: Axes): Look {
  const [turn, dip, bank] = [azimuth, down, roll].map(THREE.MathUtils.degToRad) as [number, number, number];
  const onLevel = east.clone().multiplyScalar(Math.sin(turn)).addScaledVector(north, Math.cos(turn));
  const ahead = onLevel.clone().multiplyScalar(Math.cos(dip)).addScaledVector(up, -Math.sin(dip));
  const right = onLevel.cross(up);
  const upright = right.clone().cross(ahead);
  return { ahead, right: right.multiplyScalar(Math.cos(bank)).addScaledVector(upright, -Math.sin(bank)) };
}

export function turnOf({ ahead, right }: Look, axes: Axes): Required<Turn> {
  const down = THREE.MathUtils.radToDeg(Math.asin(THREE.MathUtils.clamp(-ahead.dot(axes.up), -1, 1)));
  const isStraight = Math.abs(down) > 90 - STRAIGHT;
  const azimuth = isStraight ? bearingOf({ right }, axes) : azimuthOf(ahead, axes);
  const upright = lookOf({ azimuth, down }, axes).right;
  const roll = THREE.MathUtils.radToDeg(Math.atan2(-right.dot(upright.clone().cross(ahead)), right.dot(upright)));
  return { azimuth, down, roll };
}

/** Degrees from north to the east of what is upwards in the picture of level ground. */
export function bearingOf({ right }: Pick<Look, "right">, axes: Axes): number {
  return azimuthOf(axes.up.clone().cross(right), axes);
}

function azimuthOf(direction: THREE.Vector3, { east, north }: Axes): number {
  return (THREE.MathUtils.radToDeg(Math.atan2(direction.dot(east), direction.dot(north))) + 360) % 360;
}
