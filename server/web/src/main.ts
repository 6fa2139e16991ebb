// The page: lists the tilesets, opens the first, keeps the panel up to date.

import * as hud from "./hud.ts";
import type { Stats } from "./terrain_layer.ts";
import { listTilesets } from "./tileset.ts";
import { Viewer } from "./viewer.ts";

declare global {
  interface Window {
    /** For tests and the console. */
    terrain: {
      stats(): Stats | undefined;
      settled(): Promise<void>;
      setMaxPixels(pixels: number): void;
      setWireframe(visible: boolean): void;
      flyTo: Viewer["flyTo"];
    };
  }
}

async function start(): Promise<void> {
  const viewer = new Viewer(document.querySelector<HTMLCanvasElement>("#view")!, () => {
    const stats = viewer.stats();
    if (stats === undefined) return;
    hud.showStats(stats);
    hud.showMessage(viewer.failure);
  });
  hud.connect(viewer);
  const tilesets = await listTilesets();
  hud.offer(tilesets, (tileset) => viewer.open(tileset));
  viewer.open(tilesets[0]!);
  window.terrain = {
    stats: () => viewer.stats(),
    settled: () => viewer.settled(),
    setMaxPixels: (pixels) => hud.set("pixels", pixels),
    setWireframe: (visible) => hud.set("wireframe", visible),
    flyTo: (...place) => viewer.flyTo(...place),
  };
}

start().catch((error: unknown) => hud.showMessage(error instanceof Error ? error.message : String(error)));
