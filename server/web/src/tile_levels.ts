// The levels of the tile in the middle of the view, one after the other; the forest of its vertices' representatives, and the graph of
// its collapses.

import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { keyOf, type Address } from "./address.ts";
import { onClick } from "./canvas.ts";
import { collapseGraph, type CollapseGraph } from "./collapse_graph.ts";
import { CollapsePicture } from "./collapse_picture.ts";
import { element, setText } from "./elements.ts";
import type { DrawnTile, TileLevelView } from "./terrain_layer.ts";
import type { Viewer } from "./viewer.ts";

const colour = (hex: number) => new THREE.Color().setHex(hex, THREE.LinearSRGBColorSpace);
/** Of vertices that are drawn, of those that still are where their representative is, of the one that is chosen, as in the style sheet; and of roots. */
const [IN, OUT, CHOSEN, ROOT] = [colour(0x2b5ea1), colour(0xe4572e), colour(0xffc20e), colour(0x17222c)];
const [LINE_PIXELS, POINT_PIXELS, CHOSEN_PIXELS] = [2, 6, 13];

/** A tile that is all there. */
interface Shown extends DrawnTile {
  readonly graph: CollapseGraph;
}

/** Shows one tile alone while it is enabled, at the level that a slider tells. */
export class TileLevels {
  private isEnabled = false;
  private tile: { readonly address: Address; readonly levels: readonly TileLevelView[] } | undefined;
  private shown: Shown | undefined;
  private chosen = 0;
  private readonly slider = element("level", HTMLInputElement);
  private readonly forest = element("forest", HTMLInputElement);
  private readonly collapses = element("collapses", HTMLInputElement);
  private readonly picture = new CollapsePicture(element("collapse-graph", HTMLElement), (vertex) => this.choose(vertex));
  private readonly lines = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ linewidth: LINE_PIXELS, vertexColors: true, depthTest: false }));
  private readonly roots = dots(POINT_PIXELS);
  private readonly points = dots(POINT_PIXELS);
  private readonly mark = dots(CHOSEN_PIXELS);

  constructor(
    private readonly viewer: Viewer,
    canvas: HTMLCanvasElement,
  ) {
    for (const control of [this.slider, this.forest, this.collapses]) control.addEventListener("input", () => this.show());
    for (const [order, object] of this.objects.entries()) {
      object.frustumCulled = false;
      object.renderOrder = 2 + order;
      object.visible = false;
      viewer.add(object);
    }
    onClick(canvas, (x, y) => {
      const vertex = this.collapses.checked ? this.nearest(x, y) : undefined;
      if (vertex !== undefined) this.choose(vertex);
    });
    new ResizeObserver(() => this.showCollapses()).observe(element("collapse-graph", HTMLElement));
  }

  setEnabled(isEnabled: boolean): void {
    this.isEnabled = isEnabled;
    element("levels", HTMLElement).hidden = !isEnabled;
    this.take();
  }

  /** Call it after frames: where no tile was in the middle, one may be now. */
  frameWasDrawn(): void {
    if (this.isEnabled && this.tile === undefined) this.take();
  }

  private get objects(): THREE.Object3D[] {
    return [this.lines, this.roots, this.points, this.mark];
  }

  private get level(): TileLevelView | undefined {
    return this.tile?.levels[this.slider.valueAsNumber];
  }

  private take(): void {
    const before = this.tile;
    this.tile = this.isEnabled ? this.viewer.tileInMiddle() : undefined;
    this.shown = undefined;
    const isLoading = this.viewer.isLoading || this.viewer.stats() === undefined;
    setText("level-text", isLoading ? "Nothing is there yet: the tile in the middle of the view is shown when it is." : "There is no tile in the middle of the view.");
    for (const control of [this.slider, this.forest, this.collapses]) control.disabled = this.tile === undefined;
    if (before === undefined && this.tile === undefined) return;
    this.slider.max = String((this.tile?.levels.length ?? 1) - 1);
    this.slider.value = "0";
    this.show();
  }

  private show(): void {
    const { tile, level } = this;
    this.viewer.showAlone(tile?.address, level);
    if (tile !== undefined && level !== undefined) setText("level-text", `Tile ${keyOf(tile.address)}, ${textOf(level, tile.levels.length)}`);
    void this.showParts();
  }

  /** The forest and the graph, once all of the tile is there. */
  private async showParts(): Promise<void> {
    const { tile, level } = this;
    element("collapse-part", HTMLElement).hidden = tile === undefined || !this.collapses.checked;
    for (const object of this.objects) object.visible = false;
    this.viewer.redraw();
    if (tile === undefined || !(this.forest.checked || this.collapses.checked)) return;
    await this.viewer.settled();
    if (tile !== this.tile || level !== this.level) return;
    if (this.shown === undefined) this.find(tile.address);
    if (this.forest.checked) this.showForest();
    this.showCollapses();
  }

  private find(address: Address): void {
    const drawn = this.viewer.drawnTile(address);
    if (drawn === undefined) return;
    this.shown = { ...drawn, graph: collapseGraph(drawn.tile, drawn.tile.levels[0]!.vertexEnd) };
    this.chosen = this.nearest(0, 0) ?? this.shown.graph.first;
  }

  /** Whether a vertex is drawn at the level that is shown. */
  private isIn(vertex: number): boolean {
    const { interior, fineSides } = this.level!.detail;
    return fineSides.includes(true) || vertex < this.shown!.tile.levels[interior]!.vertexEnd;
  }

  private showForest(): void {
    if (this.shown === undefined) return;
    const { tile, places, graph } = this.shown;
    const vertices = Array.from(graph.needs, (_, at) => graph.first + at);
    const ends = vertices.flatMap((vertex) => [places[vertex]!, places[tile.representatives[vertex]!]!]);
    const colours = vertices.flatMap((vertex) => [...this.colourOf(vertex).toArray(), ...this.colourOf(vertex).toArray()]);
    this.lines.geometry.dispose();
    this.lines.geometry = new LineSegmentsGeometry().setPositions(ends.flatMap((end) => end.toArray())).setColors(colours);
    this.lines.visible = vertices.length > 0;
    const roots = [...new Set(tile.representatives.subarray(graph.first))].filter((vertex) => vertex < graph.first);
    place(this.roots, roots.map((vertex) => places[vertex]!), roots.map(() => ROOT));
    this.viewer.redraw();
  }

  private colourOf(vertex: number): THREE.Color {
    return this.isIn(vertex) ? IN : OUT;
  }

  private showCollapses(): void {
    if (this.shown === undefined || !this.collapses.checked || this.level === undefined) return;
    const { graph, places } = this.shown;
    const count = graph.needs.length;
    if (count === 0) return setText("collapse-text", "The tile has one level only: nothing collapses in it.");
    const shown = this.picture.show(graph, this.chosen, (vertex) => this.isIn(vertex));
    const part = shown.length < count ? `; ${shown.length} of them around vertex ${this.chosen}` : "";
    setText("collapse-text", `${count.toLocaleString("en")} collapses, ${graph.edgeCount.toLocaleString("en")} dependencies, ${graph.depth} deep${part}`);
    place(this.points, shown.map((vertex) => places[vertex]!), shown.map((vertex) => this.colourOf(vertex)));
    place(this.mark, [places[this.chosen]!], [CHOSEN]);
    this.viewer.redraw();
  }

  private choose(vertex: number): void {
    this.chosen = vertex;
    this.showCollapses();
  }

  /** The vertex that is nearest to the ground at a place of the canvas, of those that collapse. */
  private nearest(x: number, y: number): number | undefined {
    const ground = this.viewer.groundAt(x, y);
    if (this.shown === undefined || ground === undefined) return undefined;
    const { places, graph } = this.shown;
    const distances = Float64Array.from(places.slice(graph.first), (place) => place.distanceToSquared(ground.position));
    const least = distances.reduce((a, b) => Math.min(a, b), Infinity);
    return distances.length === 0 ? undefined : graph.first + distances.indexOf(least);
  }
}

function dots(size: number): THREE.Points {
  return new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ size, sizeAttenuation: false, vertexColors: true, depthTest: false }));
}

function place(points: THREE.Points, places: readonly THREE.Vector3[], colours: readonly THREE.Color[]): void {
  points.geometry.dispose();
  points.geometry = new THREE.BufferGeometry().setFromPoints([...places]);
  points.geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours.flatMap((one) => one.toArray()), 3));
  points.visible = places.length > 0;
}

function textOf({ detail, error, triangles }: TileLevelView, count: number): string {
  const name = detail.fineSides.includes(true) ? "with its own zoom's sides" : `level ${detail.interior + 1} of ${count - 1}`;
  return `${name}: ${triangles.toLocaleString("en")} triangles, ± ${error.toPrecision(3)} m`;
}
