// Heights on contour lines, written along them while the view rests.

import type { Viewer } from "./viewer.ts";

/** Pixels of the cells of the view, each of which has one label at most. */
const CELL = { width: 170, height: 120 };
/** Pixels that a straight piece of a line has at least to be written on, and a label keeps from the view's edge. */
const [SHORTEST, MARGIN] = [7, 24];
const REST_MILLISECONDS = 300;

interface Candidate {
  readonly x: number;
  readonly y: number;
  readonly angle: number;
  readonly length: number;
  readonly height: number;
  readonly isInSight: () => boolean;
}

/** The labels of a view. */
export class ContourLabels {
  private resting: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly viewer: Viewer,
    private readonly holder: HTMLElement,
  ) {}

  /** Call it after each frame: labels go, and come back when there has been none for a while. */
  frameWasDrawn(): void {
    this.holder.replaceChildren();
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.holder.replaceChildren(...this.chosen().map(labelOf)), REST_MILLISECONDS);
  }

  /** Of each cell, the longest piece that is in sight. */
  private chosen(): Candidate[] {
    const cells = new Map<string, Candidate[]>();
    for (const candidate of this.candidates()) {
      const cell = `${Math.floor(candidate.x / CELL.width)},${Math.floor(candidate.y / CELL.height)}`;
      cells.set(cell, [...(cells.get(cell) ?? []), candidate].sort((a, b) => b.length - a.length).slice(0, 3));
    }
    return [...cells.values()].flatMap((candidates) => candidates.find(({ isInSight }) => isInSight()) ?? []);
  }

  private candidates(): Candidate[] {
    const [width, height] = [this.holder.clientWidth, this.holder.clientHeight];
    return this.viewer.contourPieces().flatMap((piece) => {
      const [from, to] = piece.ends.map((end) => this.viewer.pixelOf(end));
      if (from === undefined || to === undefined) return [];
      const [x, y] = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
      const isInside = x > MARGIN && y > MARGIN && x < width - MARGIN && y < height - MARGIN;
      const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
      if (!isInside || length < SHORTEST) return [];
      const angle = Math.atan((to[1] - from[1]) / (to[0] - from[0]));
      const isInSight = () => this.viewer.isInSight(piece.ends[0].clone().lerp(piece.ends[1], 0.5));
      return [{ x, y, angle, length, height: piece.height, isInSight }];
    });
  }
}

function labelOf({ x, y, angle, height }: Candidate): HTMLElement {
  const label = document.createElement("span");
  label.textContent = String(Number(height.toPrecision(6)));
  label.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%) rotate(${angle}rad)`;
  return label;
}
