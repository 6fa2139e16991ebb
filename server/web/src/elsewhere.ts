// Archives that are shown but not in sight: the page says where they are, and leads there.

import { EARTH, azimuthOf } from "./earth.ts";
import type { Bounds } from "./frame.ts";
import type { Place } from "./coordinates.ts";
import { element } from "./elements.ts";
import { isLocal } from "./tileset.ts";
import type { Viewer } from "./viewer.ts";
import type { Views } from "./views.ts";

const DIRECTIONS = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];

/** Where the middle of data is from a place above the ground, in words; `bounds` in degrees. */
export function wayTo([west, south, east, north]: Bounds, from: Place): string {
  const eastwards = (((from.longitude - west) % 360) + 360) % 360;
  if (eastwards <= east - west && from.latitude >= south && from.latitude <= north) return "straight below";
  const middle = { longitude: (west + east) / 2, latitude: (south + north) / 2 };
  const kilometres = EARTH.way(from, middle).length / 1000;
  const direction = DIRECTIONS[Math.round((azimuthOf(from, middle) + 360) / 45) % 8]!;
  return `${Number(kilometres.toPrecision(kilometres < 100 ? 2 : 3)).toLocaleString("en")} km to the ${direction}`;
}

/** One notice for each view of whose archive nothing is to be seen. */
export class Elsewhere {
  private readonly list = element("elsewhere", HTMLElement);
  private shown = "";

  constructor(private readonly views: Views) {}

  /** Call it after frames. */
  frameWasDrawn(): void {
    const { all } = this.views;
    const lost = all.filter(({ hasDataInSight }) => !hasDataInSight);
    const isOnEarth = all.every(({ tileset }) => tileset === undefined || !isLocal(tileset.metadata));
    const texts = lost.map((viewer) => this.textFor(viewer, isOnEarth));
    // What is being clicked has to stay.
    if (texts.join("\n") === this.shown) return;
    this.shown = texts.join("\n");
    this.list.replaceChildren(...lost.map((viewer, at) => this.notice(texts[at]!, viewer)));
  }

  /** From ground that is nowhere on the Earth there is no way. */
  private textFor({ tileset, pose }: Viewer, isOnEarth: boolean): string {
    const way = isOnEarth && tileset && pose ? `: ${wayTo(tileset.metadata.bounds, pose)}` : "";
    return `${tileset?.name} is not in sight${way}.`;
  }

  private notice(text: string, viewer: Viewer): HTMLElement {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: "Go there" });
    button.addEventListener("click", () => this.views.lookAtAllOf(viewer));
    const notice = document.createElement("p");
    notice.append(text, " ", button);
    return notice;
  }
}
