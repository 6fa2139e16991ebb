// Which tiles to draw, each at which level of detail: a restricted quadtree by screen-space error.
//
//   want:    from the roots down, refine what is visible and too coarse at its finest
//   close:   whoever is refined needs its neighbours on the map at its own zoom, so their parents are refined too
//   allow:   from the roots down, refine what is wanted, has its children loaded and its neighbours on the map
//   draw:    the leaves; a side is fine where the neighbour is refined, which needs the finest interior
//   fit:     if that is more than the budget, all of it again for a larger tolerance
//   request: children of what is wanted, where it gains most; coarse ones before finer ones that need them
//
// A tile comes level by level. Its first one is enough to be loaded, and all that a tile out of sight, or above others that are
// drawn, is asked for. What has not come limits what is drawn: a tile is at the finest level that is there; it gives way to its
// children only if those beside it that stay have the side that has to be fine; and where no level that is there is good
// enough, its children are drawn if they can be.
//
// Hence drawn neighbours are at most one zoom apart and meet vertex to vertex whatever has been loaded so far, and there is no
// hole below a root that is loaded. The same rule in Rust, for tiles that are loaded whole, is core/src/selection; both answer
// tests/selection/cases.json.

import { childrenOf, keyOf, neighboursOf, parentOf, type Address } from "./address.ts";
import { distanceTo, solidAngle, type OrientedBox } from "./oriented_box.ts";
import type { Detail } from "./partition.ts";
import { screenSpaceError, Sight, type Camera } from "./sight.ts";

/** An interior level of a tile. */
export interface Level {
  /** Certified, metres. */
  readonly error: number;
  readonly triangles: number;
  /** What it takes in memory. */
  readonly bytes: number;
}

/** What is known of the tiles. */
export interface Hierarchy {
  readonly roots: readonly Address[];
  exists(address: Address): boolean;
  /** Holds the tile and everything below it. */
  bounds(address: Address): OrientedBox;
  /** At least one, coarsest first; of a tile that is not loaded, what is known of its finest is enough. */
  levels(address: Address): readonly Level[];
  /** How many of its levels are there, its four sides among them; 0 if it is not loaded, and infinity if all are. */
  levelsThere(address: Address): number;
}

/** How well a picture has to look, and what it may cost. */
export interface Demand {
  /** Largest screen-space error, pixels. */
  readonly tolerance: number;
  /** What was drawn finer before stays until a coarser level errs by at most this share of the tolerance: above 0, at most 1. */
  readonly keep: number;
  /** Most triangles of the tiles in sight. */
  readonly triangles: number;
  /** Most bytes of all tiles. */
  readonly bytes: number;
}

/** A tile to draw. */
export interface Choice extends Detail {
  readonly address: Address;
  /** Certified error of what is drawn, metres. */
  readonly error: number;
}

/** A tile to load. */
export interface TileRequest {
  readonly address: Address;
  /** How many of its levels are needed, its sides among them. */
  readonly levels: number;
}

/** What to draw now, and what to load. */
export interface Selection {
  /** Cover what the roots cover, each place once. */
  readonly choices: readonly Choice[];
  /** Tiles of which levels are missing, most urgent first. */
  readonly requests: readonly TileRequest[];
  /** The tolerance that the budget permits, pixels. */
  readonly tolerance: number;
}

/** Tolerances that are tried for a budget, each by this factor larger than the one before. */
const STEP = 1.25;
/** So many of them; the next one is infinite. */
const STEPS = 64;
const SIDES = 4;

/** Chooses tiles and levels for a camera. `before` are the choices of the picture before. */
export function select(hierarchy: Hierarchy, camera: Camera, demand: Demand, before: readonly Choice[]): Selection {
  return new Selector(new Scene(hierarchy, camera, levelsBefore(hierarchy, before)), demand).fit();
}

/** The level that each tile was drawn at, and of those above them the number of their levels. */
function levelsBefore(hierarchy: Hierarchy, choices: readonly Choice[]): Map<string, number> {
  const before = new Map<string, number>();
  for (const { address, interior } of choices) {
    before.set(keyOf(address), interior);
    for (let above = address; above.zoom > 0; ) {
      above = parentOf(above);
      if (before.has(keyOf(above))) break;
      before.set(keyOf(above), hierarchy.levels(above).length);
    }
  }
  return before;
}

/** A tile that was met. */
interface Seen {
  readonly address: Address;
  readonly parent: Seen | undefined;
  readonly levels: readonly Level[];
  /** How many of them, and then of the sides, are there. */
  readonly there: number;
  readonly bounds: OrientedBox;
  /** Of the eye from the nearest point of its box. */
  readonly distance: number;
  /** The level that it was drawn at; the number of its levels if it was refined; 0 if it was not drawn. */
  readonly before: number;
  children?: readonly Seen[];
  neighbours?: readonly (Seen | undefined)[];
  isVisible?: boolean;
}

