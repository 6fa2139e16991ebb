// From one picture to the next without a jump: where each vertex that is drawn was before, and where it will be.
//
// Two pictures are two covers of the ground by tiles at levels of detail. While one becomes the other, the finer tiles of both
// are drawn, and each vertex moves on a straight line between its spots in both:
//
//   spots(tile, picture):  if the picture shows the tile        where its level of detail draws each vertex
//                          else a tile above it, from the parent  each vertex of the tile's coarsest surface is one of the
//                                                                 parent's finest: it is at that one's spot
//
// A tile's own spots and an ancestor's make, at either end, the very surface of that picture: a vertex that is not in yet is with
// its representative. But along a side, two tiles have their own representatives of a vertex that both are going to show.
// There it is put where it stands on the coarse side instead, on the straight line between the two vertices of that around it:
// both tiles compute that alike, to the bit, from the side alone. A vertex that neither picture shows stays with its
// representative. So neighbours meet at every moment.
//
// A parent of which finer levels are not there has not all vertices of its children's coarsest surfaces. Those that it has not begin
// on the surface that it shows, at their place in plan, or on its side, as above: the first moment then is not the very picture
// before, but near to it.

import { Triangle, Vector3 } from "three";
import { keyOf, parentOf, type Address } from "./address.ts";
import { COARSEST_DETAIL, drawnPrefix, finestDetail, isSameDetail, placesOf, type Detail } from "./partition.ts";
import { tileBounds } from "./frame.ts";
import { PlanSurface } from "./plan_surface.ts";
import { onSide, sideVertices, type PlacedTile, type SideVertex, type Spot } from "./spots.ts";
import type { Tile } from "./tile.ts";

/** A tile as a picture shows it. */
export interface ShownTile extends Detail {
  readonly address: Address;
}

/** A tile to draw while pictures change: where each vertex begins and ends. */
export interface Moving<S extends ShownTile> {
  readonly address: Address;
  readonly from: readonly Spot[];
  readonly to: readonly Spot[];
  /** What the pictures show of its square: itself or a tile above. */
  readonly before: S;
  readonly after: S;
}

/** Where the vertices of a tile are in a picture. */
interface Placement {
  readonly spots: readonly Spot[];
  /** Vertices of sides that the picture shows coarse: where they stand on the coarse side. */
  readonly onCoarseSide: ReadonlyMap<number, Spot>;
}

/** The vertices of a tile's coarsest surface. */
interface Family {
  /** Another one, once the parent has more levels. */
  readonly parent: PlacedTile;
  readonly coarsest: readonly Spot[];
  /** Which of the parent's finest surface each is; -1 if that has none there. */
  readonly inParent: Int32Array;
}

/** Two pictures, and the tiles that are drawn from one to the other. */
export class Morph<S extends ShownTile> {
  /** What was found out of tiles that may move again. */
  private readonly families = new WeakMap<PlacedTile, Family>();
  private readonly sides = new WeakMap<Tile, SideVertex[][]>();

  /** `tileAt` gives those that are loaded; what is not, appears and vanishes at once. */
  constructor(private readonly tileAt: (address: Address) => PlacedTile | undefined) {}

  /** Tiles of the second picture that are in the first one with the same level of detail are not among them. */
  between(before: ReadonlyMap<string, S>, after: ReadonlyMap<string, S>): Moving<S>[] {
    const first = [...after.values()].flatMap((shown) => this.refined(shown, shownAbove(before, shown.address)));
    const second = [...before.values()].flatMap((shown) => this.coarsened(shown, shownAbove(after, shown.address)));
    return [...first, ...second];
  }

  /** A tile of the second picture which the first shows, too, or one above it. */
  private refined(after: S, before: S | undefined): Moving<S>[] {
    if (before === undefined || (keyOf(before.address) === keyOf(after.address) && isSameDetail(before, after))) return [];
    return this.moving(after.address, before, after);
  }

  /** A tile of the first picture above which the second shows one. */
  private coarsened(before: S, after: S | undefined): Moving<S>[] {
    if (after === undefined || keyOf(before.address) === keyOf(after.address)) return [];
    return this.moving(before.address, before, after);
  }

  private moving(address: Address, before: S, after: S): Moving<S>[] {
    const placed = this.tileAt(address);
    const [from, to] = [before, after].map((shown) => placed && this.placement(placed, shown));
    if (from === undefined || to === undefined) return [];
    return [{ address, from: apart(from, to), to: apart(to, from), before, after }];
  }

  /** Undefined where a tile on the way up is not loaded. */
  private placement(placed: PlacedTile, shown: ShownTile): Placement | undefined {
    const { tile } = placed;
    if (keyOf(tile.address) === keyOf(shown.address)) {
      const spots = spotsAt(placed, placesOf(tile, shown));
      return { spots, onCoarseSide: this.hidden(tile, spots, shown.fineSides) };
    }
    const parent = this.tileAt(parentOf(tile.address));
    const above = parent && this.placement(parent, shown);
    if (parent === undefined || above === undefined) return undefined;
    const surface = new PlanSurface(parent.tile, placesOf(parent.tile, finestDetail(parent.tile)), above.spots);
    const { coarsest, inParent } = this.family(placed, parent);
    const spots = coarsest.map((spot, at) => {
      const vertex = inParent[at]!;
      if (vertex < 0) return surface.at(spot) ?? spot;
      // What the parent hides on its sides, this tile's coarsest surface shows.
      return above.onCoarseSide.get(vertex) ?? above.spots[vertex]!;
    });
    return { spots, onCoarseSide: this.hidden(tile, spots, COARSEST_DETAIL.fineSides) };
  }

