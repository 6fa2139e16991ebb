// The panel over the view: settings in, figures out.

import type { Coordinates } from "./coordinates.ts";
import { element, setText } from "./elements.ts";
import type { GroundPoint } from "./ground.ts";
import { templateFault, type Imagery } from "./imagery.ts";
import { connectDark, connectSwitch, onKey } from "./keys.ts";
import { showLegend } from "./legend.ts";
import type { Measuring } from "./measuring.ts";
import { STYLES } from "./shaders.ts";
import type { Stats } from "./terrain_layer.ts";
import type { TileLevels } from "./tile_levels.ts";
import { heightsAbove, isLocal, type Tileset } from "./tileset.ts";
import type { Views } from "./views.ts";

const ORBIT_HELP = "drag: orbit · right drag: move · wheel: zoom · arrows, +, −: move, zoom · F: fly · X: wireframe · R: reset";
const TOUCH_HELP = "one finger: orbit · two: move, zoom";
const TOUCH_FLY_HELP = "one finger: look · two: move, apart: forward, together: back";
const FLY_HELP = "WASD: move · Q/E: down/up · drag: look · wheel: speed · Shift: faster · F: orbit · R: reset";

/** Pixels: on a narrower page the panel and its parts are folded at first. */
const NARROW = 600;
/** Pixels that the scale bar has at most. */
const SCALE_PIXELS = 100;
const IMAGERY_STYLE = STYLES.indexOf("Imagery");

const input = (id: string) => element(id, HTMLInputElement);

/** Connects the panel and the keyboard to the viewer. */
export function connect(views: Views, measuring: Measuring, levels: TileLevels): void {
  input("pixels").value = new URLSearchParams(location.search).get("pixels") ?? "2";
  connectRange("pixels", (maxPixels) => views.set({ maxPixels }), " px");
  connectRange("exaggeration", (exaggeration) => views.set({ exaggeration }), " ×");
  connectSwitch("contours", "KeyC", (contours) => views.set({ contours }));
  connectSwitch("filled", "KeyV", (filled) => {
    views.set({ filled });
    showFilledLegend();
  });
  connectSwitch("light", "KeyL", (detailedLight) => views.set({ detailedLight }));
  connectDark();
  connectStyles(views);
  connectImagery(views);
  connectShare();
  element("north", HTMLElement).addEventListener("click", () => views.steer().faceNorth());
  for (const id of ["panel", "more", "figures"]) element(id, HTMLDetailsElement).open = innerWidth >= NARROW;
  connectSwitch("measuring", "KeyM", (isEnabled) => measuring.setEnabled(isEnabled));
  connectSwitch("tile-levels", "KeyT", (isEnabled) => levels.setEnabled(isEnabled));
  connectSwitch("wireframe", "KeyX", (wireframe) => views.set({ wireframe }));
  const hasFingers = matchMedia("(pointer: coarse)").matches;
  connectSwitch("flying", "KeyF", (flying) => {
    views.setFlying(flying);
    const [orbitHelp, flyHelp] = hasFingers ? [TOUCH_HELP, TOUCH_FLY_HELP] : [ORBIT_HELP, FLY_HELP];
    setText("help", flying ? flyHelp : orbitHelp);
  });
  onKey("KeyR", () => views.steer().lookAtAll());
  element("all", HTMLElement).addEventListener("click", () => views.steer().lookAtAll());
}

function connectStyles(views: Views): void {
  const select = element("style", HTMLSelectElement);
  select.append(...STYLES.map((style) => new Option(style)));
  select.addEventListener("input", () => {
    views.set({ style: select.selectedIndex });
    showColours(views);
    showFilledLegend();
  });
}

/** Shows what colours mean. */
export function showColours(views: Views): void {
  if (views.colours !== undefined) showLegend(element("style", HTMLSelectElement).selectedIndex, views.colours, views.beside !== undefined);
}

/** Wherever filled ground is told apart. */
function showFilledLegend(): void {
  const isErrorStyle = STYLES[element("style", HTMLSelectElement).selectedIndex] === "Certified error";
  element("legend-filled", HTMLElement).hidden = !isErrorStyle && !input("filled").checked;
}

/** The address of the page names the imagery, and whose it is if that is known. */
function connectImagery(views: Views): void {
  const field = input("imagery");
  const query = new URLSearchParams(location.search);
  field.value = query.get("imagery") ?? "";
  const show = () => {
    const imagery = imageryOf(field.value.trim(), query.get("attribution"));
    views.set({ imagery });
    setText("attribution", imagery?.attribution ?? "");
    element("attribution", HTMLElement).hidden = imagery === undefined;
    const select = element("style", HTMLSelectElement);
    select.options[IMAGERY_STYLE]!.disabled = imagery === undefined;
    const isNew = imagery !== undefined || select.selectedIndex === IMAGERY_STYLE;
    if (isNew) select.selectedIndex = imagery === undefined ? 0 : IMAGERY_STYLE;
    select.dispatchEvent(new Event("input"));
  };
  field.addEventListener("change", () => {
    const template = field.value.trim();
    field.setCustomValidity(template === "" ? "" : (templateFault(template) ?? ""));
    if (!field.reportValidity()) return;
    query.delete("attribution");
    if (template === "") query.delete("imagery");
    else query.set("imagery", template);
    history.replaceState(null, "", `?${query}${location.hash}`);
    show();
  });
  show();
}

/** Where nobody says whose the imagery is, its server is named. */
function imageryOf(template: string, attribution: string | null): Imagery | undefined {
  if (template === "" || templateFault(template) !== undefined) return undefined;
  return { template, attribution: attribution ?? `Imagery: ${new URL(template, location.href).hostname}` };
}

