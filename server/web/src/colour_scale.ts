// Between which heights the colours of the ground are, and below which height it is sea.

import { MathUtils } from "three";
import { datumOf, isLocal, type Metadata } from "./tileset.ts";

/** What colours of heights mean. */
export interface ColourScale {
  /** Metres at the first and the last colour. */
  readonly ends: readonly [number, number];
  /** Metres below which all is sea; undefined where nothing is known to be. */
  readonly seaLevel: number | undefined;
}

/** What a tile tells of the data below it: heights of its vertices, and how far the data may be from its surface, metres. */
export interface TileHeights {
  readonly lowest: number;
  readonly highest: number;
  readonly error: number;
}

/** Metres. The bed of the Dead Sea is at −730 m, and no land below the sea is beside deeper water. */
const SHALLOWEST_SEA_FLOOR = -750;
/** Metres above the ellipsoid: the sea is nowhere lower, by the geoid EGM2008. */
const LOWEST_SEA_LEVEL = -107;
/** An end of a scale stays until it is known so much better: colours that change with each tile tell nothing. */
const BETTER = 0.5;

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

/**
 * The scale of one archive. An archive says between which heights all of its surfaces are, and those of coarse zooms go far
 * beyond its data. So the scale is narrowed by what is drawn: tiles that cover all data tell where these end, within their errors.
 */
export class DataHeights {
  private readonly lowest: End;
  private readonly highest: End;

  constructor(private readonly metadata: Metadata) {
    const { heights: [lowest, highest], zooms } = metadata;
    const error = Math.max(...zooms.map((zoom) => zoom.coarsest_error));
    this.lowest = new End(lowest, [lowest, Math.min(lowest + error, highest)]);
    this.highest = new End(highest, [Math.max(highest - error, lowest), highest]);
  }

  /** Of tiles that together cover all data. */
  learn(tiles: readonly TileHeights[]): void {
    const least = (heightOf: (tile: TileHeights) => number) => Math.min(...tiles.map(heightOf));
    const most = (heightOf: (tile: TileHeights) => number) => Math.max(...tiles.map(heightOf));
    this.lowest.improve(least(({ lowest }) => lowest), [least(({ lowest, error }) => lowest - error), least(({ lowest, error }) => lowest + error)]);
    this.highest.improve(most(({ highest }) => highest), [most(({ highest, error }) => highest - error), most(({ highest, error }) => highest + error)]);
  }

  get scale(): ColourScale {
    return { ends: [this.lowest.height, this.highest.height], seaLevel: this.seaLevel };
  }

  /** Where data surely go deeper than any land they are of the floor of the sea, not of its surface. */
  private get seaLevel(): number | undefined {
    if (isLocal(this.metadata) || this.lowest.atMost >= SHALLOWEST_SEA_FLOOR) return undefined;
    return datumOf(this.metadata).includes("ellipsoid") ? LOWEST_SEA_LEVEL : 0;
  }
}

/** Numbers between which one is. */
type Interval = readonly [number, number];

/** The lowest or the highest of the data. */
class End {
  /** How wide the interval was when the height was taken from what is drawn. */
  private width = Infinity;

  /** A height, and where it is for sure. */
  constructor(
    public height: number,
    private within: Interval,
  ) {}

  get atMost(): number {
    return this.within[1];
  }

  /** Takes a height that is drawn, if it is known much better now, or is the first one. */
  improve(drawn: number, [from, to]: Interval): void {
    this.within = [Math.max(this.within[0], from), Math.min(this.within[1], to)];
    const width = this.within[1] - this.within[0];
    if (width > BETTER * this.width) return;
    this.width = width;
    this.height = MathUtils.clamp(drawn, ...this.within);
  }
}
