// The scene, the camera and the loop. Draws only when something has changed.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { fitToCanvas } from "./canvas.ts";
import { FlyControls } from "./fly_controls.ts";
import type { View } from "./select.ts";
import { SKY_FRAGMENT, SKY_VERTEX } from "./shaders.ts";
import { TerrainLayer, type Stats } from "./terrain_layer.ts";
import type { Tileset } from "./tileset.ts";

const FIELD_OF_VIEW_DEGREES = 45;
/** Of the first view: looking north-north-west, this far down. */
const FIRST_VIEW = { azimuthDegrees: 335, downDegrees: 32, fill: 0.8 };
const LONGEST_STEP_SECONDS = 0.1;

/** Shows one tileset at a time on a canvas. */
export class Viewer {
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW_DEGREES, 1, 1, 1e8);
  private readonly orbit: OrbitControls;
  private readonly fly: FlyControls;
  private layer: TerrainLayer | undefined;
  private maxPixels = 2;
  private exaggeration = 1;
  private wireframe = false;
  private needsFrame = true;
  private lastFrame = 0;
  private waiting: (() => void)[] = [];

  /** `onFrame` is called after each frame that was drawn. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly onFrame: () => void,
  ) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, logarithmicDepthBuffer: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.camera.up.set(0, 0, 1);
    this.scene.add(skyMesh());
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.maxPolarAngle = THREE.MathUtils.degToRad(89);
    this.orbit.zoomToCursor = true;
    this.orbit.addEventListener("change", () => this.moved());
    this.fly = new FlyControls(this.camera, canvas, () => this.moved());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.renderer.setAnimationLoop((now) => this.frame(now));
  }

  /** Replaces what is shown and looks at all of it from the south. */
  open(tileset: Tileset): void {
    if (this.layer !== undefined) this.scene.remove(this.layer.group);
    this.layer?.dispose();
    this.layer = new TerrainLayer(tileset, () => this.redraw());
    this.layer.uniforms.exaggeration.value = this.exaggeration;
    this.layer.setWireframe(this.wireframe);
    this.scene.add(this.layer.group);
    this.lookAtAll();
  }

  /** Frames the bounds of the data obliquely. */
  lookAtAll(): void {
    if (this.layer === undefined) return;
    const box = this.layer.box;
    const [size, target] = [box.getSize(new THREE.Vector3()), box.getCenter(new THREE.Vector3())];
    const radius = Math.hypot(size.x, size.y) / 2;
    const distance = (FIRST_VIEW.fill * radius) / Math.tan(THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEGREES / 2));
    this.orbit.maxDistance = 20 * radius;
    this.place(target, FIRST_VIEW.azimuthDegrees, FIRST_VIEW.downDegrees, distance);
  }

  /** Looks at a point on the ground (degrees, metres) from `distance` metres away. */
  flyTo(longitude: number, latitude: number, height: number, distance: number, azimuth = 335, down = 32): void {
    const target = this.layer?.frame.position(longitude, latitude, height);
    if (target !== undefined) this.place(target, azimuth, down, distance);
  }

  setMaxPixels(pixels: number): void {
    this.maxPixels = pixels;
    this.layer?.invalidate();
  }

  setExaggeration(factor: number): void {
    this.exaggeration = factor;
    if (this.layer !== undefined) this.layer.uniforms.exaggeration.value = factor;
    this.layer?.invalidate();
  }

  setWireframe(visible: boolean): void {
    this.wireframe = visible;
    this.layer?.setWireframe(visible);
  }

  /** Flying looks from where the orbit was; orbiting turns around what is in the middle of the view. */
  setFlying(flying: boolean): void {
    if (!flying && this.fly.enabled) {
      const distance = Math.max(this.camera.position.distanceTo(this.orbit.target), 1);
      this.camera.getWorldDirection(this.orbit.target).multiplyScalar(distance).add(this.camera.position);
    }
    this.fly.enabled = flying;
    this.orbit.enabled = !flying;
  }

  stats(): Stats | undefined {
    return this.layer?.stats();
  }

  get failure(): string | undefined {
    return this.layer?.failure;
  }

  /** Resolves once everything that the view needs is loaded and drawn. */
  settled(): Promise<void> {
    return new Promise((resolve) => {
      this.waiting.push(resolve);
      this.redraw();
    });
  }

  private redraw(): void {
    this.needsFrame = true;
  }

  private moved(): void {
    this.layer?.invalidate();
  }

  private place(target: THREE.Vector3, azimuthDegrees: number, downDegrees: number, distance: number): void {
    const [azimuth, down] = [azimuthDegrees, downDegrees].map(THREE.MathUtils.degToRad) as [number, number];
    const level = -Math.cos(down) * distance;
    const offset = new THREE.Vector3(level * Math.sin(azimuth), level * Math.cos(azimuth), Math.sin(down) * distance);
    this.camera.position.copy(target).add(offset);
    this.camera.lookAt(target);
    this.orbit.target.copy(target);
    this.orbit.update();
    this.moved();
  }

  private resize(): void {
    if (!fitToCanvas(this.renderer, this.camera, this.canvas)) return;
    this.moved();
    this.redraw();
  }

  private frame(now: number): void {
    const seconds = Math.min((now - this.lastFrame) / 1000, LONGEST_STEP_SECONDS);
    this.lastFrame = now;
    if (this.orbit.enabled) this.orbit.update();
    if (this.fly.update(seconds, this.flySpeed())) this.moved();
    if (!this.needsFrame) return;
    this.needsFrame = false;
    this.camera.updateMatrixWorld();
    this.layer?.update(this.view(), now);
    this.renderer.render(this.scene, this.camera);
    this.onFrame();
    if (this.layer?.isSettled === true) this.waiting.splice(0).forEach((resolve) => resolve());
  }

  /** Half the height over the lowest ground every second: calm near the ground, quick high above it. */
  private flySpeed(): number {
    const lowest = this.layer?.box.min.z ?? 0;
    return Math.max(20, (this.camera.position.z - lowest) / 2);
  }

  private view(): View {
    const toClip = this.camera.projectionMatrix.clone().multiply(this.camera.matrixWorldInverse);
    const frustum = new THREE.Frustum().setFromProjectionMatrix(toClip);
    const halfHeight = Math.tan(THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEGREES / 2));
    return {
      eye: this.camera.position,
      pixelsPerRadian: (this.exaggeration * this.renderer.domElement.height) / (2 * halfHeight),
      maxPixels: this.maxPixels,
      isVisible: (box) => frustum.intersectsBox(box),
    };
  }
}

function skyMesh(): THREE.Mesh {
  const geometry = new THREE.BufferGeometry().setIndex([0, 1, 2]);
  geometry.boundingSphere = new THREE.Sphere();
  const material = new THREE.ShaderMaterial({
    vertexShader: SKY_VERTEX,
    fragmentShader: SKY_FRAGMENT,
    depthTest: false,
    depthWrite: false,
  });
  const sky = new THREE.Mesh(geometry, material);
  sky.frustumCulled = false;
  sky.renderOrder = -1;
  return sky;
}
