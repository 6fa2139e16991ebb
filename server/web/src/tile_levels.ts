// The levels of the tile in the middle of the view, one after the other.

import { keyOf, type Address } from "./address.ts";
import { element, setText } from "./elements.ts";
import type { TileLevelView } from "./terrain_layer.ts";
import type { Viewer } from "./viewer.ts";

/** Shows one tile alone while it is enabled, at the level that a slider tells. */
export class TileLevels {
  private tile: { readonly address: Address; readonly levels: readonly TileLevelView[] } | undefined;
  private readonly slider = element("level", HTMLInputElement);

  constructor(private readonly viewer: Viewer) {
    this.slider.addEventListener("input", () => this.show());
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
    const nothing = "There is no tile in the middle of the view.";
    setText("level-text", level === undefined ? nothing : `Tile ${keyOf(this.tile!.address)}, ${textOf(level, this.tile!.levels.length)}`);
  }
}

function textOf({ detail, error, triangles }: TileLevelView, count: number): string {
  const name = detail.fineSides.includes(true) ? "with its own zoom's sides" : `level ${detail.interior + 1} of ${count - 1}`;
  return `${name}: ${triangles.toLocaleString("en")} triangles, ± ${error.toPrecision(3)} m`;
}
