// Which tiles to draw, each at which level of detail: a restricted quadtree by screen-space error.
//
//   want:    from the roots down, refine what is visible and too coarse at its finest
//   close:   whoever is refined needs its neighbours on the map at its own zoom, so their parents are refined too
//   allow:   from the roots down, refine what is wanted, has its children loaded and its neighbours on the map
//   draw:    the leaves; a side is fine where the neighbour is refined, which needs the finest interior
//   fit:     if that is more than the budget, all of it again for a larger tolerance
//   request: children of what is wanted, where it gains most; coarse ones before finer ones that need them
//
// Hence drawn neighbours are at most one zoom apart and meet vertex to vertex whatever has been loaded so far, and there is no
// hole below a root that is loaded. The same rule in Rust is core/src/selection; both answer tests/selection/cases.json.

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

/** What to draw now, and what to load. */
export interface Selection {
  /** Cover what the roots cover, each place once. */
  readonly choices: readonly Choice[];
  /** Tiles that are not loaded, most urgent first. */
  readonly requests: readonly Address[];
  /** The tolerance that the budget permits, pixels. */
  readonly tolerance: number;
}

/** Tolerances that are tried for a budget, each by this factor larger than the one before. */
const STEP = 1.25;
/** So many of them; the next one is infinite. */
const STEPS = 64;

/** Chooses tiles and levels for a camera. `before` are the choices of the picture before. */
export function select(
  hierarchy: Hierarchy,
  camera: Camera,
  demand: Demand,
  isLoaded: (address: Address) => boolean,
  before: readonly Choice[],
): Selection {
  return new Selector(new Scene(hierarchy, camera, levelsBefore(hierarchy, before)), demand, isLoaded).fit();
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

  /** What refining makes better on the screen: error there × area there; infinite where the eye is in the tile's box. */
  gain({ levels, bounds, distance }: Seen): number {
    if (distance === 0) return Infinity;
    const { eye, pixelsPerRadian } = this.camera;
    const area = solidAngle(bounds, eye) * pixelsPerRadian * pixelsPerRadian;
    return screenSpaceError(levels.at(-1)?.error ?? 0, distance, this.camera) * area;
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
    private readonly isLoaded: (address: Address) => boolean,
  ) {}

  /** What the budget permits when all is loaded is asked for; of what is loaded, what it permits now is drawn. */
  fit(): Selection {
    const [step, asked] = this.leastAffordable(0, (demand) => {
      const wanted = this.wanted(demand);
      return { wanted, tolerance: demand.tolerance, drawn: this.draw(wanted, demand) };
    });
    const allowed = this.allowed(asked.wanted);
    const isComplete = asked.wanted.all().every((tile) => allowed.has(tile));
    const drawn = isComplete ? asked.drawn : this.drawnNow(step);
    const choices = [...drawn.values()].filter(({ address }) => this.isLoaded(address));
    return { choices, requests: this.requests(asked.wanted), tolerance: asked.tolerance };
  }

  /** What the budget permits of what is loaded, for a tolerance from a step on. */
  private drawnNow(step: number): Drawn {
    const make = (demand: Demand) => ({ drawn: this.draw(this.allowed(this.wanted(demand)), demand) });
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

  /** The visible tiles that are too coarse at their finest, and what their neighbours need. */
  private wanted(demand: Demand): Refinements {
    const wanted = new Refinements();
    const visit = (tile: Seen): void => {
      if (this.scene.levelNeeded(tile, demand) >= 0 || !this.scene.isVisible(tile)) return;
      const children = this.scene.children(tile);
      if (children.length === 0) return;
      wanted.raise(tile, this.scene.gain(tile));
      children.forEach(visit);
    };
    this.scene.roots.forEach(visit);
    wanted.close(this.scene);
    return wanted;
  }

  /** Those that what is loaded permits: all children are there, and all neighbours beside them are on the map. */
  private allowed(wanted: Refinements): Refinements {
    const allowed = new Refinements();
    for (const tile of wanted.all()) {
      const areLoaded = this.scene.children(tile).every(({ address }) => this.isLoaded(address));
      if (areLoaded && this.scene.parentsBeside(tile).every((parent) => allowed.has(parent))) {
        allowed.raise(tile, wanted.gain(tile));
      }
    }
    return allowed;
  }

  /** The leaves below refinements. */
  private draw(refined: Refinements, demand: Demand): Drawn {
    const fineSides = this.fineSides(refined);
    const drawn = new Map<Seen, Choice>();
    const visit = (tile: Seen): void => {
      if (refined.has(tile)) this.scene.children(tile).forEach(visit);
      else drawn.set(tile, this.choice(tile, fineSides.get(tile) ?? [false, false, false, false], demand));
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

  private choice(tile: Seen, fineSides: readonly boolean[], demand: Demand): Choice {
    const needed = fineSides.includes(true) ? -1 : this.scene.levelNeeded(tile, demand);
    const interior = needed < 0 ? tile.levels.length - 1 : needed;
    return { address: tile.address, interior, fineSides, error: tile.levels[interior]!.error };
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

  private requests(wanted: Refinements): Address[] {
    const roots = this.scene.roots.map((tile) => ({ gain: Infinity, tile }));
    const children = wanted.all().flatMap((parent) => {
      const gain = wanted.gain(parent);
      return this.scene.children(parent).map((tile) => ({ gain, tile }));
    });
    const missing = [...roots, ...children].filter(({ tile }) => !this.isLoaded(tile.address));
    missing.sort((a, b) => descending(a.gain, b.gain) || inOrder(a.tile.address, b.tile.address));
    return missing.map(({ tile }) => tile.address);
  }
}

function descending(a: number, b: number): number {
  return a === b ? 0 : a > b ? -1 : 1;
}

function inOrder(a: Address, b: Address): number {
  return a.zoom - b.zoom || a.x - b.x || a.y - b.y;
}
