// The page: finds the archives to show, opens the first, keeps the panel up to date.
//
// ?server=URL   those of another terrain-server than the one that the page comes from
// ?archive=URL  that archive, straight from any web server; may be given several times
// ?pixels=N     how many pixels what is drawn may be off

import { openArchive } from "./archive_tileset.ts";
import type { Coordinates } from "./coordinates.ts";
import { ContourLabels } from "./contour_labels.ts";
import { EARTH } from "./earth.ts";
import { element } from "./elements.ts";
import { Elsewhere } from "./elsewhere.ts";
import * as hud from "./hud.ts";
import { PLANE_METRES } from "./local_ground.ts";
import { Measuring } from "./measuring.ts";
import type { Pose } from "./pose.ts";
import type { Stats } from "./terrain_layer.ts";
import { listTilesets } from "./server_tilesets.ts";
import { linkOf, readLink } from "./share.ts";
import { TileLevels } from "./tile_levels.ts";
import { datumOf, isLocal, type Tileset } from "./tileset.ts";
import type { Viewer } from "./viewer.ts";
import { Views } from "./views.ts";

declare global {
  interface Window {
    /** For tests and the console. */
    terrain: {
      stats(): Stats | undefined;
      settled(): Promise<void>;
      rested(): Promise<void>;
      setMaxPixels(pixels: number): void;
      setWireframe(visible: boolean): void;
      flyTo: Viewer["flyTo"];
      pose(): Pose | undefined;
      setPose(pose: Pose): void;
      besidePose(): Pose | undefined;
      groundAt: Viewer["groundAt"];
      pixelOf: Viewer["pixelOf"];
      metresAboveGround(): number | undefined;
    };
  }
}

/** How long the view has to rest before the address follows it: browsers allow few changes. */
const REST_MILLISECONDS = 400;

/** What the page's address asks for. */
function findTilesets(query: URLSearchParams): Promise<Tileset[]> {
  const archives = query.getAll("archive");
  return archives.length > 0 ? Promise.all(archives.map(openArchive)) : listTilesets(query.get("server") ?? "");
}

async function start(): Promise<void> {
  const canvases = [element("view", HTMLCanvasElement), element("beside", HTMLCanvasElement)] as const;
  const nowhere = { canvas: canvases[0], x: 0, y: 0 };
  let [shown, pointer]: [Tileset | undefined, typeof nowhere] = [undefined, nowhere];
  let linkFault: string | undefined;
  let resting: ReturnType<typeof setTimeout> | undefined;
  const datum = () => (shown === undefined ? "" : datumOf(shown.metadata));
  const coordinates = (): Coordinates => (shown !== undefined && isLocal(shown.metadata) ? PLANE_METRES : EARTH);
  const showPlace = () => {
    const isBeside = views.beside !== undefined && pointer.canvas === canvases[1];
    const [under, other] = isBeside ? [views.beside!, views.main] : [views.main, views.beside];
    const ground = under.groundAt(pointer.x, pointer.y);
    // The other sees the same in the same place.
    const place = ground ?? other?.groundAt(pointer.x, pointer.y);
    const below = (viewer: Viewer | undefined) => (viewer === under ? ground : place && viewer?.groundBelow(place.longitude, place.latitude));
    hud.showPlace(below(views.main), coordinates(), datum(), below(views.beside));
  };
  // However often the pointer moves, one place is looked for a frame: the newest.
  let nextPlace: number | undefined;
  const showPlaceSoon = () => {
    nextPlace ??= requestAnimationFrame(() => {
      nextPlace = undefined;
      showPlace();
    });
  };
  const keepLink = () => {
    const pose = views.main.pose;
    if (shown !== undefined && pose !== undefined) history.replaceState(null, "", `${location.search}${linkOf(shown.name, pose, coordinates().isLocal)}`);
  };
  const views = new Views(canvases, () => {
    const viewer = views.main;
    const stats = viewer.stats();
    if (stats === undefined) return;
    const middle = viewer.groundAt(0, 0);
    hud.showStats(stats, middle);
    hud.showColours(views);
    hud.showBearings(middle && viewer.metresPerPixel(middle.distance), viewer.bearing ?? 0);
    hud.showLoading(views.all.some(({ isLoading }) => isLoading));
    hud.showMessage(views.all.map(({ failure }) => failure).find((failure) => failure !== undefined) ?? linkFault);
    elsewhere.frameWasDrawn();
    showPlaceSoon();
    measuring.groundMayHaveChanged();
    labels.frameWasDrawn();
    levels.frameWasDrawn();
    clearTimeout(resting);
    resting = setTimeout(keepLink, REST_MILLISECONDS);
  });
  for (const canvas of canvases) {
    const point = ({ offsetX, offsetY }: PointerEvent) => {
      pointer = { canvas, x: (2 * offsetX) / canvas.clientWidth - 1, y: 1 - (2 * offsetY) / canvas.clientHeight };
      showPlaceSoon();
    };
    canvas.addEventListener("pointermove", point);
    canvas.addEventListener("pointerdown", point);
    canvas.addEventListener("pointerdown", () => (linkFault = undefined));
    canvas.addEventListener("pointerleave", () => (pointer = nowhere));
  }
  const open = (tileset: Tileset) => {
    linkFault = undefined;
    if (shown !== undefined) hud.set("tile-levels", false);
    views.steer().open((shown = tileset));
  };
  const measuring = new Measuring(views.main, canvases[0], coordinates, datum);
  const labels = new ContourLabels(views.main, element("contour-labels", HTMLElement));
  const levels = new TileLevels(views.main, canvases[0]);
  const elsewhere = new Elsewhere(views);
  hud.connect(views, measuring, levels);
  const tilesets = await findTilesets(new URLSearchParams(location.search));
  const choose = hud.offer(tilesets, open);
  const followLink = () => {
    const link = readLink(location.hash);
    const linked = tilesets.find(({ name }) => name === link?.name);
    const wanted = linked ?? shown ?? tilesets[0]!;
    if (wanted !== shown) choose(wanted);
    else if (linked !== undefined) views.steer().lookAtAll();
    if (linked !== undefined && link?.pose !== undefined) views.steer().setPose(link.pose);
    linkFault = link === undefined || linked !== undefined ? undefined : `There is no tileset “${link.name}” here; this is ${wanted.name}.`;
    views.main.redraw();
  };
  followLink();
  addEventListener("hashchange", followLink);
  hud.offerBeside(tilesets, (tileset) => views.showBeside(tileset));
  window.terrain = {
    stats: () => views.main.stats(),
    settled: async () => void (await Promise.all(views.all.map((viewer) => viewer.settled()))),
    rested: async () => void (await Promise.all(views.all.map((viewer) => viewer.rested()))),
    setMaxPixels: (pixels) => hud.set("pixels", pixels),
    setWireframe: (visible) => hud.set("wireframe", visible),
    pose: () => views.main.pose,
    setPose: (pose) => views.steer().setPose(pose),
    besidePose: () => views.beside?.pose,
    groundAt: (x, y) => views.main.groundAt(x, y),
    pixelOf: (place) => views.main.pixelOf(place),
    metresAboveGround: () => views.main.metresAboveGround(),
    flyTo: (...place) => views.steer().flyTo(...place),
  };
}

start().catch((error: unknown) => hud.showMessage(error instanceof Error ? error.message : String(error)));