/** What one selection has found out about tiles, each asked for once. */
class Scene {
  readonly roots: readonly Seen[];
  private readonly sight: Sight;
  private readonly seen = new Map<string, Seen>();

  constructor(
    private readonly hierarchy: Hierarchy,
    private readonly camera: Camera,
    private readonly before: ReadonlyMap<string, number>,
  ) {
    this.sight = new Sight(camera);
    this.roots = hierarchy.roots.map((root) => this.meet(root));
  }

  children(tile: Seen): readonly Seen[] {
    const existing = () => childrenOf(tile.address).filter((child) => this.hierarchy.exists(child));
    return (tile.children ??= existing().map((child) => this.meet(child, tile)));
  }

  /** Across the west, south, east and north side. */
  neighbours(tile: Seen): readonly (Seen | undefined)[] {
    const across = (near: Address | undefined) =>
      near !== undefined && this.hierarchy.exists(near) ? this.meet(near) : undefined;
    return (tile.neighbours ??= neighboursOf(tile.address).map(across));
  }

  /** Whether any of its children is loaded. They are not met, for they are not needed. */
  hasChildrenThere(tile: Seen): boolean {
    return childrenOf(tile.address).some((child) => this.hierarchy.levelsThere(child) > 0);
  }

  /** The parents of a tile and of its neighbours. */
  parentsBeside(tile: Seen): Seen[] {
    return [tile, ...this.neighbours(tile)].flatMap((near) => near?.parent ?? []);
  }

  isVisible(tile: Seen): boolean {
    return (tile.isVisible ??= this.sight.sees(tile.bounds));
  }

  /**
   * The coarsest level whose error on the screen is at most `tolerance` pixels, or at most `keep` of that where a finer one
   * was drawn before; -1 if none is good enough.
   */
  levelNeeded({ levels, before, distance }: Seen, { tolerance, keep }: Demand): number {
    const isEnough = ({ error }: Level, index: number) =>
      screenSpaceError(error, distance, this.camera) <= tolerance * (index < before ? keep : 1);
    return levels.findIndex(isEnough);
  }

  /** What becomes better on the screen where a level is not enough: its error there × area there; infinite where the eye is in the tile's box. */
  gain({ levels, bounds, distance }: Seen, level: number): number {
    if (distance === 0) return Infinity;
    const { eye, pixelsPerRadian } = this.camera;
    const area = solidAngle(bounds, eye) * pixelsPerRadian * pixelsPerRadian;
    return screenSpaceError(levels[level]?.error ?? 0, distance, this.camera) * area;
  }

  private meet(address: Address, parent?: Seen): Seen {
    const key = keyOf(address);
    const known = this.seen.get(key);
    if (known !== undefined) return known;
    const bounds = this.hierarchy.bounds(address);
    const met: Seen = {
      address,
      parent: parent ?? (address.zoom > 0 ? this.meet(parentOf(address)) : undefined),
      levels: this.hierarchy.levels(address),
      there: this.hierarchy.levelsThere(address),
      bounds,
      distance: distanceTo(bounds, this.camera.eye),
      before: this.before.get(key) ?? 0,
    };
    this.seen.set(key, met);
    return met;
  }
}

/** Tiles to be refined. */
class Refinements {
  private readonly byZoom: Seen[][] = [];
  /** What refining each gains, or what those gain that need it. */
  private readonly gains = new Map<Seen, number>();

  raise(tile: Seen, gain: number): void {
    const known = this.gains.get(tile);
    if (known === undefined) (this.byZoom[tile.address.zoom] ??= []).push(tile);
    this.gains.set(tile, Math.max(known ?? gain, gain));
  }

  has(tile: Seen): boolean {
    return this.gains.has(tile);
  }

  gain(tile: Seen): number {
    return this.gains.get(tile) ?? 0;
  }

  /** Coarse before fine. */
  all(): Seen[] {
    return this.byZoom.flat();
  }

  /** Those of each zoom, coarse before fine. */
  zooms(): readonly (readonly Seen[])[] {
    return Array.from(this.byZoom, (tiles) => tiles ?? []);
  }

  /** From the deepest on, for those that are added need others above them. */
  close(scene: Scene): void {
    for (let zoom = this.byZoom.length - 1; zoom > 0; zoom--) {
      for (const tile of this.byZoom[zoom]!) {
        for (const parent of scene.parentsBeside(tile)) this.raise(parent, this.gain(tile));
      }
    }
  }
}

