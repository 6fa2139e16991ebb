// A part of a graph of collapses as a picture: rows of nodes by level, edges from each collapse down to those that it needs, without
// those that others imply.

import { collapsesAround, rowsOf, type CollapseGraph } from "./collapse_graph.ts";

const SVG = "http://www.w3.org/2000/svg";
/** Pixels: of the numbers beside the rows, between rows, around all, and radii of nodes. */
const [GUTTER, ROW_HEIGHT, MARGIN, RADIUS, CHOSEN_RADIUS] = [34, 26, 12, 4.5, 7];
/** Pixels of width for each node, and levels above and below the chosen one. */
const [WIDTH_PER_NODE, LEVELS] = [10, 3];

/** Draws in an element, where a node can be chosen by pointer and by arrow keys. */
export class CollapsePicture {
  private readonly svg = document.createElementNS(SVG, "svg");
  private rows: readonly (readonly number[])[] = [];
  private chosen = -1;

  constructor(
    private readonly holder: HTMLElement,
    private readonly choose: (vertex: number) => void,
  ) {
    holder.append(this.svg);
    this.svg.setAttribute("tabindex", "0");
    this.svg.setAttribute("role", "img");
    this.svg.addEventListener("click", ({ target }) => {
      const vertex = target instanceof SVGElement ? target.dataset["vertex"] : undefined;
      if (vertex !== undefined) this.choose(Number(vertex));
    });
    this.svg.addEventListener("keydown", (event) => this.step(event));
  }

  /** Shows as many collapses around one as are readable; `isIn` tells which vertices are drawn, those of the others have collapsed. */
  show(graph: CollapseGraph, chosen: number, isIn: (vertex: number) => boolean): readonly number[] {
    this.chosen = chosen;
    const width = this.holder.clientWidth;
    const shown = collapsesAround(graph, chosen, width / WIDTH_PER_NODE, LEVELS);
    this.rows = rowsOf(graph, shown);
    const height = (this.rows.length - 1) * ROW_HEIGHT + 2 * MARGIN;
    const places = new Map<number, readonly [number, number]>();
    this.rows.forEach((row, at) => {
      const step = (width - GUTTER - MARGIN) / row.length;
      row.forEach((vertex, place) => places.set(vertex, [GUTTER + (place + 0.5) * step, MARGIN + at * ROW_HEIGHT]));
    });
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.setAttribute("height", String(height));
    const levels = this.rows.map((row, at) => {
      const text = made("text", { x: GUTTER - 8, y: MARGIN + at * ROW_HEIGHT + 4, class: "level" });
      text.textContent = String(graph.levels[row[0]! - graph.first]);
      return text;
    });
    const edges = shown.flatMap((vertex) => graph.reduced[vertex - graph.first]!.flatMap((other) => edgeBetween(vertex, other, chosen, places)));
    // Edges of the chosen one are above the others.
    edges.sort((a, b) => Number(a.classList.contains("chosen")) - Number(b.classList.contains("chosen")));
    const nodes = [...places].map(([vertex, [cx, cy]]) => {
      const kind = `${isIn(vertex) ? "in" : "out"}${vertex === chosen ? " chosen" : ""}`;
      const node = made("circle", { cx, cy, r: vertex === chosen ? CHOSEN_RADIUS : RADIUS, class: kind });
      node.dataset["vertex"] = String(vertex);
      return node;
    });
    this.svg.replaceChildren(...levels, ...edges, ...nodes);
    return shown;
  }

  /** To the next node of the row, or to the nearest of the row above or below. */
  private step(event: KeyboardEvent): void {
    const at = this.rows.findIndex((row) => row.includes(this.chosen));
    const row = this.rows[at];
    if (row === undefined) return;
    const place = row.indexOf(this.chosen);
    const across = (other: readonly number[] | undefined) => other?.[Math.floor(((place + 0.5) / row.length) * other.length)];
    const next = { ArrowLeft: row[place - 1], ArrowRight: row[place + 1], ArrowUp: across(this.rows[at - 1]), ArrowDown: across(this.rows[at + 1]) };
    if (!(event.key in next)) return;
    event.preventDefault();
    const vertex = next[event.key as keyof typeof next];
    if (vertex !== undefined) this.choose(vertex);
  }
}

/** From a collapse to one that it needs; nothing if that is not shown. */
function edgeBetween(from: number, to: number, chosen: number, places: ReadonlyMap<number, readonly [number, number]>): SVGElement[] {
  const [[x1, y1] = [0, 0], end] = [places.get(from), places.get(to)];
  if (end === undefined) return [];
  return [made("line", { x1, y1, x2: end[0], y2: end[1], class: from === chosen || to === chosen ? "chosen" : "" })];
}

function made(name: string, attributes: Record<string, string | number>): SVGElement {
  const found = document.createElementNS(SVG, name) as SVGElement;
  for (const [key, value] of Object.entries(attributes)) found.setAttribute(key, String(value));
  return found;
}