/** The address always is that of the view. */
function connectShare(): void {
  const button = element("share", HTMLButtonElement);
  button.addEventListener("click", async () => {
    const isCopied = await navigator.clipboard.writeText(location.href).then(() => true, () => false);
    button.textContent = isCopied ? "Link copied" : "The address bar has the link";
  });
}

/** Sets a slider or a switch as if the user had. */
export function set(id: "pixels" | "wireframe" | "tile-levels", value: number | boolean): void {
  const control = input(id);
  if (typeof value === "boolean") control.checked = value;
  else control.value = String(value);
  control.dispatchEvent(new Event("input"));
}

/** Offers a choice where there are several tilesets, and gives back what chooses one; then its name is shown, and it is opened. */
export function offer(tilesets: readonly Tileset[], open: (tileset: Tileset) => void): (tileset: Tileset) => void {
  const select = element("tileset", HTMLSelectElement);
  select.append(...tilesets.map(({ name }) => new Option(name)));
  select.hidden = tilesets.length < 2;
  const choose = (tileset: Tileset) => {
    const { name, metadata, source } = tileset;
    select.selectedIndex = tilesets.indexOf(tileset);
    setText("name", name);
    setText("heights", heightsAbove(metadata));
    input("light").disabled = source.normals === undefined;
    showWhere(isLocal(metadata));
    open(tileset);
  };
  select.addEventListener("change", () => {
    select.blur();
    choose(tilesets[select.selectedIndex]!);
  });
  return choose;
}

/** What is nowhere on the Earth has no north, and no imagery. */
function showWhere(isNowhere: boolean): void {
  element("needle", HTMLElement).lastChild!.textContent = isNowhere ? "y" : "N";
  const title = isNowhere ? "Turn y up" : "Turn north up";
  const button = element("north", HTMLButtonElement);
  button.title = title;
  button.ariaLabel = title;
  input("imagery").disabled = isNowhere;
}

/** Lets a tileset be chosen for the view beside; the address of the page names it. */
export function offerBeside(tilesets: readonly Tileset[], show: (tileset: Tileset | undefined) => void): void {
  const select = element("beside-tileset", HTMLSelectElement);
  select.append(new Option("–"), ...tilesets.map(({ name }) => new Option(name)));
  element("beside-choice", HTMLElement).hidden = tilesets.length < 2;
  const query = new URLSearchParams(location.search);
  const choose = () => {
    const chosen = tilesets[select.selectedIndex - 1];
    element("beside-name", HTMLElement).hidden = chosen === undefined;
    setText("beside-name", chosen?.name ?? "");
    show(chosen);
  };
  select.addEventListener("change", () => {
    select.blur();
    if (select.selectedIndex === 0) query.delete("beside");
    else query.set("beside", select.value);
    history.replaceState(null, "", `?${query}${location.hash}`);
    choose();
  });
  select.selectedIndex = 1 + tilesets.findIndex(({ name }) => name === query.get("beside"));
  choose();
}

/** Shows what is drawn. */
export function showStats({ tiles, triangles, zooms, bytes, normalsBytes, imageryBytes }: Stats, middle: GroundPoint | undefined): void {
  setText("tiles", tiles.toLocaleString("en"));
  setText("triangles", triangles.toLocaleString("en"));
  setText("zooms", zooms === undefined ? "–" : [...new Set(zooms)].join(" – "));
  setText("error", middle === undefined ? "–" : errorOf(middle));
  setText("bytes", `${megabytes(bytes)} + ${megabytes(normalsBytes + imageryBytes)} MB`);
}

const megabytes = (bytes: number) => (bytes / 1e6).toFixed(2);

/** Shows the ground under the pointer, or in the middle where there is no pointer; and that of the other view. */
export function showPlace(ground: GroundPoint | undefined, coordinates: Coordinates, datum: string, beside: GroundPoint | undefined): void {
  const above = coordinates.isLocal ? "" : ` above ${datum === "unspecified" ? "an unknown datum" : datum}`;
  const heights = [...(ground ? [`${heightOf(ground)}${above}`] : []), ...(beside ? [`beside: ${heightOf(beside)}`] : [])];
  const place = ground ?? beside;
  setText("place", place === undefined ? "" : `${coordinates.textOf(place)}: ${heights.join(" · ")}`);
}

function heightOf(ground: GroundPoint): string {
  const metres = ground.height.toFixed(ground.error !== undefined && ground.error < 1 ? 2 : 1);
  const signed = metres.replace("-", "−");
  return ground.error === undefined ? `${signed} m (filled)` : `${signed} ${errorOf(ground)}`;
}

/** Of ground that was filled, nothing is certified. */
const errorOf = ({ error }: GroundPoint) => (error === undefined ? "filled" : `± ${formatMetres(error)}`);

/** Shows how long so much of the middle of the view is, and where north is. */
export function showBearings(metresPerPixel: number | undefined, azimuth: number): void {
  element("needle", HTMLElement).style.transform = `rotate(${-azimuth}deg)`;
  element("scale", HTMLElement).style.visibility = metresPerPixel === undefined ? "hidden" : "visible";
  if (metresPerPixel === undefined) return;
  const most = metresPerPixel * SCALE_PIXELS;
  const power = 10 ** Math.floor(Math.log10(most));
  const length = power * ([5, 2, 1].find((factor) => factor * power <= most) ?? 1);
  element("scale-bar", HTMLElement).style.width = `${length / metresPerPixel}px`;
  setText("scale-length", length >= 1000 ? `${length / 1000} km` : `${length} m`);
}

/** Shows that something is on its way. */
export function showLoading(isLoading: boolean): void {
  element("loading", HTMLElement).hidden = !isLoading;
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
