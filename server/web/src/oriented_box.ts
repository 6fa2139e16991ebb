// Boxes that are turned in any way: how near they are, and how large they look. The same arithmetic, in the same order, as
// core/src/selection/oriented_box.rs.

import { Vector3 } from "three";

type Triple<T> = readonly [T, T, T];

/** All points whose offset from `centre` along each of three axes is at most its half size. */
export interface OrientedBox {
  readonly centre: Vector3;
  /** Unit vectors at right angles. */
  readonly axes: Triple<Vector3>;
  readonly halfSizes: Triple<number>;
}

/** The smallest box with these axes that holds some points, larger by `margin` in all directions. */
export function boxAround(axes: Triple<Vector3>, points: readonly Vector3[], margin: number): OrientedBox {
  const centre = new Vector3();
  const halfSizes = axes.map((axis) => {
    const along = points.map((point) => point.dot(axis));
    const [low, high] = [Math.min(...along), Math.max(...along)];
    centre.addScaledVector(axis, (low + high) / 2);
    return (high - low) / 2 + margin;
  });
  return { centre, axes, halfSizes: halfSizes as [number, number, number] };
}

/** The box, larger by `margin` in all directions. */
export function grown(box: OrientedBox, margin: number): OrientedBox {
  return { ...box, halfSizes: box.halfSizes.map((half) => half + margin) as [number, number, number] };
}

/** Distance of a point from the nearest point of a box; 0 inside. */
export function distanceTo(box: OrientedBox, point: Vector3): number {
  const offset = point.clone().sub(box.centre);
  const beyond = (k: 0 | 1 | 2) => Math.max(Math.abs(offset.dot(box.axes[k])) - box.halfSizes[k], 0);
  const [x, y, z] = [beyond(0), beyond(1), beyond(2)];
  return Math.sqrt(x * x + y * y + z * z);
}

/** How far a box reaches from its centre along a direction. */
export function reachOf(box: OrientedBox, direction: Vector3): number {
  const along = (k: 0 | 1 | 2) => Math.abs(direction.dot(box.axes[k])) * box.halfSizes[k];
  return along(0) + along(1) + along(2);
}

/**
 * Solid angle of a box for an eye outside it, steradians, as if all of it were as far as its centre: what parallel rays
 * see of it, by the square of the distance.
 */
export function solidAngle(box: OrientedBox, eye: Vector3): number {
  const ray = box.centre.clone().sub(eye);
  const [x, y, z] = box.halfSizes;
  const faces = [y * z, z * x, x * y] as const;
  const seen = (k: 0 | 1 | 2) => 4 * faces[k] * Math.abs(ray.dot(box.axes[k]));
  const squared = ray.dot(ray);
  return (seen(0) + seen(1) + seen(2)) / (squared * Math.sqrt(squared));
}
