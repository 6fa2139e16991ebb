import type * as THREE from "three";

/** Pixels that a pointer may move in a click. */
const CLICK_PIXELS = 4;

/** Calls `act` with where a canvas is clicked, from -1 to 1 to the right and upwards; what is dragged is not clicked. */
export function onClick(canvas: HTMLCanvasElement, act: (x: number, y: number) => void): void {
  let pressedAt: readonly [number, number] | undefined;
  canvas.addEventListener("pointerdown", (event) => (pressedAt = event.button === 0 ? [event.clientX, event.clientY] : undefined));
  canvas.addEventListener("pointerup", ({ clientX, clientY, offsetX, offsetY }) => {
    const [x, y] = pressedAt ?? [Infinity, Infinity];
    if (Math.hypot(clientX - x, clientY - y) <= CLICK_PIXELS) act((2 * offsetX) / canvas.clientWidth - 1, 1 - (2 * offsetY) / canvas.clientHeight);
  });
}

/** Fits a picture to its canvas; false while the canvas has no size. */
export function fitToCanvas(renderer: THREE.WebGLRenderer, camera: THREE.PerspectiveCamera, canvas: HTMLCanvasElement): boolean {
  const { clientWidth, clientHeight } = canvas;
  if (clientWidth === 0 || clientHeight === 0) return false;
  renderer.setSize(clientWidth, clientHeight, false);
  camera.aspect = clientWidth / clientHeight;
  camera.updateProjectionMatrix();
  return true;
}
