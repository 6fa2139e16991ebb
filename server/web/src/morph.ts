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
import { degreesOf, keyOf, parentOf, type Address } from "./address.ts";
import { tileBounds, type Frame } from "./frame.ts";
import { COARSEST_DETAIL, drawnPrefix, finestDetail, isSameDetail, placesOf, type Detail } from "./partition.ts";
import { interiorLevels, type Tile } from "./spt.ts";

/** A place that a vertex is drawn at. */
export interface Spot {
  /** Degrees. */
  readonly longitude: number;
  readonly latitude: number;
  /** Metres. */
  readonly height: number;
  /** In the frame. */
  readonly position: Vector3;
  /** The tile that has it among its places, and which one it is; where it is none of a tile's, this is not said. */
  readonly own: { readonly tile: Tile; readonly place: number } | undefined;
}

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

/** Two pictures, and the tiles that are drawn from one to the other. */
export class Morph<S extends ShownTile> {
  private readonly placesAsSpots = new Map<Tile, (Spot | undefined)[]>();

  /** `tileAt` gives those that are loaded; what is not, appears and vanishes at once. */
  constructor(
    private readonly frame: Frame,
    private readonly tileAt: (address: Address) => Tile | undefined,
  ) {}

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
    const tile = this.tileAt(address);
    const [from, to] = [before, after].map((shown) => tile && this.placement(tile, shown));
    if (from === undefined || to === undefined) return [];
    return [{ address, from: apart(from, to), to: apart(to, from), before, after }];
  }

  /** Undefined where a tile on the way up is not loaded. */
  private placement(tile: Tile, shown: ShownTile): Placement | undefined {
    if (keyOf(tile.address) === keyOf(shown.address)) {
      const spots = this.spotsAt(tile, placesOf(tile, shown));
      return { spots, onCoarseSide: this.hidden(tile, spots, shown.fineSides) };
    }
    const parent = this.tileAt(parentOf(tile.address));
    const above = parent && this.placement(parent, shown);
    if (parent === undefined || above === undefined) return undefined;
    const places = placesOf(parent, finestDetail(parent));
    const finest = this.spotsAt(parent, places);
    // What the parent hides on its sides, this tile's coarsest surface shows.
    const spotAt = new Map(finest.map((spot, vertex) => [placeKey(spot), above.onCoarseSide.get(vertex) ?? above.spots[vertex]!]));
    const coarsest = this.spotsAt(tile, placesOf(tile, COARSEST_DETAIL));
    const surface = new PlanSurface(parent, places, above.spots);
    const spots = coarsest.map((spot) => spotAt.get(placeKey(spot)) ?? surface.at(spot) ?? spot);
    return { spots, onCoarseSide: this.hidden(tile, spots, COARSEST_DETAIL.fineSides) };
  }

  private spotsAt(tile: Tile, places: Uint32Array): Spot[] {
    const known = this.placesAsSpots.get(tile) ?? [];
    this.placesAsSpots.set(tile, known);
    return Array.from(places, (place) => (known[place] ??= this.spotOf(tile, place)));
  }

  /** Longitudes and latitudes are exact, whichever tile they are told from: few bits of 45 degrees over a power of two. */
  private spotOf(tile: Tile, place: number): Spot {
    const [west, south] = tileBounds(tile.address);
    const degreesPerUnit = degreesOf(tile.address.zoom) / 2 ** tile.extentBits;
    const [x = 0, y = 0, height = 0] = tile.positions.subarray(3 * place, 3 * place + 3);
    const [longitude, latitude] = [west + x * degreesPerUnit, south + y * degreesPerUnit];
    return { longitude, latitude, height, position: this.frame.position(longitude, latitude, height), own: { tile, place } };
  }

  /** The vertices of coarse sides that only fine ones show. */
  private hidden(tile: Tile, spots: readonly Spot[], fineSides: readonly boolean[]): Map<number, Spot> {
    const hidden = new Map<number, Spot>();
    for (const [side, vertices] of sideVertices(tile).entries()) {
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

function between(from: Spot, to: Spot, share: number): Spot {
  const mixed = (a: number, b: number) => a + (b - a) * share;
  return {
    longitude: mixed(from.longitude, to.longitude),
    latitude: mixed(from.latitude, to.latitude),
    height: mixed(from.height, to.height),
    position: from.position.clone().lerp(to.position, share),
    own: undefined,
  };
}

/** Where a place on a side is between two vertices of it: alike for the tiles on both sides, to the bit. */
function onSide(spots: readonly Spot[], before: SideVertex, after: SideVertex, along: number): Spot {
  return between(spots[before.vertex]!, spots[after.vertex]!, (along - before.along) / (after.along - before.along));
}

/** Cells along a side of the grid that triangles are found by. */
const CELLS = 32;

/** A tile's finest surface as a map in plan to where a picture has its vertices. */
class PlanSurface {
  private readonly unitsPerDegree: number;
  private sides: SideVertex[][] | undefined;
  /** The triangles that touch each cell, by their first corner. */
  private cells: number[][] | undefined;

  constructor(
    private readonly tile: Tile,
    /** Which of the tile's positions each vertex is at in plan. */
    private readonly places: Uint32Array,
    private readonly spots: readonly Spot[],
  ) {
    this.unitsPerDegree = 2 ** tile.extentBits / degreesOf(tile.address.zoom);
  }

  /** Undefined where the tile has no surface. */
  at({ longitude, latitude }: Spot): Spot | undefined {
    const [west, south] = tileBounds(this.tile.address);
    const [x, y] = [(longitude - west) * this.unitsPerDegree, (latitude - south) * this.unitsPerDegree];
    return this.onSides(x, y) ?? this.inside(x, y);
  }

  private onSides(x: number, y: number): Spot | undefined {
    const extent = 2 ** this.tile.extentBits;
    const side = [x === 0, y === 0, x === extent, y === extent].indexOf(true);
    if (side < 0) return undefined;
    const along = side % 2 === 0 ? y : x;
    const vertices = (this.sides ??= sideVertices(this.tile))[side]!;
    const before = vertices.findLast((other) => other.along < along);
    const after = vertices.find((other) => other.along > along);
    return before && after && onSide(this.spots, before, after, along);
  }

  private inside(x: number, y: number): Spot | undefined {
    const { corners } = this.tile;
    for (const at of (this.cells ??= this.inCells())[this.cellOf(y) * CELLS + this.cellOf(x)]!) {
      const [a, b, c] = [corners[at]!, corners[at + 1]!, corners[at + 2]!];
      const [ofA, ofB, ofC] = [this.twiceArea(b, c, x, y), this.twiceArea(c, a, x, y), this.twiceArea(a, b, x, y)];
      if (ofA < 0 || ofB < 0 || ofC < 0 || ofA + ofB + ofC === 0) continue;
      const aside = between(this.spots[a]!, this.spots[b]!, ofA + ofB === 0 ? 0 : ofB / (ofA + ofB));
      return between(aside, this.spots[c]!, ofC / (ofA + ofB + ofC));
    }
    return undefined;
  }

  private inCells(): number[][] {
    const { corners } = this.tile;
    const cells: number[][] = Array.from({ length: CELLS * CELLS }, () => []);
    for (let at = 0; at < corners.length; at += 3) {
      const [[left, right], [low, high]] = [0, 1].map((axis) => {
        const along = [0, 1, 2].map((corner) => this.cellOf(this.coordinate(corners[at + corner]!, axis)));
        return [Math.min(...along), Math.max(...along)];
      }) as [[number, number], [number, number]];
      for (let row = low; row <= high; row++) for (let column = left; column <= right; column++) cells[row * CELLS + column]!.push(at);
    }
    return cells;
  }

  private cellOf(units: number): number {
    return Math.min(CELLS - 1, Math.floor((CELLS * units) / 2 ** this.tile.extentBits));
  }

  private coordinate(vertex: number, axis: number): number {
    return this.tile.positions[3 * this.places[vertex]! + axis]!;
  }

  /** Of the triangle of two vertices and a place; negative if it is clockwise. */
  private twiceArea(from: number, to: number, x: number, y: number): number {
    const [fromX, fromY] = [this.coordinate(from, 0), this.coordinate(from, 1)];
    return (this.coordinate(to, 0) - fromX) * (y - fromY) - (x - fromX) * (this.coordinate(to, 1) - fromY);
  }
}

interface SideVertex {
  readonly vertex: number;
  /** Lattice units along the side, northwards or eastwards. */
  readonly along: number;
  /** Whether only the fine side shows it. */
  readonly isFine: boolean;
}

/** The vertices on the west, south, east and north side, in order along it. */
function sideVertices(tile: Tile): SideVertex[][] {
  const extent = 2 ** tile.extentBits;
  const interiorEnd = tile.levels[interiorLevels(tile) - 1]!.vertexEnd;
  const sides: SideVertex[][] = [[], [], [], []];
  for (let vertex = 0; vertex < tile.representatives.length; vertex++) {
    const [x = 0, y = 0] = tile.positions.subarray(3 * vertex, 3 * vertex + 2);
    const isFine = vertex >= interiorEnd;
    [x === 0, y === 0, x === extent, y === extent].forEach((isOn, side) => {
      if (isOn) sides[side]!.push({ vertex, along: side % 2 === 0 ? y : x, isFine });
    });
  }
  return sides.map((vertices) => vertices.sort((a, b) => a.along - b.along));
}

/** The tile of a picture that is this one or above it. */
function shownAbove<S>(picture: ReadonlyMap<string, S>, address: Address): S | undefined {
  for (let at = address; ; at = parentOf(at)) {
    const found = picture.get(keyOf(at));
    if (found !== undefined || at.zoom === 0) return found;
  }
}

const placeKey = ({ longitude, latitude }: Spot) => `${longitude},${latitude}`;
