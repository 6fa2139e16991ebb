// The page of progressive meshes: opens a `.spm` file, and draws one of its levels, or each part as the view needs it.

import * as THREE from "three";
import { DecodeError } from "../decode_error.ts";
import { element, setText } from "../elements.ts";
import { connectDark, connectSwitch, onKey } from "../keys.ts";
import { ModelStage, openModels, showMessage } from "../model_stage.ts";
import { placesOfLevel } from "../partition.ts";
import type { ModelView } from "../progressive_model.ts";
import type { Surface } from "../tile.ts";
import { PatchedGeometry } from "./patched_geometry.ts";
import { WorkingModel } from "./working_model.ts";

declare global {
  interface Window {
    /** For tests and the console. */
    model: {
      /** The level that is drawn and its error; or, where it is drawn as a view needs it, within how many pixels, and what the last view changed. */
      drawn(): { readonly triangles: number } & (Drawn | Refined) | undefined;
      nearer(factor: number): void;
      frame(): Promise<void>;
    };
  }
}

interface Drawn {
  readonly level: number;
  readonly error: number;
}

interface Refined {
  readonly within: number;
  /** Vertices that were split or collapsed, and bytes that were sent to the graphics card. */
  readonly changes: number;
  readonly bytes: number;
  /** Whether the picture is that of the view. */
  readonly isSettled: boolean;
}

/** Display-referred. */
const CLAY = new THREE.Color().setHex(0xd8b48a, THREE.LinearSRGBColorSpace);
const EDGES = new THREE.Color().setHex(0x17222c, THREE.LinearSRGBColorSpace);
/** Pixels: on a narrower page the panel is folded at first. */
const NARROW = 600;

class ModelPage {
  private readonly stage = new ModelStage((pixels) => void this.refine(pixels));
  private readonly slider = element("level", HTMLInputElement);
  private readonly tolerance = element("within", HTMLInputElement);
  private readonly byView = element("by-view", HTMLInputElement);
  private readonly clay = new THREE.MeshLambertMaterial({ color: CLAY, flatShading: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  private readonly surface = new THREE.Mesh(new THREE.BufferGeometry(), this.clay);
  private readonly edges = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({ color: EDGES, wireframe: true, transparent: true, opacity: 0.45 }));
  private readonly turned = new THREE.Group().add(this.surface, this.edges);
  private model: WorkingModel | undefined;
  private readonly box = new THREE.Box3();
  /** Where vertices are counted from, so that they keep their digits. */
  private readonly centre = new THREE.Vector3();
  private patched: PatchedGeometry | undefined;
  /** The view that is drawn, or is being refined for. */
  private view: ModelView | undefined;
  private isRefining = false;
  private refined = { triangles: 0, changes: 0, bytes: 0 };

  constructor() {
    const { scene, camera } = this.stage;
    scene.add(this.turned, new THREE.HemisphereLight(0xffffff, 0x8a8f98, 1.6), camera);
    const lamp = new THREE.DirectionalLight(0xffffff, 2);
    lamp.position.set(-0.6, 0.8, 0.4);
    camera.add(lamp);
    for (const object of [this.surface, this.edges]) object.frustumCulled = false;
    this.slider.addEventListener("input", () => this.showLevel());
    this.tolerance.addEventListener("input", () => this.stage.redraw());
    element("panel", HTMLDetailsElement).open = innerWidth >= NARROW;
    connectDark();
    connectSwitch("wireframe", "KeyX", (isShown) => {
      this.edges.visible = isShown;
      this.stage.redraw();
    });
    connectSwitch("z-up", "KeyZ", (isUpright) => {
      this.turned.rotation.x = isUpright ? -Math.PI / 2 : 0;
      this.lookAtAll();
    });
    connectSwitch("by-view", "KeyV", () => this.choose());
    onKey("KeyR", () => this.lookAtAll());
    onKey("PageUp", () => this.step(-1));
    onKey("PageDown", () => this.step(1));
  }

  show(model: WorkingModel, bytes: number, name: string): void {
    const { mesh } = model;
    this.model?.close();
    this.model = model;
    this.isRefining = false;
    this.patched?.dispose();
    this.patched = undefined;
    this.box.setFromArray(mesh.positions).getCenter(this.centre);
    for (const object of [this.surface, this.edges]) object.position.copy(this.centre);
    setText("name", name);
    setText("vertices", mesh.representatives.length.toLocaleString("en"));
    setText("bytes", `${(bytes / 1e3).toLocaleString("en", { maximumFractionDigits: 1 })} kB`);
    setText("size", this.box.getSize(new THREE.Vector3()).toArray().map(threeDigits).join(" × "));
    this.slider.max = String(mesh.levels.length - 1);
    this.slider.value = "0";
    this.slider.disabled = false;
    this.lookAtAll();
    this.choose();
  }

  drawn = () => {
    if (this.model === undefined) return undefined;
    if (!this.byView.checked) return { level: this.slider.valueAsNumber, ...figuresOf(this.model.mesh, this.slider.valueAsNumber) };
    return { ...this.refined, within: this.within, isSettled: !this.isRefining && this.view !== undefined };
  };
  nearer = (factor: number) => this.stage.nearer(factor);
  frame = () => this.stage.frame();

  private get within(): number {
    return 2 ** this.tolerance.valueAsNumber;
  }

  /** Draws a level, or what the view needs. */
  private choose(): void {
    element("by-level", HTMLElement).hidden = this.byView.checked;
    element("as-needed", HTMLElement).hidden = !this.byView.checked;
    this.view = undefined;
    if (this.byView.checked) this.stage.redraw();
    else this.showLevel();
  }

  private lookAtAll(): void {
    this.turned.updateMatrix();
    if (this.model !== undefined) this.stage.lookAtAll(this.box.clone().applyMatrix4(this.turned.matrix));
  }

  private step(by: number): void {
    const slider = this.byView.checked ? this.tolerance : this.slider;
    slider.valueAsNumber += by;
    slider.dispatchEvent(new Event("input"));
  }

  /** The level of the slider, which counts from the finest. */
  private showLevel(): void {
    if (this.model === undefined) return;
    const { mesh } = this.model;
    const { triangles, error } = figuresOf(mesh, this.slider.valueAsNumber);
    this.draw(geometryOf(mesh, this.slider.valueAsNumber, this.centre));
    const [level, last] = [this.slider.value, this.slider.max];
    setText("level-text", `Level ${level} of ${last}: ${triangles.toLocaleString("en")} triangles, ± ${shown(error)}`);
    this.stage.redraw();
  }

  private draw(geometry: THREE.BufferGeometry): void {
    if (this.surface.geometry !== this.patched) this.surface.geometry.dispose();
    this.surface.geometry = geometry;
    this.edges.geometry = geometry;
  }

  /** Splits and collapses in the worker until the picture is that of the view; one view is answered before the next is asked for. */
  private async refine(focalLength: number): Promise<void> {
    const { model } = this;
    if (model === undefined || !this.byView.checked || this.isRefining) return;
    const view = viewOf(this.stage.camera, this.turned, focalLength, this.within);
    if (isSame(view, this.view)) return;
    this.isRefining = true;
    this.view = view;
    try {
      const redrawn = await model.refine(view);
      if (model !== this.model) return;
      this.patched ??= new PatchedGeometry(model.mesh.representatives.length, model.mesh.corners.length / 3, this.centre);
      const { triangles, changes } = redrawn;
      this.refined = { triangles, changes, bytes: this.patched.patch(redrawn) };
      if (!this.byView.checked) return;
      this.draw(this.patched);
      const all = (model.mesh.corners.length / 3).toLocaleString("en");
      setText("within-text", `Within ${this.within} px: ${triangles.toLocaleString("en")} of ${all} triangles`);
    } catch (error) {
      if (!(error instanceof DecodeError) || model !== this.model) throw error;
      showMessage(`It cannot be refined in parts: ${error.message}`);
      this.byView.checked = false;
      this.choose();
    } finally {
      if (model === this.model) this.isRefining = false;
      this.stage.redraw();
    }
  }
}

/** What a camera sees, in the model's coordinates. */
function viewOf(camera: THREE.PerspectiveCamera, turned: THREE.Object3D, focalLength: number, within: number): ModelView {
  turned.updateMatrixWorld();
  camera.updateMatrixWorld();
  const toClip = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).multiply(turned.matrixWorld);
  const { planes } = new THREE.Frustum().setFromProjectionMatrix(toClip);
  return {
    eye: turned.worldToLocal(camera.position.clone()).toArray(),
    frustum: planes.flatMap(({ normal, constant }) => [...normal.toArray(), constant]),
    focalLength,
    within,
  };
}