type Drawn = ReadonlyMap<Seen, Choice>;

class Selector {
  constructor(
    private readonly scene: Scene,
    private readonly demand: Demand,
  ) {}

  /** What the budget permits when all is loaded is asked for; of what is loaded, what it permits now is drawn. */
  fit(): Selection {
    const [step, asked] = this.leastAffordable(0, (demand) => {
      const wanted = this.wanted(demand, allLevels);
      return { wanted, tolerance: demand.tolerance, drawn: this.draw(wanted, demand, allLevels) };
    });
    const allowed = this.allowed(asked.wanted);
    const isThere = ([tile, choice]: [Seen, Choice]) => tile.there >= this.levelsNeeded(tile, choice);
    const isComplete = asked.wanted.all().every((tile) => allowed.has(tile)) && [...asked.drawn].every(isThere);
    const drawn = isComplete ? asked.drawn : this.drawnNow(step);
    const choices = [...drawn].flatMap(([tile, choice]) => (tile.there > 0 ? atMost(levelsNow(tile), tile, choice) : []));
    return { choices, requests: this.requests(asked.wanted, asked.drawn), tolerance: asked.tolerance };
  }

  /** What the budget permits of what is loaded, for a tolerance from a step on. */
  private drawnNow(step: number): Drawn {
    const make = (demand: Demand) => ({ drawn: this.draw(this.allowed(this.wanted(demand, levelsNow)), demand, levelsNow) });
    return this.leastAffordable(step, make)[1].drawn;
  }

  /** What is made of the least tolerance tried, from a step on, that is within the budget; if none is, of an infinite one. */
  private leastAffordable<T extends { drawn: Drawn }>(first: number, make: (demand: Demand) => T): [number, T] {
    const made = (step: number) => make({ ...this.demand, tolerance: this.toleranceOf(step) });
    const asked = made(first);
    if (this.isAffordable(asked.drawn)) return [first, asked];
    let [tooFine, coarse] = [first, STEPS];
    let best: T | undefined;
    while (coarse - tooFine > 1) {
      const middle = Math.floor((tooFine + coarse) / 2);
      const tried = made(middle);
      if (this.isAffordable(tried.drawn)) [coarse, best] = [middle, tried];
      else tooFine = middle;
    }
    return [coarse, best ?? made(STEPS)];
  }

  private toleranceOf(step: number): number {
    if (step === STEPS) return Infinity;
    let { tolerance } = this.demand;
    for (let done = 0; done < step; done++) tolerance *= STEP;
    return tolerance;
  }

  /** The visible tiles that are too coarse at the finest of so many levels, and what their neighbours need. */
  private wanted(demand: Demand, levels: (tile: Seen) => number): Refinements {
    const wanted = new Refinements();
    const visit = (tile: Seen): void => {
      if (this.isEnough(tile, levels(tile), demand) || !this.scene.isVisible(tile)) return;
      const children = this.scene.children(tile);
      if (children.length === 0) return;
      wanted.raise(tile, this.scene.gain(tile, tile.levels.length - 1));
      children.forEach(visit);
    };
    this.scene.roots.forEach(visit);
    wanted.close(this.scene);
    return wanted;
  }

  private isEnough(tile: Seen, levels: number, demand: Demand): boolean {
    const needed = this.scene.levelNeeded(tile, demand);
    return needed >= 0 && needed < levels;
  }

  /**
   * Those that what is loaded permits: all children are there, all neighbours beside them are on the map, and those that stay have
   * the side that then is fine.
   */
  private allowed(wanted: Refinements): Refinements {
    const allowed = new Refinements();
    for (const tiles of wanted.zooms()) {
      const possible = new Set(tiles.filter((tile) => this.canGiveWay(tile, allowed)));
      const isFitting = (tile: Seen) =>
        this.scene.neighbours(tile).every((near, side) => near === undefined || possible.has(near) || hasSide(near, (side + 2) % 4));
      // One that stays after all may be beside others.
      for (let count = Infinity; count > possible.size; ) {
        count = possible.size;
        for (const tile of possible) if (!isFitting(tile)) possible.delete(tile);
      }
      for (const tile of possible) allowed.raise(tile, wanted.gain(tile));
    }
    return allowed;
  }

  private canGiveWay(tile: Seen, allowed: Refinements): boolean {
    const areLoaded = this.scene.children(tile).every(({ there }) => there > 0);
    return areLoaded && this.scene.parentsBeside(tile).every((parent) => allowed.has(parent));
  }

