// The levels of the tile in the middle of the view, one after the other, and the forest of its vertices' representatives.

import * as THREE from "three";
import { keyOf, type Address } from "./address.ts";
import { element, setText } from "./elements.ts";
import type { TileLevelView } from "./terrain_layer.ts";
import type { Viewer } from "./viewer.ts";

/** Of vertices that are drawn, and of those that still are where their representative is. */
const [IN, OUT] = [new THREE.Color().setHex(0x2b5ea1, THREE.LinearSRGBColorSpace), new THREE.Color().setHex(0xe4572e, THREE.LinearSRGBColorSpace)];

/** Shows one tile alone while it is enabled, at the level that a slider tells. */
export class TileLevels {
  private tile: { readonly address: Address; readonly levels: readonly TileLevelView[] } | undefined;
  private readonly slider = element("level", HTMLInputElement);
  private readonly forest = element("forest", HTMLInputElement);
  private readonly lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ vertexColors: true, depthTest: false }));

  constructor(private readonly viewer: Viewer) {
    this.slider.addEventListener("input", () => this.show());
    this.forest.addEventListener("input", () => this.show());
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 2;
    this.lines.visible = false;
    viewer.add(this.lines);
  }

  setEnabled(isEnabled: boolean): void {
    this.tile = isEnabled ? this.viewer.tileInMiddle() : undefined;
    element("levels", HTMLElement).hidden = !isEnabled;
    this.slider.max = String((this.tile?.levels.length ?? 1) - 1);
    this.slider.disabled = this.tile === undefined;
    this.slider.value = "0";
    this.show();
  }

  private show(): void {
    const level = this.tile?.levels[this.slider.valueAsNumber];
    this.viewer.showAlone(this.tile?.address, level);
    void this.showForest(level);
    const nothing = "There is no tile in the middle of the view.";
    setText("level-text", level === undefined ? nothing : `Tile ${keyOf(this.tile!.address)}, ${textOf(level, this.tile!.levels.length)}`);
  }

  /** Once all of the tile is there. */
  private async showForest(level: TileLevelView | undefined): Promise<void> {
    this.lines.visible = false;
    const { tile } = this;
    if (tile === undefined || level === undefined || !this.forest.checked) return this.viewer.redraw();
    await this.viewer.settled();
    if (tile !== this.tile || level !== tile.levels[this.slider.valueAsNumber] || !this.forest.checked) return;
    const edges = this.viewer.forestOf(tile.address);
    const { interior, fineSides } = level.detail;
    const isIn = (of: number) => of <= interior || fineSides.includes(true);
    this.lines.geometry.dispose();
    this.lines.geometry = new THREE.BufferGeometry().setFromPoints(edges.flatMap(({ ends }) => [...ends]));
    const colours = edges.flatMap(({ level: of }) => [...(isIn(of) ? IN : OUT).toArray(), ...(isIn(of) ? IN : OUT).toArray()]);
    this.lines.geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
    this.lines.visible = true;
    this.viewer.redraw();
  }
}

function textOf({ detail, error, triangles }: TileLevelView, count: number): string {
  const name = detail.fineSides.includes(true) ? "with its own zoom's sides" : `level ${detail.interior + 1} of ${count - 1}`;
  return `${name}: ${triangles.toLocaleString("en")} triangles, ± ${error.toPrecision(3)} m`;
}
