// One view, or two whose cameras move as one: what is right in one archive is held against another.

import type { TerrainSettings } from "./terrain_layer.ts";
import type { Tileset } from "./tileset.ts";
import { Viewer } from "./viewer.ts";

/** The view, and the one beside it while there is one. */
export class Views {
  readonly main: Viewer;
  /** The archive beside that of the main view. */
  besideTileset: Tileset | undefined;
  private second: Viewer | undefined;
  private leader: Viewer;
  private settings: Partial<TerrainSettings> = {};

  /** `onFrame` is called after each frame of either. */
  constructor(
    private readonly canvases: readonly [HTMLCanvasElement, HTMLCanvasElement],
    private readonly onFrame: () => void,
  ) {
    this.main = this.viewerOn(canvases[0]);
    this.leader = this.main;
  }

  /** The view beside; undefined while there is none. */
  get beside(): Viewer | undefined {
    return this.besideTileset === undefined ? undefined : this.second;
  }

  get all(): readonly Viewer[] {
    return this.beside === undefined ? [this.main] : [this.main, this.beside];
  }

  set(changes: Partial<TerrainSettings>): void {
    this.settings = { ...this.settings, ...changes };
    for (const viewer of [this.main, this.second]) viewer?.set(changes);
  }

  setFlying(isFlying: boolean): void {
    for (const viewer of [this.main, this.second]) viewer?.setFlying(isFlying);
  }

  /** Shows an archive beside the main one, or nothing. */
  showBeside(tileset: Tileset | undefined): void {
    this.besideTileset = tileset;
    const [, canvas] = this.canvases;
    canvas.hidden = tileset === undefined;
    document.body.classList.toggle("is-split", tileset !== undefined);
    this.lead(this.main);
    if (tileset === undefined) return this.second?.close();
    this.second ??= this.viewerOn(canvas);
    this.second.set({ ...this.settings, heights: this.main.heights });
    this.second.open(tileset);
    this.lead(this.main);
    this.second.follow(this.main);
  }

  /** The main view, which then is the one that moves both. */
  steer(): Viewer {
    this.lead(this.main);
    return this.main;
  }

  private viewerOn(canvas: HTMLCanvasElement): Viewer {
    const viewer: Viewer = new Viewer(canvas, () => {
      if (viewer === this.leader) for (const other of this.all) if (other !== viewer) other.follow(viewer);
      this.onFrame();
    });
    canvas.addEventListener("pointerenter", () => this.lead(viewer));
    canvas.addEventListener("focus", () => this.lead(viewer));
    return viewer;
  }

  private lead(viewer: Viewer): void {
    this.leader = viewer;
    for (const other of [this.main, this.second]) other?.setSteering(other === viewer);
  }
}
