// The page of progressive meshes: opens a `.spm` file, and draws one of its levels.

import * as THREE from "three";
import { element, setText } from "../elements.ts";
import { connectDark, connectSwitch, onKey } from "../keys.ts";
import { ModelStage, openModels } from "../model_stage.ts";
import { placesOfLevel } from "../partition.ts";
import type { Surface } from "../tile.ts";
import { decodeInWorker } from "./decode.ts";

declare global {
  interface Window {
    /** For tests and the console. */
    model: {
      drawn(): { readonly level: number; readonly triangles: number; readonly error: number } | undefined;
      frame(): Promise<void>;
    };
  }
}

/** Display-referred. */
const CLAY = new THREE.Color().setHex(0xd8b48a, THREE.LinearSRGBColorSpace);
const EDGES = new THREE.Color().setHex(0x17222c, THREE.LinearSRGBColorSpace);
/** Pixels: on a narrower page the panel is folded at first. */
const NARROW = 600;

class ModelPage {
  private readonly stage = new ModelStage(() => {});
  private readonly slider = element("level", HTMLInputElement);
  private readonly clay = new THREE.MeshLambertMaterial({ color: CLAY, flatShading: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  private readonly surface = new THREE.Mesh(new THREE.BufferGeometry(), this.clay);
  private readonly edges = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({ color: EDGES, wireframe: true, transparent: true, opacity: 0.45 }));
  private readonly turned = new THREE.Group().add(this.surface, this.edges);
  private mesh: Surface | undefined;

  constructor() {
    const { scene, camera } = this.stage;
    scene.add(this.turned, new THREE.HemisphereLight(0xffffff, 0x8a8f98, 1.6), camera);
    const lamp = new THREE.DirectionalLight(0xffffff, 2);
    lamp.position.set(-0.6, 0.8, 0.4);
    camera.add(lamp);
    for (const object of [this.surface, this.edges]) object.frustumCulled = false;
    this.slider.addEventListener("input", () => this.showLevel());
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
    onKey("KeyR", () => this.lookAtAll());
    onKey("PageUp", () => this.step(-1));
    onKey("PageDown", () => this.step(1));
  }

  show(mesh: Surface, bytes: number, name: string): void {
    this.mesh = mesh;
    setText("name", name);
    setText("vertices", mesh.representatives.length.toLocaleString("en"));
    setText("bytes", `${(bytes / 1e3).toLocaleString("en", { maximumFractionDigits: 1 })} kB`);
    setText("size", boxOf(mesh).getSize(new THREE.Vector3()).toArray().map((side) => side.toPrecision(3)).join(" × "));
    this.slider.max = String(mesh.levels.length - 1);
    this.slider.value = "0";
    this.slider.disabled = false;
    this.showLevel();
    this.lookAtAll();
  }

  drawn = () => this.mesh && { level: this.slider.valueAsNumber, ...figuresOf(this.mesh, this.slider.valueAsNumber) };
  frame = () => this.stage.frame();

  private lookAtAll(): void {
    this.turned.updateMatrix();
    if (this.mesh !== undefined) this.stage.lookAtAll(boxOf(this.mesh).applyMatrix4(this.turned.matrix));
  }

  private step(by: number): void {
    this.slider.valueAsNumber += by;
    this.showLevel();
  }

  /** The level of the slider, which counts from the finest. */
  private showLevel(): void {
    if (this.mesh === undefined) return;
    const { triangles, error } = figuresOf(this.mesh, this.slider.valueAsNumber);
    this.surface.geometry.dispose();
    this.surface.geometry = geometryOf(this.mesh, this.slider.valueAsNumber);
    this.edges.geometry = this.surface.geometry;
    const [level, last] = [this.slider.value, this.slider.max];
    setText("level-text", `Level ${level} of ${last}: ${triangles.toLocaleString("en")} triangles, ± ${shown(error)}`);
    this.stage.redraw();
  }
}

const boxOf = ({ positions }: Surface) => new THREE.Box3().setFromArray(positions);
const indexOf = ({ levels }: Surface, level: number) => levels.length - 1 - level;

function figuresOf(mesh: Surface, level: number): { triangles: number; error: number } {
  const { triangleEnd, error } = mesh.levels[indexOf(mesh, level)]!;
  return { triangles: triangleEnd, error };
}

/** All vertices where they are drawn, those that are not in where what stands for them is, and the triangles that are in. */
function geometryOf(mesh: Surface, level: number): THREE.BufferGeometry {
  const last = indexOf(mesh, level);
  const positions = new Float32Array(3 * mesh.representatives.length);
  placesOfLevel(mesh, last).forEach((place, vertex) => positions.set(mesh.positions.subarray(3 * place, 3 * place + 3), 3 * vertex));
  const corners = mesh.corners.subarray(0, 3 * mesh.levels[last]!.triangleEnd);
  const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(positions, 3));
  return geometry.setIndex(new THREE.BufferAttribute(corners, 1));
}

/** Never less than the error is. */
function shown(error: number): string {
  const scale = 10 ** (2 - Math.floor(Math.log10(error)));
  return error > 0 && Number.isFinite(scale) ? Number((Math.ceil(error * scale) / scale).toPrecision(3)).toString() : String(error);
}

const page = new ModelPage();
window.model = page;
void openModels("model.spm", "Drop or open a .spm file.", async (bytes, name) => {
  const size = bytes.byteLength;
  const mesh = await decodeInWorker(bytes);
  return () => page.show(mesh, size, name);
});
