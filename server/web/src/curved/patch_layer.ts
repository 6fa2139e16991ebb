// The patches of one level on the graphics card: their control points in a texture, a template of triangles for each factor.

import * as THREE from "three";
import { patchesOf, type CurvedLevels } from "./clod.ts";
import { Factors, MOST, type Sight } from "./factors.ts";
import { NET_FRAGMENT, NET_VERTEX, PATCH_FRAGMENT, PATCH_VERTEX, TEXTURE_WIDTH } from "./shaders.ts";

/** Lines of a control net, between neighbours of each of its rows. */
const NET = [
  [0, 1, 3, 6],
  [2, 4, 7],
  [5, 8],
  [6, 7, 8, 9],
  [3, 4, 5],
  [1, 2],
  [9, 5, 2, 0],
  [8, 4, 1],
  [7, 3],
].flatMap((row) => row.slice(1).flatMap((point, place) => [row[place]!, point]));

/** What is drawn. */
export interface Drawn {
  readonly patches: number;
  readonly triangles: number;
  readonly error: number;
}

export class PatchLayer {
  readonly group = new THREE.Group();
  readonly box = new THREE.Box3();
  private readonly factors: Factors;
  private readonly texture: THREE.DataTexture;
  private readonly templates = new Map<number, THREE.Mesh<THREE.InstancedBufferGeometry, THREE.RawShaderMaterial>>();
  private readonly net: THREE.LineSegments<THREE.InstancedBufferGeometry, THREE.RawShaderMaterial>;
  private shown: { patches: Uint32Array; error: number };
  private triangles = 0;

  constructor(private readonly levels: CurvedLevels) {
    this.factors = new Factors(levels);
    this.texture = textureOf(levels);
    this.shown = patchesOf(levels, levels.levelCount - 1);
    for (const patch of this.shown.patches) {
      for (let point = 0; point < 10; point++) this.box.expandByPoint(new THREE.Vector3().fromArray(levels.points, 30 * patch + 3 * point));
    }
    this.net = new THREE.LineSegments(netGeometry(), this.material(NET_VERTEX, NET_FRAGMENT));
    this.net.frustumCulled = false;
    this.net.visible = false;
    this.group.add(this.net);
  }

  setLevel(level: number): void {
    this.shown = patchesOf(this.levels, level);
  }

  setNet(visible: boolean): void {
    this.net.visible = visible;
  }

  /** Chooses factors for what the camera sees. */
  update(sight: Sight): void {
    const byFactor = this.factors.sorted(this.shown.patches, sight);
    this.triangles = 0;
    for (const mesh of this.templates.values()) mesh.visible = false;
    for (const [finest, patches] of byFactor) {
      const mesh = this.template(finest);
      mesh.visible = true;
      setInstances(mesh.geometry, patches.flatMap((patch) => [patch, this.packed(patch)]));
      this.triangles += patches.length * finest * finest;
    }
    if (this.net.visible) setInstances(this.net.geometry, Array.from(this.shown.patches).flatMap((patch) => [patch, 0]));
  }

  drawn(): Drawn {
    return { patches: this.shown.patches.length, triangles: this.triangles, error: this.shown.error };
  }

  dispose(): void {
    this.texture.dispose();
    for (const mesh of [...this.templates.values(), this.net]) {
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
  }

  /** Exponents of the factors of a patch's curves, and their directions. */
  private packed(patch: number): number {
    return [0, 1, 2].reduce((packed, curve) => {
      const exponent = Math.log2(this.factors.ofCurves[3 * patch + curve]!);
      const isReversed = this.levels.curves[3 * patch + curve]! % 2;
      return packed | (exponent << (4 * curve)) | (isReversed << (12 + curve));
    }, 0);
  }

  private template(finest: number): THREE.Mesh<THREE.InstancedBufferGeometry, THREE.RawShaderMaterial> {
    const known = this.templates.get(finest);
    if (known !== undefined) return known;
    const material = this.material(PATCH_VERTEX, PATCH_FRAGMENT);
    material.uniforms["steps"] = { value: finest };
    const mesh = new THREE.Mesh(latticeGeometry(finest), material);
    mesh.frustumCulled = false;
    this.templates.set(finest, mesh);
    this.group.add(mesh);
    return mesh;
  }

  private material(vertexShader: string, fragmentShader: string): THREE.RawShaderMaterial {
    return new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      side: THREE.DoubleSide,
      uniforms: { points: { value: this.texture } },
      vertexShader,
      fragmentShader,
    });
  }
}

function textureOf({ points, patchCount }: CurvedLevels): THREE.DataTexture {
  const rows = Math.max(1, Math.ceil((10 * patchCount) / TEXTURE_WIDTH));
  const texels = new Float32Array(4 * rows * TEXTURE_WIDTH);
  for (let point = 0; point < 10 * patchCount; point++) texels.set(points.subarray(3 * point, 3 * point + 3), 4 * point);
  const texture = new THREE.DataTexture(texels, TEXTURE_WIDTH, rows, THREE.RGBAFormat, THREE.FloatType);
  texture.needsUpdate = true;
  return texture;
}

/** A triangle cut into `steps` along each side. */
function latticeGeometry(steps: number): THREE.InstancedBufferGeometry {
  if (steps > MOST) throw new Error(`A patch is cut into ${steps} along a side.`);
  const places: number[] = [];
  const index: number[] = [];
  const row = (across: number) => (across * (2 * steps + 3 - across)) / 2;
  for (let w = 0; w <= steps; w++) {
    for (let v = 0; v <= steps - w; v++) {
      places.push(steps - v - w, v, w);
      if (v + w < steps) index.push(row(w) + v, row(w) + v + 1, row(w + 1) + v);
      if (v + w + 1 < steps) index.push(row(w) + v + 1, row(w + 1) + v + 1, row(w + 1) + v);
    }
  }
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute("place", new THREE.BufferAttribute(Uint32Array.from(places), 3));
  geometry.setIndex(index);
  return geometry;
}

function netGeometry(): THREE.InstancedBufferGeometry {
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute("point", new THREE.BufferAttribute(Uint32Array.from(NET), 1));
  geometry.setDrawRange(0, NET.length);
  return geometry;
}

function setInstances(geometry: THREE.InstancedBufferGeometry, numbers: number[]): void {
  const present = geometry.getAttribute("instance") as THREE.InstancedBufferAttribute | undefined;
  if (present === undefined || present.array.length < numbers.length) {
    geometry.dispose();
    geometry.setAttribute("instance", new THREE.InstancedBufferAttribute(new Uint32Array(2 * numbers.length), 2));
  }
  const attribute = geometry.getAttribute("instance") as THREE.InstancedBufferAttribute;
  attribute.array.set(numbers);
  attribute.needsUpdate = true;
  geometry.instanceCount = numbers.length / 2;
}
