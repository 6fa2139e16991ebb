// The panel over the view: settings in, figures out.

import type { Stats } from "./terrain_layer.ts";
import { heightsAbove, type Tileset } from "./tileset.ts";
import type { Viewer } from "./viewer.ts";

const ORBIT_HELP = "drag: orbit · right drag: move · wheel: zoom · F: fly · X: wireframe · R: reset";
const FLY_HELP = "WASD: move · Q/E: down/up · drag: look · wheel: speed · Shift: faster · F: orbit · R: reset";

function element<T extends HTMLElement>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`The page has no ${type.name} "${id}".`);
  return found;
}

const input = (id: string) => element(id, HTMLInputElement);
const setText = (id: string, text: string) => (element(id, HTMLElement).textContent = text);

/** Connects the panel and the keyboard to the viewer. */
export function connect(viewer: Viewer): void {
  connectRange("pixels", (pixels) => viewer.setMaxPixels(pixels), " px");
  connectRange("exaggeration", (factor) => viewer.setExaggeration(factor), " ×");
  connectSwitch("wireframe", "KeyX", (visible) => viewer.setWireframe(visible));
  connectSwitch("flying", "KeyF", (flying) => {
    viewer.setFlying(flying);
    setText("help", flying ? FLY_HELP : ORBIT_HELP);
  });
  onKey("KeyR", () => viewer.lookAtAll());
}

/** Sets a slider or a switch as if the user had. */
export function set(id: "pixels" | "wireframe", value: number | boolean): void {
  const control = input(id);
  if (typeof value === "boolean") control.checked = value;
  else control.value = String(value);
  control.dispatchEvent(new Event("input"));
}

/** Shows the name, or a choice where there are several tilesets. */
export function offer(tilesets: readonly Tileset[], open: (tileset: Tileset) => void): void {
  const select = element("tileset", HTMLSelectElement);
  select.append(...tilesets.map(({ name }) => new Option(name)));
  select.hidden = tilesets.length < 2;
  element("name", HTMLElement).hidden = !select.hidden;
  setText("name", tilesets[0]?.name ?? "");
  const showHeights = (tileset?: Tileset) => setText("heights", tileset ? heightsAbove(tileset.metadata) : "");
  showHeights(tilesets[0]);
  select.addEventListener("change", () => {
    const chosen = tilesets[select.selectedIndex];
    select.blur();
    showHeights(chosen);
    if (chosen !== undefined) open(chosen);
  });
}

/** Shows what is drawn. */
export function showStats({ tiles, triangles, zooms, error, bytes }: Stats): void {
  setText("tiles", tiles.toLocaleString("en"));
  setText("triangles", triangles.toLocaleString("en"));
  setText("zooms", zooms === undefined ? "–" : [...new Set(zooms)].join(" – "));
  setText("error", tiles === 0 ? "–" : `± ${formatMetres(error)}`);
  setText("bytes", `${(bytes / 1e6).toFixed(2)} MB`);
}

/** Shows one line about what is wrong, or takes it away. */
export function showMessage(message: string | undefined): void {
  element("message", HTMLElement).hidden = message === undefined;
  setText("message", message ?? "");
}

/** Never shows less than the error is. */
function formatMetres(metres: number): string {
  const digits = metres < 10 ? 2 : metres < 100 ? 1 : 0;
  return `${(Math.ceil(metres * 10 ** digits) / 10 ** digits).toFixed(digits)} m`;
}

function connectRange(id: string, apply: (value: number) => void, unit: string): void {
  const range = input(id);
  const update = () => {
    setText(`${id}-value`, `${range.valueAsNumber}${unit}`);
    apply(range.valueAsNumber);
  };
  range.addEventListener("input", update);
  update();
}

function connectSwitch(id: string, key: string, apply: (on: boolean) => void): void {
  const box = input(id);
  const update = () => apply(box.checked);
  box.addEventListener("input", update);
  box.addEventListener("change", () => box.blur());
  onKey(key, () => {
    box.checked = !box.checked;
    update();
  });
  update();
}

function onKey(code: string, act: () => void): void {
  window.addEventListener("keydown", (event) => {
    const isOurs = event.code === code && !event.repeat && !event.ctrlKey && !event.metaKey && !event.altKey;
    if (isOurs && !(event.target instanceof HTMLSelectElement)) act();
  });
}
