// Free flight: WASD moves, Q and E sink and climb, dragging looks around, the wheel changes the speed. One finger looks around, too;
// two take hold of the ground and move it, and fly on as they part.

import * as THREE from "three";
import { isTyping } from "./keys.ts";

const RADIANS_PER_PIXEL = 0.004;
const STEEPEST = Math.PI / 2 - 0.05;
const SPEED_RANGE = [0.02, 50] as const;
/** Of flight, for each pixel that two fingers go. */
const SECONDS_PER_PIXEL = 0.008;
const FASTER_WITH_SHIFT = 4;

/** Direction of each key in the camera's axes: right, forward, and up in the scene. */
const DIRECTIONS: Readonly<Record<string, readonly [number, number, number]>> = {
  KeyW: [0, 1, 0],
  KeyS: [0, -1, 0],
  KeyA: [-1, 0, 0],
  KeyD: [1, 0, 0],
  KeyQ: [0, 0, -1],
  KeyE: [0, 0, 1],
};

/** Moves a camera whose scene has z up. */
export class FlyControls {
  enabled = false;
  private readonly pressed = new Set<string>();
  /** Where fingers are, in pixels, by the numbers of their pointers. */
  private readonly fingers = new Map<number, THREE.Vector2>();
  /** Seconds of flight to the right, forward and up that fingers ask for. */
  private readonly asked = new THREE.Vector3();
  private speedFactor = 1;

  /** `onChange` is called when input arrives that will move the camera. */
  constructor(
    private readonly camera: THREE.Camera,
    element: HTMLElement,
    private readonly onChange: () => void,
  ) {
    element.addEventListener("pointerdown", (event) => event.pointerType !== "mouse" && this.fingers.set(event.pointerId, placeOf(event)));
    element.addEventListener("pointermove", (event) => {
      if (event.pointerType !== "mouse") this.moveFinger(event);
      else if (event.buttons === 1) this.look(event.movementX, event.movementY);
    });
    for (const type of ["pointerup", "pointercancel"] as const) element.addEventListener(type, ({ pointerId }) => this.fingers.delete(pointerId));
    element.addEventListener("wheel", (event) => this.enabled && this.changeSpeed(event.deltaY), { passive: true });
    window.addEventListener("keydown", (event) => this.press(event));
    window.addEventListener("keyup", (event) => this.pressed.delete(event.code));
    window.addEventListener("blur", () => this.pressed.clear());
  }

  /** Moves on for some seconds at `speed` metres a second; tells whether the camera moved. */
  update(seconds: number, speed: number): boolean {
    if (!this.enabled) return false;
    const step = new THREE.Vector3();
    for (const key of this.pressed) step.add(new THREE.Vector3(...(DIRECTIONS[key] ?? [0, 0, 0])));
    const isFast = this.pressed.has("ShiftLeft") || this.pressed.has("ShiftRight");
    step.multiplyScalar(seconds * (isFast ? FASTER_WITH_SHIFT : 1)).add(this.asked);
    this.asked.set(0, 0, 0);
    if (step.lengthSq() === 0) return false;
    step.multiplyScalar(speed * this.speedFactor);
    const move = new THREE.Vector3(step.x, 0, -step.y).applyQuaternion(this.camera.quaternion);
    this.camera.position.add(move).z += step.z;
    return true;
  }

  private press(event: KeyboardEvent): void {
    if (!this.enabled || isTyping(event) || event.ctrlKey || event.metaKey) return;
    this.pressed.add(event.code);
    this.onChange();
  }

  private moveFinger(event: PointerEvent): void {
    const [before, now] = [this.fingers.get(event.pointerId), placeOf(event)];
    if (before === undefined) return;
    this.fingers.set(event.pointerId, now);
    const [other, more] = [...this.fingers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    const way = now.clone().sub(before);
    if (other === undefined) this.look(way.x, way.y);
    else if (more === undefined) this.moveBy(way.divideScalar(2), now.distanceTo(other) - before.distanceTo(other));
  }

  /** What two fingers hold goes with their middle, and comes nearer as they part. */
  private moveBy(middle: THREE.Vector2, apart: number): void {
    if (!this.enabled) return;
    this.asked.add(new THREE.Vector3(-middle.x, apart, middle.y).multiplyScalar(SECONDS_PER_PIXEL));
    this.onChange();
  }

  private look(right: number, down: number): void {
    if (!this.enabled) return;
    const angles = new THREE.Euler().setFromQuaternion(this.camera.quaternion, "ZXY");
    angles.z += right * RADIANS_PER_PIXEL;
    // In this order x is the angle up from straight down.
    const pitch = angles.x + down * RADIANS_PER_PIXEL;
    angles.x = THREE.MathUtils.clamp(pitch, Math.PI / 2 - STEEPEST, Math.PI / 2 + STEEPEST);
    angles.y = 0;
    this.camera.quaternion.setFromEuler(angles);
    this.onChange();
  }

  private changeSpeed(wheel: number): void {
    this.speedFactor = THREE.MathUtils.clamp(this.speedFactor * Math.exp(-wheel / 800), ...SPEED_RANGE);
  }
}

function placeOf({ clientX, clientY }: PointerEvent): THREE.Vector2 {
  return new THREE.Vector2(clientX, clientY);
}