  /** The leaves below refinements, at one of so many levels. */
  private draw(refined: Refinements, demand: Demand, levels: (tile: Seen) => number): Drawn {
    const fineSides = this.fineSides(refined);
    const drawn = new Map<Seen, Choice>();
    const visit = (tile: Seen): void => {
      if (refined.has(tile)) this.scene.children(tile).forEach(visit);
      else drawn.set(tile, this.choice(tile, fineSides.get(tile) ?? [false, false, false, false], levels(tile), demand));
    };
    this.scene.roots.forEach(visit);
    return drawn;
  }

  /** Of each tile, the sides that have a refined one across. */
  private fineSides(refined: Refinements): Map<Seen, boolean[]> {
    const fine = new Map<Seen, boolean[]>();
    for (const tile of refined.all()) {
      this.scene.neighbours(tile).forEach((near, side) => {
        if (near === undefined) return;
        const sides = fine.get(near) ?? [false, false, false, false];
        sides[(side + 2) % 4] = true;
        fine.set(near, sides);
      });
    }
    return fine;
  }

  private choice(tile: Seen, fineSides: readonly boolean[], levels: number, demand: Demand): Choice {
    const needed = fineSides.includes(true) ? -1 : this.scene.levelNeeded(tile, demand);
    const interior = needed < 0 ? tile.levels.length - 1 : needed;
    return atMost(levels, tile, { address: tile.address, interior, fineSides, error: tile.levels[interior]!.error });
  }

  private isAffordable(drawn: Drawn): boolean {
    let [triangles, bytes] = [0, 0];
    for (const [tile, { interior }] of drawn) {
      const level = tile.levels[interior]!;
      bytes += level.bytes;
      if (this.scene.isVisible(tile)) triangles += level.triangles;
    }
    return triangles <= this.demand.triangles && bytes <= this.demand.bytes;
  }

  private requests(wanted: Refinements, drawn: Drawn): TileRequest[] {
    const roots = this.scene.roots.map((tile) => ({ gain: Infinity, tile }));
    const children = wanted.all().flatMap((parent) => {
      const gain = wanted.gain(parent);
      return this.scene.children(parent).map((tile) => ({ gain, tile }));
    });
    const asked = [...roots, ...children].map(({ gain, tile }) => {
      const levels = this.levelsWanted(tile, drawn.get(tile));
      return { gain: tile.there === 0 ? gain : this.gainOfRest(tile, wanted), tile, levels };
    });
    const missing = asked.filter(({ tile, levels }) => tile.there < levels);
    missing.sort((a, b) => descending(a.gain, b.gain) || inOrder(a.tile.address, b.tile.address));
    return missing.map(({ tile, levels }) => ({ address: tile.address, levels }));
  }

  private levelsWanted(tile: Seen, choice: Choice | undefined): number {
    if (choice === undefined || tile.there === 0) return 1;
    // What children show that are there grows out of all that this one shows.
    const comesBack = this.scene.isVisible(tile) && this.scene.hasChildrenThere(tile);
    return comesBack ? tile.levels.length + SIDES : this.levelsNeeded(tile, choice);
  }

  /** Up to the interior level of a choice, or to the last of the sides that are fine; of what is out of sight, one is enough. */
  private levelsNeeded(tile: Seen, { interior, fineSides }: Choice): number {
    const lastSide = fineSides.lastIndexOf(true);
    if (lastSide >= 0) return tile.levels.length + lastSide + 1;
    return this.scene.isVisible(tile) ? interior + 1 : 1;
  }

  /** What more levels of a tile gain, or what those gain that need one of its sides fine. */
  private gainOfRest(tile: Seen, wanted: Refinements): number {
    const beside = this.scene.neighbours(tile).map((near) => (near === undefined ? 0 : wanted.gain(near)));
    return Math.max(this.scene.gain(tile, Math.min(tile.there, tile.levels.length) - 1), ...beside);
  }
}

/** How many interior levels of a tile there will be. */
const allLevels = ({ levels }: Seen): number => levels.length;
/** And how many there are; of one that is not loaded, there will be those that are expected. */
const levelsNow = ({ levels, there }: Seen): number => (there === 0 ? levels.length : Math.min(levels.length, there));

/** The same choice, not finer than so many levels are. */
function atMost(count: number, { levels }: Seen, choice: Choice): Choice {
  const interior = Math.min(choice.interior, count - 1);
  return interior === choice.interior ? choice : { ...choice, interior, error: levels[interior]!.error };
}

/** Whether a side can be fine; that of a root that is not loaded meets nothing. */
function hasSide({ levels, there }: Seen, side: number): boolean {
  return there === 0 || there > levels.length + side;
}

function descending(a: number, b: number): number {
  return a === b ? 0 : a > b ? -1 : 1;
}

function inOrder(a: Address, b: Address): number {
  return a.zoom - b.zoom || a.x - b.x || a.y - b.y;
}