function isSame(view: ModelView, other: ModelView | undefined): boolean {
  const numbers = ({ eye, frustum, focalLength, within }: ModelView) => [...eye, ...frustum, focalLength, within].join();
  return other !== undefined && numbers(view) === numbers(other);
}

const indexOf = ({ levels }: Surface, level: number) => levels.length - 1 - level;

function figuresOf(mesh: Surface, level: number): { triangles: number; error: number } {
  const { triangleEnd, error } = mesh.levels[indexOf(mesh, level)]!;
  return { triangles: triangleEnd, error };
}

/** All vertices where they are drawn, as seen from a centre, those that are not in where what stands for them is, and the triangles that are in. */
function geometryOf(mesh: Surface, level: number, { x, y, z }: THREE.Vector3): THREE.BufferGeometry {
  const last = indexOf(mesh, level);
  const positions = new Float32Array(3 * mesh.representatives.length);
  placesOfLevel(mesh, last).forEach((place, vertex) => {
    const [a, b, c] = mesh.positions.subarray(3 * place, 3 * place + 3) as unknown as [number, number, number];
    positions.set([a - x, b - y, c - z], 3 * vertex);
  });
  const corners = mesh.corners.subarray(0, 3 * mesh.levels[last]!.triangleEnd);
  const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(positions, 3));
  return geometry.setIndex(new THREE.BufferAttribute(corners, 1));
}

const threeDigits = (length: number) => length.toLocaleString("en", { maximumSignificantDigits: 3 });

/** Never less than the error is. */
function shown(error: number): string {
  const scale = 10 ** (2 - Math.floor(Math.log10(error)));
  return error > 0 && Number.isFinite(scale) ? Number((Math.ceil(error * scale) / scale).toPrecision(3)).toString() : String(error);
}

const page = new ModelPage();
window.model = page;
void openModels("model.spm", "Drop or open a .spm file.", async (bytes, name) => {
  const size = bytes.byteLength;
  const model = await WorkingModel.decode(bytes);
  return { show: () => page.show(model, size, name), close: () => model.close() };
});
