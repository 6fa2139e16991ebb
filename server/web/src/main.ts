// The page: finds the archives to show, opens the first, keeps the panel up to date.
//
// ?server=URL   those of another terrain-server than the one that the page comes from
// ?archive=URL  that archive, straight from any web server; may be given several times

import { openArchive } from "./archive_tileset.ts";
import * as hud from "./hud.ts";
import { Measuring } from "./measuring.ts";
import type { Stats } from "./terrain_layer.ts";
import { listTilesets } from "./server_tilesets.ts";
import { linkOf, readLink } from "./share.ts";
import { datumOf, type Tileset } from "./tileset.ts";
import { Viewer, type Pose } from "./viewer.ts";

declare global {
  interface Window {
    /** For tests and the console. */
    terrain: {
      stats(): Stats | undefined;
      settled(): Promise<void>;
      setMaxPixels(pixels: number): void;
      setWireframe(visible: boolean): void;
      flyTo: Viewer["flyTo"];
      pose(): Pose | undefined;
      groundAt: Viewer["groundAt"];
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
  const canvas = document.querySelector<HTMLCanvasElement>("#view")!;
  let [shown, pointer]: [Tileset | undefined, readonly [number, number]] = [undefined, [0, 0]];
  let resting: ReturnType<typeof setTimeout> | undefined;
  const showPlace = () => hud.showPlace(viewer.groundAt(...pointer), shown === undefined ? "" : datumOf(shown.metadata));
  const keepLink = () => {
    const pose = viewer.pose;
    if (shown !== undefined && pose !== undefined) history.replaceState(null, "", linkOf(shown.name, pose));
  };
  const viewer = new Viewer(canvas, () => {
    const stats = viewer.stats();
    if (stats === undefined) return;
    const middle = viewer.groundAt(0, 0);
    hud.showStats(stats, middle);
    hud.showBearings(middle && viewer.metresPerPixel(middle.distance), viewer.pose?.azimuth ?? 0);
    hud.showLoading(viewer.isLoading);
    hud.showMessage(viewer.failure);
    showPlace();
    measuring.groundMayHaveChanged();
    clearTimeout(resting);
    resting = setTimeout(keepLink, REST_MILLISECONDS);
  });
  const point = ({ offsetX, offsetY }: PointerEvent) => {
    pointer = [(2 * offsetX) / canvas.clientWidth - 1, 1 - (2 * offsetY) / canvas.clientHeight];
    showPlace();
  };
  canvas.addEventListener("pointermove", point);
  canvas.addEventListener("pointerdown", point);
  canvas.addEventListener("pointerleave", () => (pointer = [0, 0]));
  const open = (tileset: Tileset) => viewer.open((shown = tileset));
  const measuring = new Measuring(viewer, canvas, () => (shown === undefined ? "" : datumOf(shown.metadata)));
  hud.connect(viewer, measuring);
  const tilesets = await findTilesets(new URLSearchParams(location.search));
  const link = readLink(location.hash);
  const linked = tilesets.find(({ name }) => name === link?.name);
  hud.offer(tilesets, linked ?? tilesets[0]!, open);
  open(linked ?? tilesets[0]!);
  if (linked !== undefined && link !== undefined) viewer.setPose(link.pose);
  window.terrain = {
    stats: () => viewer.stats(),
    settled: () => viewer.settled(),
    setMaxPixels: (pixels) => hud.set("pixels", pixels),
    setWireframe: (visible) => hud.set("wireframe", visible),
    pose: () => viewer.pose,
    groundAt: (x, y) => viewer.groundAt(x, y),
    metresAboveGround: () => viewer.metresAboveGround(),
    flyTo: (...place) => viewer.flyTo(...place),
  };
}

start().catch((error: unknown) => hud.showMessage(error instanceof Error ? error.message : String(error)));
