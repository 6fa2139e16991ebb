// A path that is clicked on the ground: its length, area and heights, on the page and as files.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { onClick } from "./canvas.ts";
import { element, setText } from "./elements.ts";
import type { GroundPoint } from "./ground.ts";
import type { Coordinates, Place } from "./coordinates.ts";
import { along, csvOf, geoJsonOf, lengthOf, type ProfilePoint } from "./path.ts";
import { PathLines } from "./path_lines.ts";
import type { Viewer } from "./viewer.ts";

const PLACES = 240;
const CHART_HEIGHT = 120;
/** How long the view has to rest before heights are taken anew from what is drawn. */
const REST_MILLISECONDS = 250;

/** Lets a path be clicked while it is enabled. */
export class Measuring {
  private isEnabled = false;
  private corners: Place[] = [];
  private profile: ProfilePoint[] = [];
  private grounds: (GroundPoint | undefined)[] = [];
  private readonly lines = new PathLines();
  private chart: uPlot | undefined;
  private resting: ReturnType<typeof setTimeout> | undefined;

  /** `coordinates` tells how places are told now, `heightsAbove` what heights are above, for files. */
  constructor(
    private readonly viewer: Viewer,
    canvas: HTMLCanvasElement,
    private readonly coordinates: () => Coordinates,
    private readonly heightsAbove: () => string,
  ) {
    viewer.add(this.lines.object);
    onClick(canvas, (x, y) => this.add(x, y));
    element("path-undo", HTMLElement).addEventListener("click", () => this.change(this.corners.slice(0, -1)));
    element("path-clear", HTMLElement).addEventListener("click", () => this.change([]));
    element("path-csv", HTMLElement).addEventListener("click", () => save("profile.csv", "text/csv", csvOf(this.profile, this.coordinates())));
    element("path-geojson", HTMLElement).addEventListener("click", () =>
      save("profile.geojson", "application/geo+json", geoJsonOf(this.profile, this.corners, this.heightsAbove(), this.coordinates())),
    );
    addEventListener("resize", () => this.showProfile());
  }

  /** What is not enabled takes no clicks; the path is kept for the next time. */
  setEnabled(isEnabled: boolean): void {
    this.isEnabled = isEnabled;
    element("measure", HTMLElement).hidden = !isEnabled;
    this.lines.object.visible = isEnabled;
    this.update();
  }

  /** Call it after frames: heights are those of what is drawn. */
  groundMayHaveChanged(): void {
    if (!this.isEnabled || this.corners.length === 0) return;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.isGroundChanged() && this.update(), REST_MILLISECONDS);
  }

  private add(x: number, y: number): void {
    const ground = this.isEnabled ? this.viewer.groundAt(x, y) : undefined;
    if (ground !== undefined) this.change([...this.corners, ground]);
  }

  private change(corners: Place[]): void {
    this.corners = corners;
    this.update();
  }

  private isGroundChanged(): boolean {
    const now = this.groundsNow();
    return now.some((ground, at) => {
      const before = this.grounds[at];
      return ground?.error !== before?.error || (ground && before ? !ground.position.equals(before.position) : ground !== before);
    });
  }

  private groundsNow(): (GroundPoint | undefined)[] {
    return along(this.corners, PLACES, this.coordinates()).map(({ longitude, latitude }) => this.viewer.groundBelow(longitude, latitude));
  }

  private update(): void {
    if (!this.isEnabled) return this.viewer.redraw();
    this.grounds = this.groundsNow();
    this.profile = along(this.corners, PLACES, this.coordinates()).map((place, at) => {
      const ground = this.grounds[at];
      return { ...place, height: ground?.height, error: ground?.error };
    });
    const drawn = (grounds: readonly (GroundPoint | undefined)[]) => grounds.flatMap((ground) => ground?.position ?? []);
    const corners = this.corners.map(({ longitude, latitude }) => this.viewer.groundBelow(longitude, latitude));
    this.lines.show(drawn(this.grounds), drawn(corners));
    this.viewer.redraw();
    setText("measured", this.summary());
    for (const id of ["path-undo", "path-clear"]) element(id, HTMLButtonElement).disabled = this.corners.length === 0;
    for (const id of ["path-csv", "path-geojson"]) element(id, HTMLButtonElement).disabled = this.corners.length < 2;
    this.showProfile();
  }

  private summary(): string {
    if (this.corners.length < 2) return this.corners.length === 0 ? "Click places on the ground." : "Click the next place.";
    const length = lengthOf(this.corners, this.coordinates());
    const [first, last] = [this.profile[0]!, this.profile.at(-1)!];
    const rise = first.height !== undefined && last.height !== undefined ? last.height - first.height : undefined;
    const parts = [`Length ${metres(length)}`];
    if (rise !== undefined) parts.push(`height difference ${rise < 0 ? "−" : "+"}${Math.abs(rise).toFixed(1)} ${doubt(first, last)}`);
    if (this.corners.length > 2) parts.push(`area ${squareMetres(this.coordinates().area(this.corners))}`);
    return parts.join(" · ");
  }

  private showProfile(): void {
    this.chart?.destroy();
    this.chart = undefined;
    this.lines.markAt(undefined);
    const holder = element("profile", HTMLElement);
    if (!this.isEnabled || this.corners.length < 2) return;
    const column = (value: (point: ProfilePoint) => number | undefined) => this.profile.map((point) => value(point) ?? null);
    const data = [
      this.profile.map(({ distance }) => distance / 1000),
      column(({ height, error }) => (height === undefined || error === undefined ? undefined : height + error)),
      column(({ height, error }) => (height === undefined || error === undefined ? undefined : height - error)),
      column(({ height }) => height),
    ];
    this.chart = new uPlot(this.chartOptions(holder), data as uPlot.AlignedData, holder);
  }

  private chartOptions(holder: HTMLElement): uPlot.Options {
    const style = getComputedStyle(holder);
    const axis = { stroke: style.color, grid: { stroke: "rgb(128 128 128 / 25%)", width: 1 }, ticks: { show: false }, font: `11px ${style.fontFamily}` };
    return {
      width: holder.clientWidth,
      height: CHART_HEIGHT,
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false } },
      scales: { x: { time: false } },
      axes: [
        { ...axis, size: 22, values: (_, ticks) => ticks.map((kilometres) => `${kilometres} km`) },
        { ...axis, size: 54, values: (_, ticks) => ticks.map((height) => `${height} m`) },
      ],
      series: [{}, { width: 0, points: { show: false } }, { width: 0, points: { show: false } }, { stroke: "#e4572e", width: 2, points: { show: false } }],
      bands: [{ series: [1, 2], fill: "rgb(228 87 46 / 22%)" }],
      hooks: { setCursor: [({ cursor }) => this.markAt(cursor.idx)] },
    };
  }

  private markAt(index: number | null | undefined): void {
    this.lines.markAt(index == null ? undefined : this.grounds[index]?.position);
    this.viewer.redraw();
  }
}

/** How far the difference of two heights may be off, where both were measured. */
function doubt(first: ProfilePoint, last: ProfilePoint): string {
  const isMeasured = first.error !== undefined && last.error !== undefined;
  return isMeasured ? `± ${(first.error + last.error).toFixed(1)} m` : "m (filled ground)";
}

const metres = (length: number) => (length < 1000 ? `${length.toFixed(1)} m` : `${(length / 1000).toFixed(3)} km`);
const squareMetres = (size: number) => (size < 1e5 ? `${size.toFixed(0)} m²` : `${(size / 1e6).toFixed(3)} km²`);

function save(name: string, type: string, text: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}
