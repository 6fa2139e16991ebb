// What colours mean: the same stops as in the shader of the terrain.

import type { ColourScale } from "./colour_scale.ts";
import { element, setText } from "./elements.ts";

/** Of land, and at which share of its heights; of the sea, from its floor up. */
const LAND = [["61 102 69", 0], ["115 140 84", 22], ["184 173 120", 45], ["148 117 92", 66], ["168 161 156", 82], ["247 250 255", 96]] as const;
const SEA = "rgb(31 61 94), rgb(66 110 138)";
/** Of the other styles. */
const COLOURS = [
  "",
  "rgb(60 60 60), rgb(240 240 240)",
  "rgb(237 242 230), rgb(250 212 102) 30%, rgb(222 99 51) 60%, rgb(92 23 84)",
  "rgb(43 94 161), rgb(115 194 166) 33%, rgb(250 224 140) 66%, rgb(191 46 38)",
] as const;

function elevationColours({ ends: [lowest, highest], seaLevel = lowest }: ColourScale): string {
  const sea = (100 * (seaLevel - lowest)) / (Math.max(highest, seaLevel) - lowest);
  const land = LAND.map(([colour, share]) => `rgb(${colour}) ${sea + ((100 - sea) * share) / 100}%`);
  return [...(sea > 0 ? [`${SEA} ${sea}%`] : []), ...land].join(", ");
}

/** Shows the colours of a style between their ends, and whether they are those of several archives. */
export function showLegend(style: number, colours: ColourScale, isShared: boolean): void {
  const [lowest, highest] = colours.ends;
  const ends = [[`${Math.floor(lowest)} m`, `${Math.ceil(highest)} m`].map((height) => height.replace("-", "−")), ["shade", "sun"], ["0°", "50°"], ["≤ 0.1 m", "≥ 1 km"]];
  element("legend", HTMLElement).hidden = ends[style] === undefined;
  element("legend-shared", HTMLElement).hidden = !(isShared && style === 0);
  const [low = "", high = ""] = ends[style] ?? [];
  setText("legend-low", low);
  setText("legend-high", high);
  element("legend-colours", HTMLElement).style.background = `linear-gradient(to right, ${style === 0 ? elevationColours(colours) : COLOURS[style] ?? ""})`;
}