  private family(placed: PlacedTile, parent: PlacedTile): Family {
    const known = this.families.get(placed);
    if (known?.parent.tile === parent.tile) return known;
    const coarsest = spotsAt(placed, placesOf(placed.tile, COARSEST_DETAIL));
    const [west, south, east, north] = tileBounds(placed.tile.address);
    const vertices = new Map<string, number>();
    placesOf(parent.tile, finestDetail(parent.tile)).forEach((place, vertex) => {
      const spot = parent.spots[place]!;
      const isInSquare = spot.longitude >= west && spot.longitude <= east && spot.latitude >= south && spot.latitude <= north;
      if (isInSquare) vertices.set(placeKey(spot), vertex);
    });
    const family = { parent, coarsest, inParent: Int32Array.from(coarsest, (spot) => vertices.get(placeKey(spot)) ?? -1) };
    this.families.set(placed, family);
    return family;
  }

  /** The vertices of coarse sides that only fine ones show. */
  private hidden(tile: Tile, spots: readonly Spot[], fineSides: readonly boolean[]): Map<number, Spot> {
    const hidden = new Map<number, Spot>();
    const sides = this.sides.get(tile) ?? sideVertices(tile);
    this.sides.set(tile, sides);
    for (const [side, vertices] of sides.entries()) {
      if (fineSides[side] === true) continue;
      vertices.forEach(({ vertex, along, isFine }, at) => {
        if (!isFine) return;
        const before = vertices.slice(0, at).findLast((other) => !other.isFine);
        const after = vertices.slice(at).find((other) => !other.isFine);
        if (before !== undefined && after !== undefined) hidden.set(vertex, onSide(spots, before, after, along));
      });
    }
    return hidden;
  }
}

function spotsAt({ spots }: PlacedTile, places: Uint32Array): Spot[] {
  return Array.from(places, (place) => spots[place]!);
}

/** How many triangles hold all that a moving tile has in both pictures. */
export function movingPrefix<S extends ShownTile>(tile: Tile, { before, after }: Moving<S>): number {
  const own = [before, after].filter(({ address }) => keyOf(address) === keyOf(tile.address));
  return Math.max(...own.map((shown) => drawnPrefix(tile, shown)));
}

/** Moments at which the way of vertices is held against the triangles around them; at the first, most have no area. */
const MOMENTS = [0.3, 0.65, 1];
const CORNERS = [0, 1, 2] as const;

/**
 * How far the ground moves across itself, at most, from one picture to the other: what a vertex slides along its triangles does not
 * show. `scale` tells how large a metre is at a place.
 */
export function largestMotion<S extends ShownTile>(tile: Tile, moving: Moving<S>, scale: (place: Vector3) => number): number {
  const { from, to } = moving;
  const ways = to.map(({ position }, vertex) => position.clone().sub(from[vertex]!.position));
  const isStill = Uint8Array.from(ways, (way) => Number(way.lengthSq() === 0));
  const [plane, triangle] = [new Vector3(), new Triangle()];
  const corners = [triangle.a, triangle.b, triangle.c] as const;
  const end = 3 * movingPrefix(tile, moving);
  let most = 0;
  for (let at = 0; at < end; at += 3) {
    const vertices = [tile.corners[at]!, tile.corners[at + 1]!, tile.corners[at + 2]!] as const;
    if (isStill[vertices[0]] && isStill[vertices[1]] && isStill[vertices[2]]) continue;
    for (const moment of MOMENTS) {
      for (const n of CORNERS) corners[n].copy(from[vertices[n]]!.position).addScaledVector(ways[vertices[n]]!, moment);
      triangle.getNormal(plane);
      for (const n of CORNERS) most = Math.max(most, Math.abs(plane.dot(ways[vertices[n]]!)) * scale(corners[n]));
    }
  }
  return most;
}

/** The spots of one picture, where those that only the other one shows are apart from their representatives. */
function apart(placement: Placement, other: Placement): Spot[] {
  return placement.spots.map((spot, vertex) => (other.onCoarseSide.has(vertex) ? spot : (placement.onCoarseSide.get(vertex) ?? spot)));
}

/** The tile of a picture that is this one or above it. */
function shownAbove<S>(picture: ReadonlyMap<string, S>, address: Address): S | undefined {
  for (let at = address; ; at = parentOf(at)) {
    const found = picture.get(keyOf(at));
    if (found !== undefined || at.zoom === 0) return found;
  }
}

const placeKey = ({ longitude, latitude }: Spot) => `${longitude},${latitude}`;
