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
  readonly vertexCount: number;
  readonly triangleCount: number;
}

/** Where a ray meets a surface: how far away, the height there, and whether that is in a triangle or only beside one. */
export interface Hit {
  readonly distance: number;
  readonly height: number;
  readonly isInside: boolean;
}

const up = new THREE.Vector3();

/** Moves a place so many metres away from the Earth's centre, and gives it back. */
export function raised(place: THREE.Vector3, earthCentre: THREE.Vector3, metres: number): THREE.Vector3 {
  return metres === 0 ? place : place.addScaledVector(up.subVectors(place, earthCentre).normalize(), metres);
}

/**
 * Where a ray first meets the surface, before `farthest`. Where it meets no triangle, they are wider by a share, the slack, of their
 * size (after Möller and Trumbore, 1997).
 */
export function firstHit(
  ray: THREE.Ray,
  surface: DrawnSurface,
  raise: (place: THREE.Vector3, height: number) => THREE.Vector3,
  farthest: number,
  slack: number,
): Hit | undefined {
  const { origin, direction } = ray;
  const { corners, texels, places, triangleCount } = surface;
  const a = new THREE.Vector3();
  const toB = new THREE.Vector3();
  const toC = new THREE.Vector3();
  const fromA = new THREE.Vector3();
  const across = new THREE.Vector3();
  const texelOf = (corner: number) => 4 * places[2 * corners[corner]!]!;
  const placeOf = (texel: number, place: THREE.Vector3) => raise(place.set(texels[texel]!, texels[texel + 1]!, texels[texel + 2]!), texels[texel + 3]!);
  const offsets = offsetsFrom(ray, surface, placeOf);
  let [inside, beside]: [Hit | undefined, Hit | undefined] = [undefined, undefined];
  for (let at = 0; at < 3 * triangleCount; at += 3) {
    if (isAside(offsets, corners, at, 0, slack) || isAside(offsets, corners, at, 1, slack)) continue;
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
    const isInside = b >= 0 && c >= 0 && b + c <= 1;
    if (!(distance >= 0 && distance < ((isInside ? inside : beside)?.distance ?? farthest))) continue;
    const height = texels[texelOf(at) + 3]!;
    const hit = { distance, height: height + b * (texels[texelOf(at + 1) + 3]! - height) + c * (texels[texelOf(at + 2) + 3]! - height), isInside };
    if (isInside) inside = hit;
    else beside = hit;
  }
  return inside ?? beside;
}

let scratch = new Float64Array(0);

/**
 * How far each vertex is from a ray in two directions across it: what leaves away nearly all triangles before they are looked at one by
 * one. The array is the same for all rays.
 */
function offsetsFrom({ origin, direction }: THREE.Ray, { places, vertexCount }: DrawnSurface, placeOf: (texel: number, place: THREE.Vector3) => THREE.Vector3): Float64Array {
  if (scratch.length < 2 * vertexCount) scratch = new Float64Array(4 * vertexCount);
  const flattest = Math.abs(direction.x) < 0.7 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
  const one = flattest.cross(direction).normalize();
  const other = one.clone().cross(direction);
  const [oneStart, otherStart] = [one.dot(origin), other.dot(origin)];
  const place = new THREE.Vector3();
  for (let vertex = 0; vertex < vertexCount; vertex++) {
    placeOf(4 * places[2 * vertex]!, place);
    scratch[2 * vertex] = one.dot(place) - oneStart;
    scratch[2 * vertex + 1] = other.dot(place) - otherStart;
  }
  return scratch;
}

/** Whether a triangle, wider by some shares of its size, is on one side of the ray. */
function isAside(offsets: Float64Array, corners: Uint32Array, at: number, direction: 0 | 1, slack: number): boolean {
  const a = offsets[2 * corners[at]! + direction]!;
  const b = offsets[2 * corners[at + 1]! + direction]!;
  const c = offsets[2 * corners[at + 2]! + direction]!;
  const low = a < b ? (a < c ? a : c) : b < c ? b : c;
  const high = a > b ? (a > c ? a : c) : b > c ? b : c;
  // Rounding is less than the billionth part.
  const margin = (4 * slack + 1e-9) * (high - low);
  return low > margin || high < -margin;
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
