// Places in the frame on the Earth, and where a ray meets the ground that is drawn.

import * as THREE from "three";
import type { Frame } from "./frame.ts";

/** Where a ray meets the ground. */
export interface GroundPoint {
  /** In the frame, exaggerated as it is drawn. */
  readonly position: THREE.Vector3;
  /** From where the ray begins, metres. */
  readonly distance: number;
  readonly longitude: number;
  readonly latitude: number;
  /** Metres, without exaggeration. */
  readonly height: number;
  /** Certified, metres; undefined where the source has a void that was filled: nothing is certified of that. */
  readonly error: number | undefined;
}

/** A surface as triangles: corners of triangles, four numbers a place (x, y, z and height), and of each vertex the place now and the one before. */
export interface DrawnSurface {
  readonly corners: Uint32Array;
  readonly texels: Float32Array;
  readonly places: Uint32Array;
  readonly triangleCount: number;
  /** Which triangles may be met; all, where this is not said. */
  readonly isCandidate?: (triangle: number) => boolean;
}

const up = new THREE.Vector3();

/** Moves a place so many metres away from the Earth's centre, and gives it back. */
export function raised(place: THREE.Vector3, earthCentre: THREE.Vector3, metres: number): THREE.Vector3 {
  return metres === 0 ? place : place.addScaledVector(up.subVectors(place, earthCentre).normalize(), metres);
}

/**
 * Where a ray first meets the surface, before `farthest`: how far away, and the height there. Triangles are wider by a share, the
 * slack, of their size (after Möller and Trumbore, 1997).
 */
export function firstHit(
  { origin, direction }: THREE.Ray,
  { corners, texels, places, triangleCount, isCandidate }: DrawnSurface,
  raise: (place: THREE.Vector3, height: number) => THREE.Vector3,
  farthest: number,
  slack: number,
): { distance: number; height: number } | undefined {
  const a = new THREE.Vector3();
  const toB = new THREE.Vector3();
  const toC = new THREE.Vector3();
  const fromA = new THREE.Vector3();
  const across = new THREE.Vector3();
  const texelOf = (corner: number) => 4 * places[2 * corners[corner]!]!;
  const placeOf = (texel: number, place: THREE.Vector3) => raise(place.set(texels[texel]!, texels[texel + 1]!, texels[texel + 2]!), texels[texel + 3]!);
  let found: { distance: number; height: number } | undefined;
  for (let at = 0; at < 3 * triangleCount; at += 3) {
    if (isCandidate?.(at / 3) === false) continue;
    placeOf(texelOf(at), a);
    placeOf(texelOf(at + 1), toB).sub(a);
    placeOf(texelOf(at + 2), toC).sub(a);
    across.crossVectors(direction, toC);
    const scale = 1 / toB.dot(across);
    const b = fromA.subVectors(origin, a).dot(across) * scale;
    if (!(b >= -slack && b <= 1 + slack)) continue;
    across.crossVectors(fromA, toB);
    const c = direction.dot(across) * scale;
    if (!(c >= -slack && b + c <= 1 + slack)) continue;
    const distance = toC.dot(across) * scale;
    if (!(distance >= 0 && distance < (found?.distance ?? farthest))) continue;
    const height = texels[texelOf(at) + 3]!;
    found = { distance, height: height + b * (texels[texelOf(at + 1) + 3]! - height) + c * (texels[texelOf(at + 2) + 3]! - height) };
  }
  return found;
}

/** Degrees of a place in a frame; after Bowring (1976), which near the ground is right to less than a millimetre. */
export function geographic(frame: Frame, position: THREE.Vector3): { longitude: number; latitude: number } {
  const [semiMajor, flattening] = [6378137, 1 / 298.257223563];
  const semiMinor = semiMajor * (1 - flattening);
  const squared = flattening * (2 - flattening);
  const { x, y, z } = frame.earthCentredOf(position);
  const horizontal = Math.hypot(x, y);
  const reduced = Math.atan2(z * semiMajor, horizontal * semiMinor);
  const up = z + (squared / (1 - squared)) * semiMinor * Math.sin(reduced) ** 3;
  const latitude = Math.atan2(up, horizontal - squared * semiMajor * Math.cos(reduced) ** 3);
  return { longitude: THREE.MathUtils.radToDeg(Math.atan2(y, x)), latitude: THREE.MathUtils.radToDeg(latitude) };
}
