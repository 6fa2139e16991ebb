// The geometry of a model that is refined from view to view: of its buffers only what changed is written and sent to the graphics card.

import * as THREE from "three";
import type { Redrawn } from "../progressive_model.ts";

/** Elements between two changes that are sent along with them: one call more costs about as much. */
const LARGEST_GAP = 64;

export class PatchedGeometry extends THREE.BufferGeometry {
  private readonly places: THREE.BufferAttribute;
  private readonly corners: THREE.BufferAttribute;

  /** Empty, for so many vertices and triangles at most; positions are stored as seen from `centre`, so that they keep their digits. */
  constructor(
    vertexCount: number,
    triangleCount: number,
    private readonly centre: THREE.Vector3,
  ) {
    super();
    this.places = new THREE.BufferAttribute(new Float32Array(3 * vertexCount), 3).setUsage(THREE.DynamicDrawUsage);
    this.corners = new THREE.BufferAttribute(new Uint32Array(3 * triangleCount), 1).setUsage(THREE.DynamicDrawUsage);
    this.setAttribute("position", this.places).setIndex(this.corners).setDrawRange(0, 0);
  }

  /** Takes over what a view changes; tells how many bytes that sends. */
  patch({ triangles, places, corners, vertices, positions }: Redrawn): number {
    const { x, y, z } = this.centre;
    vertices.forEach((vertex, at) => this.places.setXYZ(vertex, positions[3 * at]! - x, positions[3 * at + 1]! - y, positions[3 * at + 2]! - z));
    places.forEach((place, at) => this.corners.array.set(corners.subarray(3 * at, 3 * at + 3), 3 * place));
    this.setDrawRange(0, 3 * triangles);
    return send(this.places, vertices) + send(this.corners, places);
  }
}

/** Marks groups of three numbers, which grow, as to be sent; tells how many bytes they are. */
function send(attribute: THREE.BufferAttribute, changed: Uint32Array): number {
  let bytes = 0;
  for (let first = 0; first < changed.length; ) {
    let last = first;
    while (last + 1 < changed.length && changed[last + 1]! - changed[last]! <= LARGEST_GAP) last++;
    const count = 3 * (changed[last]! - changed[first]! + 1);
    attribute.addUpdateRange(3 * changed[first]!, count);
    bytes += 4 * count;
    first = last + 1;
  }
  if (bytes > 0) attribute.needsUpdate = true;
  return bytes;
}
