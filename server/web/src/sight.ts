// From where a scene is seen: what is in sight, and how large errors look. The same arithmetic, in the same order, as
// core/src/selection/camera.rs.

import type { Vector3 } from "three";
import { reachOf, type OrientedBox } from "./oriented_box.ts";

/** The side of a plane where `normal · point + constant` is not negative. */
export interface HalfSpace {
  readonly normal: Vector3;
  readonly constant: number;
}

/** An ellipsoid of revolution that nothing can be seen through. */
export interface Ellipsoid {
  readonly centre: Vector3;
  /** Unit vector along the axis that it turns about. */
  readonly axis: Vector3;
  /** Semi-axes across and along it. */
  readonly equatorial: number;
  readonly polar: number;
}

/** From where, and how, a scene is looked at; all lengths in one unit. */
export interface Camera {
  readonly eye: Vector3;
  /** What is in all of them is in the picture. */
  readonly frustum: readonly HalfSpace[];
  /** Viewport height / (2 · tan(fov / 2)): pixels of what is as large as it is far; times any exaggeration. */
  readonly pixelsPerRadian: number;
  /** Errors that are further away look as large as from here; infinite where they may look as small as they are. */
  readonly farthest: number;
  /** Hides what is beyond its horizon. No drawn surface may be below it. */
  readonly ground: Ellipsoid | undefined;
}

/** Pixels that an error covers at most at a distance. */
export function screenSpaceError(error: number, distance: number, { pixelsPerRadian, farthest }: Camera): number {
  return error === 0 ? 0 : (error * pixelsPerRadian) / Math.min(distance, farthest);
}

/** What a camera sees. */
export class Sight {
  private readonly horizon: Horizon | undefined;

  constructor(private readonly camera: Camera) {
    const horizon = camera.ground && new Horizon(camera.ground, camera.eye);
    this.horizon = horizon?.isAbove === true ? horizon : undefined;
  }

  /** Whether some point of a box may be seen: no half space of the frustum is without it, and not all is beyond the horizon. */
  sees(box: OrientedBox): boolean {
    const isOutside = ({ normal, constant }: HalfSpace) => normal.dot(box.centre) + constant + reachOf(box, normal) < 0;
    return !this.camera.frustum.some(isOutside) && this.horizon?.hides(box) !== true;
  }
}

/**
 * The horizon of an eye over an ellipsoid, in a space where this is the unit ball (Cozzi and Ring, 3D Engine Design for
 * Virtual Globes, 2011, section 12.3). What the ball hides holds the part of the cone of its tangents that is beyond the
 * plane of the horizon. That part is convex: it has all of a box if it has the box's corners.
 */
class Horizon {
  private readonly eye: Vector3;
  /** Square of the distance from the eye to its horizon. */
  private readonly squared: number;

  constructor(
    private readonly ellipsoid: Ellipsoid,
    eye: Vector3,
  ) {
    this.eye = toBall(ellipsoid, eye.clone().sub(ellipsoid.centre));
    this.squared = this.eye.dot(this.eye) - 1;
  }

  get isAbove(): boolean {
    return this.squared > 0;
  }

  /** Whether the whole box is hidden. */
  hides({ centre, axes, halfSizes }: OrientedBox): boolean {
    const ray = toBall(this.ellipsoid, centre.clone().sub(this.ellipsoid.centre)).sub(this.eye);
    const half = (k: 0 | 1 | 2) => toBall(this.ellipsoid, axes[k].clone().multiplyScalar(halfSizes[k]));
    const [x, y, z] = [half(0), half(1), half(2)];
    const corner = (bits: number) =>
      [x, y, z].reduce((sum, part, k) => (((bits >> k) & 1) === 1 ? sum.add(part) : sum.sub(part)), ray.clone());
    return [0, 1, 2, 3, 4, 5, 6, 7].every((bits) => this.hidesRay(corner(bits)));
  }

  /** Of a point, seen from the eye. */
  private hidesRay(ray: Vector3): boolean {
    const inwards = -ray.dot(this.eye);
    return inwards > this.squared && inwards * inwards > this.squared * ray.dot(ray);
  }
}

function toBall({ axis, equatorial, polar }: Ellipsoid, offset: Vector3): Vector3 {
  const along = offset.dot(axis);
  const across = offset.clone().sub(axis.clone().multiplyScalar(along));
  return across.multiplyScalar(1 / equatorial).add(axis.clone().multiplyScalar(along * (1 / polar)));
}
