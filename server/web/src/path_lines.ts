// A path on the ground, as lines and dots that mountains do not hide.

import * as THREE from "three";
import { Line2 } from "three/addons/lines/Line2.js";
import { LineGeometry } from "three/addons/lines/LineGeometry.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";

/** Display-referred, as all colours of the view are. */
const COLOUR = new THREE.Color().setHex(0xe4572e, THREE.LinearSRGBColorSpace);
const WHITE = new THREE.Color(1, 1, 1);
const [LINE_PIXELS, CORNER_PIXELS, MARK_PIXELS] = [3, 9, 13];

/** Shows a line, the corners of it, and a mark on it. */
export class PathLines {
  readonly object = new THREE.Group();
  private readonly line = new Line2(new LineGeometry(), new LineMaterial({ color: COLOUR, linewidth: LINE_PIXELS, depthTest: false }));
  private readonly corners = dots(CORNER_PIXELS, COLOUR);
  private readonly mark = dots(MARK_PIXELS, WHITE);

  constructor() {
    this.object.add(this.line, this.corners, this.mark);
    for (const [order, part] of this.object.children.entries()) {
      part.renderOrder = 2 + order;
      part.frustumCulled = false;
    }
    this.show([], []);
    this.markAt(undefined);
  }

  show(line: readonly THREE.Vector3[], corners: readonly THREE.Vector3[]): void {
    this.line.visible = line.length > 1;
    if (this.line.visible) {
      this.line.geometry.dispose();
      this.line.geometry = new LineGeometry().setPositions(line.flatMap((place) => place.toArray()));
    }
    place(this.corners, corners);
  }

  markAt(position: THREE.Vector3 | undefined): void {
    place(this.mark, position === undefined ? [] : [position]);
  }
}

function dots(pixels: number, color: THREE.Color): THREE.Points {
  const material = new THREE.PointsMaterial({ size: pixels, sizeAttenuation: false, color, depthTest: false });
  return new THREE.Points(new THREE.BufferGeometry(), material);
}

function place(points: THREE.Points, places: readonly THREE.Vector3[]): void {
  points.visible = places.length > 0;
  points.geometry.dispose();
  points.geometry = new THREE.BufferGeometry().setFromPoints([...places]);
}
