// Between which heights the colours of the ground are, and below which height it is sea.

import { datumOf, isLocal, type Metadata } from "./tileset.ts";

/** What colours of heights mean. */
export interface ColourScale {
  /** Metres at the first and the last colour. */
  readonly ends: readonly [number, number];
  /** Metres below which all is sea; undefined where nothing is known to be. */
  readonly seaLevel: number | undefined;
}

/** Metres. The bed of the Dead Sea is at −730 m, and no land below the sea is beside deeper water. */
const SHALLOWEST_SEA_FLOOR = -750;
/** Metres above the ellipsoid: the sea is nowhere lower, by the geoid EGM2008. */
const LOWEST_SEA_LEVEL = -107;

/** The scale of one archive: that of its samples. Older archives tell only of surfaces, and coarse ones go far beyond. */
export function colourScaleOf(metadata: Metadata): ColourScale {
  return { ends: metadata.source?.heights ?? metadata.heights, seaLevel: seaLevelOf(metadata) };
}

/** Where samples are deeper than any land they are of the floor of the sea, not of its surface. */
function seaLevelOf(metadata: Metadata): number | undefined {
  const lowest = metadata.source?.heights?.[0];
  if (lowest === undefined || lowest >= SHALLOWEST_SEA_FLOOR || isLocal(metadata)) return undefined;
  return datumOf(metadata).includes("ellipsoid") ? LOWEST_SEA_LEVEL : 0;
}

/** The scale that serves all that is shown. */
export function commonScale(scales: readonly ColourScale[]): ColourScale {
  const seaLevels = scales.flatMap(({ seaLevel }) => seaLevel ?? []);
  return {
    ends: [Math.min(...scales.map(({ ends }) => ends[0])), Math.max(...scales.map(({ ends }) => ends[1]))],
    seaLevel: seaLevels.length > 0 ? Math.min(...seaLevels) : undefined,
  };
}

export function isSameScale(one: ColourScale | undefined, other: ColourScale | undefined): boolean {
  return one?.seaLevel === other?.seaLevel && one?.ends[0] === other?.ends[0] && one?.ends[1] === other?.ends[1];
}
