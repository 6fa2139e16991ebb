// The page of curved models: opens a `.clod` file of the server or one that is dropped, and draws one of its levels.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { fitToCanvas } from "../canvas.ts";
import { readCurvedLevels } from "./clod.ts";
import { PatchLayer, type Drawn } from "./patch_layer.ts";

declare global {
  interface Window {
    /** For tests and the console. */
    curved: {
      drawn(): Drawn | undefined;
      open(bytes: ArrayBuffer, name: string): void;
      setLevel(level: number): void;
      nearer(factor: number): void;
      frame(): Promise<void>;
    };
  }
}

const FIELD_OF_VIEW_DEGREES = 35;
const PIXELS_OF_ERROR = 0.5;

function element<T extends HTMLElement>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`The page has no ${type.name} "${id}".`);
  return found;
}

const setText = (id: string, text: string) => (element(id, HTMLElement).textContent = text);

function showMessage(message: string | undefined): void {
  element("message", HTMLElement).hidden = message === undefined;
  setText("message", message ?? "");
}

class CurvedPage {
  private readonly canvas = element("view", HTMLCanvasElement);
  private readonly slider = element("level", HTMLInputElement);
  private readonly net = element("net", HTMLInputElement);
  private readonly renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true });
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW_DEGREES);
  private readonly orbit = new OrbitControls(this.camera, this.canvas);
  private layer: PatchLayer | undefined;
  private needsFrame = true;
  private waiting: (() => void)[] = [];

  constructor() {
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene.background = new THREE.Color().setHex(0xa9bccb, THREE.LinearSRGBColorSpace);
    this.orbit.addEventListener("change", () => (this.needsFrame = true));
    this.slider.addEventListener("input", () => this.setLevel(this.slider.valueAsNumber));
    this.net.addEventListener("input", () => {
      this.layer?.setNet(this.net.checked);
      this.needsFrame = true;
    });
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.renderer.setAnimationLoop(() => this.draw());
  }

  open(bytes: ArrayBuffer, name: string): void {
    const levels = readCurvedLevels(bytes);
    if (this.layer !== undefined) this.scene.remove(this.layer.group);
    this.layer?.dispose();
    this.layer = new PatchLayer(levels);
    this.layer.setNet(this.net.checked);
    this.scene.add(this.layer.group);
    setText("name", name);
    this.slider.max = String(levels.levelCount - 1);
    this.slider.value = this.slider.max;
    this.setLevel(levels.levelCount - 1);
    this.lookAtAll(this.layer.box);
    showMessage(undefined);
  }

  setLevel(level: number): void {
    this.slider.value = String(level);
    setText("level-value", `${level} of ${this.slider.max}`);
    this.layer?.setLevel(level);
    this.needsFrame = true;
  }

  drawn = () => this.layer?.drawn();

  /** Moves the camera so many times as near. */
  nearer(factor: number): void {
    this.camera.position.sub(this.orbit.target).divideScalar(factor).add(this.orbit.target);
    this.orbit.update();
    this.needsFrame = true;
  }

  /** Resolves when the next frame is drawn. */
  frame(): Promise<void> {
    this.needsFrame = true;
    return new Promise((resolve) => this.waiting.push(resolve));
  }

  private lookAtAll(box: THREE.Box3): void {
    const [centre, radius] = [box.getCenter(new THREE.Vector3()), box.getSize(new THREE.Vector3()).length() / 2];
    const distance = (1.05 * radius) / Math.sin(THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEGREES / 2));
    this.camera.near = distance / 1000;
    this.camera.far = distance * 10;
    this.camera.position.set(0.35, 0.4, 1).setLength(distance).add(centre);
    this.camera.updateProjectionMatrix();
    this.orbit.target.copy(centre);
    this.orbit.update();
  }

  private resize(): void {
    if (!fitToCanvas(this.renderer, this.camera, this.canvas)) return;
    this.needsFrame = true;
  }

  private draw(): void {
    this.orbit.update();
    if (!this.needsFrame) return;
    this.needsFrame = false;
    const { x, y, z } = this.camera.position;
    const halfHeight = Math.tan(THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEGREES / 2));
    const pixels = this.renderer.domElement.height / (2 * halfHeight);
    this.layer?.update({ eye: [x, y, z], pixels, maxPixels: PIXELS_OF_ERROR });
    this.renderer.render(this.scene, this.camera);
    const drawn = this.drawn();
    if (drawn !== undefined) {
      setText("patches", drawn.patches.toLocaleString("en"));
      setText("triangles", drawn.triangles.toLocaleString("en"));
      setText("error", drawn.error.toExponential(2));
    }
    this.waiting.splice(0).forEach((resolve) => resolve());
  }
}

async function fetched(name: string): Promise<ArrayBuffer> {
  const answer = await fetch(`${encodeURIComponent(name)}/curved.clod`);
  if (!answer.ok) throw new Error(`The server has no curved model “${name}”.`);
  return answer.arrayBuffer();
}

async function start(): Promise<void> {
  const page = new CurvedPage();
  window.curved = page;
  const say = (error: unknown) => showMessage(error instanceof Error ? error.message : String(error));
  window.addEventListener("dragover", (event) => event.preventDefault());
  window.addEventListener("drop", (event) => {
    event.preventDefault();
    const file = event.dataTransfer?.files[0];
    file?.arrayBuffer().then((bytes) => page.open(bytes, file.name)).catch(say);
  });
  const name = new URLSearchParams(location.search).get("model");
  if (name === null) showMessage("Drop a .clod file here.");
  else await fetched(name).then((bytes) => page.open(bytes, name)).catch(say);
}

void start();
