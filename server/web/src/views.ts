// One view, or two whose cameras move as one: what is right in one archive is held against another.

import { commonScale, isSameScale, type ColourScale } from "./colour_scale.ts";
import type { TerrainSettings } from "./terrain_layer.ts";
import type { Tileset } from "./tileset.ts";
import { Viewer } from "./viewer.ts";

/** The view, and the one beside it while there is one. */
export class Views {
  readonly main: Viewer;
  private isSplit = false;
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
    return this.isSplit ? this.second : undefined;
  }

  get all(): readonly Viewer[] {
    return this.beside === undefined ? [this.main] : [this.main, this.beside];
  }

  /** What colours of heights mean in all of them; undefined while nothing is shown. */
  get colours(): ColourScale | undefined {
    return this.settings.colours ?? this.main.ownColours;
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
    this.isSplit = tileset !== undefined;
    const [, canvas] = this.canvases;
    canvas.hidden = !this.isSplit;
    document.body.classList.toggle("is-split", this.isSplit);
    if (tileset === undefined) {
      this.second?.close();
    } else {
      this.second ??= this.viewerOn(canvas);
      this.second.set(this.settings);
      this.second.open(tileset);
      this.second.follow(this.main);
    }
    this.lead(this.main);
  }

  /** Looks at all that one of the views shows; the other moves with it. */
  lookAtAllOf(viewer: Viewer): void {
    this.lead(viewer);
    viewer.lookAtAll();
  }

  /** The main view, which then is the one that moves both. */
  steer(): Viewer {
    this.lead(this.main);
    return this.main;
  }

  private viewerOn(canvas: HTMLCanvasElement): Viewer {
    const viewer: Viewer = new Viewer(canvas, () => {
      if (viewer === this.leader) for (const other of this.all) if (other !== viewer) other.follow(viewer);
      this.shareColours();
      this.onFrame();
    });
    canvas.addEventListener("pointerenter", () => this.lead(viewer));
    canvas.addEventListener("focus", () => this.lead(viewer));
    return viewer;
  }

  /** Colours mean the same in both views. */
  private shareColours(): void {
    const colours = this.beside && commonScale(this.all.flatMap(({ ownColours }) => ownColours ?? []));
    if (!isSameScale(colours, this.settings.colours)) this.set({ colours });
  }

  private lead(viewer: Viewer): void {
    this.leader = viewer;
    for (const other of [this.main, this.second]) other?.setSteering(other === viewer);
  }
}
