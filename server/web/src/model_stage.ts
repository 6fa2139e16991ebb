// What the pages of models share: a canvas with a camera that orbits a model, and where the model comes from.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { fitToCanvas } from "./canvas.ts";
import { element, setText } from "./elements.ts";

const FIELD_OF_VIEW_DEGREES = 35;
/** Pixels that an arrow key moves the view, and how much nearer + brings it. */
const [KEY_PIXELS, KEY_ZOOM] = [40, 0.8];
/** What is read of a file at most. */
const MOST_BYTES = 1 << 28;

/** A scene on a canvas, drawn when something in it has changed. */
export class ModelStage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW_DEGREES);
  private readonly canvas = element("view", HTMLCanvasElement);
  private readonly renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
  private readonly orbit = new OrbitControls(this.camera, this.canvas);
  private needsFrame = true;
  private waiting: (() => void)[] = [];

  /** `beforeFrame` is called before each frame, with how many pixels a length of 1 has at a distance of 1. */
  constructor(private readonly beforeFrame: (pixels: number) => void) {
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.orbit.keyPanSpeed = KEY_PIXELS;
    this.orbit.listenToKeyEvents(this.canvas);
    this.orbit.addEventListener("change", () => this.redraw());
    this.canvas.addEventListener("pointerdown", () => this.canvas.focus());
    this.canvas.addEventListener("keydown", ({ key }) => {
      if (key === "+" || key === "=") this.orbit.dollyIn(KEY_ZOOM);
      if (key === "-") this.orbit.dollyOut(KEY_ZOOM);
    });
    new ResizeObserver(() => fitToCanvas(this.renderer, this.camera, this.canvas) && this.redraw()).observe(this.canvas);
    this.renderer.setAnimationLoop(() => this.draw());
  }

  redraw(): void {
    this.needsFrame = true;
  }

  /** Resolves when the next frame is drawn. */
  frame(): Promise<void> {
    this.redraw();
    return new Promise((resolve) => this.waiting.push(resolve));
  }

  /** Moves the camera so many times as near. */
  nearer(factor: number): void {
    this.camera.position.sub(this.orbit.target).divideScalar(factor).add(this.orbit.target);
    this.orbit.update();
    this.redraw();
  }

  lookAtAll(box: THREE.Box3): void {
    const [centre, radius] = [box.getCenter(new THREE.Vector3()), box.getSize(new THREE.Vector3()).length() / 2];
    const narrowest = Math.min(1, this.camera.aspect) * Math.tan(THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEGREES / 2));
    const distance = (1.05 * Math.max(radius, Number.MIN_VALUE)) / Math.sin(Math.atan(narrowest));
    this.camera.near = distance / 1000;
    this.camera.far = distance * 10;
    this.camera.position.set(0.35, 0.4, 1).setLength(distance).add(centre);
    this.camera.updateProjectionMatrix();
    this.orbit.target.copy(centre);
    this.orbit.update();
    this.redraw();
  }

  private draw(): void {
    this.orbit.update();
    if (!this.needsFrame) return;
    this.needsFrame = false;
    this.beforeFrame(this.renderer.domElement.height / (2 * Math.tan(THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEGREES / 2))));
    this.renderer.render(this.scene, this.camera);
    this.waiting.splice(0).forEach((resolve) => resolve());
  }
}

/** Shows one line, as what is wrong or as a hint, or takes it away. */
export function showMessage(message: string | undefined, isHint = false): void {
  element("message", HTMLElement).hidden = message === undefined;
  element("message", HTMLElement).classList.toggle("is-hint", isHint);
  setText("message", message ?? "");
}

/** A model that was decoded: it is shown, or closed where another one is shown instead. */
interface Opened {
  show(): void;
  close(): void;
}

type Open = (bytes: ArrayBuffer, name: string) => Promise<Opened>;

/**
 * Opens the model that the page's address names at the server, `?model=NAME`, or anywhere, `?url=URL`, and files that are dropped. Of
 * several the last is shown, whichever is there first.
 */
export async function openModels(fileOfServer: string, hint: string, open: Open): Promise<void> {
  let count = 0;
  const openFrom = async (bytes: Promise<ArrayBuffer>, name: string) => {
    const number = ++count;
    showMessage(`Reading ${name} …`, true);
    try {
      const opened = await open(await bytes, name);
      if (number !== count) return opened.close();
      opened.show();
      showMessage(undefined);
    } catch (error) {
      if (number === count) showMessage(`${name}: ${error instanceof Error ? error.message : String(error)}`);
    }
  };
  window.addEventListener("dragover", (event) => event.preventDefault());
  window.addEventListener("drop", (event) => {
    event.preventDefault();
    const file = event.dataTransfer?.files[0];
    if (file !== undefined) void openFrom(read(file), file.name);
  });
  const picker = element("file", HTMLInputElement);
  picker.addEventListener("change", () => {
    const file = picker.files?.[0];
    if (file !== undefined) void openFrom(read(file), file.name);
    picker.value = "";
  });
  const query = new URLSearchParams(location.search);
  const [model, url] = [query.get("model"), query.get("url")];
  if (model !== null) await openFrom(fetched(`${encodeURIComponent(model)}/${fileOfServer}`), model);
  else if (url !== null) await openFrom(fetched(url), new URL(url, location.href).pathname.split("/").at(-1) ?? url);
  else showMessage(hint, true);
}

async function fetched(url: string): Promise<ArrayBuffer> {
  const answer = await fetch(url).catch(() => undefined);
  if (answer === undefined) throw new Error("it cannot be reached, or its server allows no other pages to read it");
  if (!answer.ok) throw new Error(answer.status === 404 ? "there is no such model" : `the server answers ${answer.status}`);
  checkSize(Number(answer.headers.get("content-length") ?? 0));
  const bytes = await answer.arrayBuffer();
  checkSize(bytes.byteLength);
  return bytes;
}

async function read(file: File): Promise<ArrayBuffer> {
  checkSize(file.size);
  return file.arrayBuffer();
}

function checkSize(bytes: number): void {
  if (bytes > MOST_BYTES) throw new Error(`${(bytes / 2 ** 20).toFixed(0)} MB are too large for this page, which reads at most ${MOST_BYTES / 2 ** 20} MB`);
}
