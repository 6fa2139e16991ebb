// The page of curved models: opens a `.clod` file, and draws one of its levels.

import { ModelStage, openModels } from "../model_stage.ts";
import { element, setText } from "../elements.ts";
import { readCurvedLevels, type CurvedLevels } from "./clod.ts";
import { PatchLayer, type Drawn } from "./patch_layer.ts";

declare global {
  interface Window {
    /** For tests and the console. */
    curved: {
      drawn(): Drawn | undefined;
      nearer(factor: number): void;
      frame(): Promise<void>;
    };
  }
}

const PIXELS_OF_ERROR = 0.5;

class CurvedPage {
  private readonly stage = new ModelStage((pixels) => this.draw(pixels));
  private readonly slider = element("level", HTMLInputElement);
  private readonly net = element("net", HTMLInputElement);
  private layer: PatchLayer | undefined;

  constructor() {
    this.slider.addEventListener("input", () => this.setLevel(this.slider.valueAsNumber));
    this.net.addEventListener("input", () => {
      this.layer?.setNet(this.net.checked);
      this.stage.redraw();
    });
  }

  show(levels: CurvedLevels, name: string): void {
    if (this.layer !== undefined) this.stage.scene.remove(this.layer.group);
    this.layer?.dispose();
    this.layer = new PatchLayer(levels);
    this.layer.setNet(this.net.checked);
    this.stage.scene.add(this.layer.group);
    setText("name", name);
    this.slider.disabled = false;
    this.slider.max = String(levels.levelCount - 1);
    this.setLevel(levels.levelCount - 1);
    this.stage.lookAtAll(this.layer.box);
  }

  drawn = () => this.layer?.drawn();
  nearer = (factor: number) => this.stage.nearer(factor);
  frame = () => this.stage.frame();

  private setLevel(level: number): void {
    this.slider.value = String(level);
    setText("level-value", `${level} of ${this.slider.max}`);
    this.layer?.setLevel(level);
    this.stage.redraw();
  }

  private draw(pixels: number): void {
    const { x, y, z } = this.stage.camera.position;
    this.layer?.update({ eye: [x, y, z], pixels, maxPixels: PIXELS_OF_ERROR });
    const drawn = this.drawn();
    if (drawn === undefined) return;
    setText("patches", drawn.patches.toLocaleString("en"));
    setText("triangles", drawn.triangles.toLocaleString("en"));
    setText("error", drawn.error.toExponential(2));
  }
}

const page = new CurvedPage();
window.curved = page;
void openModels("curved.clod", "Drop or open a .clod file.", async (bytes, name) => {
  const levels = readCurvedLevels(bytes);
  return { show: () => page.show(levels, name), close: () => {} };
});
