// A surface that grows by vertex splits. Half-edge 3t + k starts at the kth corner of triangle t.

import { grown } from "./arrays.ts";

const NONE = -1;

/**
 * Part of the triangles around a vertex that goes over to the new one: between two cuts, before one, after one, outside two; or
 * between two of which the first, or the second, becomes a hole of three vertices instead of a triangle.
 */
export const Side = { Inner: 0, Front: 1, Back: 2, Outer: 3, HoleFirst: 4, HoleSecond: 5 } as const;
export type Side = (typeof Side)[keyof typeof Side];

/** Where a star is cut: places of a walk. */
export interface Cuts {
  readonly side: Side;
  readonly first: number;
  readonly second: number;
}

/** Three coordinates. */
export type Point = Float64Array;

/** Puts a point into an array of points. */
export function setPoint(points: Float64Array, at: number, point: Point): void {
  points[3 * at] = point[0]!;
  points[3 * at + 1] = point[1]!;
  points[3 * at + 2] = point[2]!;
}

const next = (edge: number): number => (edge % 3 === 2 ? edge - 2 : edge + 1);
const previous = (edge: number): number => (edge % 3 === 0 ? edge + 2 : edge - 1);
const hasFirst = (side: Side): boolean => side !== Side.Front;
const hasSecond = (side: Side): boolean => side !== Side.Back;

/** Most neighbours of a vertex that splits. */
export const MOST_NEIGHBOURS = 1024;

/** The walk around a vertex, counter-clockwise: half-edges that leave it, and its neighbours. Of more than may be, the first. */
export class Ring {
  readonly edges = new Int32Array(MOST_NEIGHBOURS);
  readonly vertices = new Int32Array(MOST_NEIGHBOURS);
  edgeCount = 0;
  vertexCount = 0;

  get isClosed(): boolean {
    return this.edgeCount === this.vertexCount;
  }
}

export class Surface {
  vertexCount: number;
  /** Half-edges. */
  edgeCount: number;
  /** Vertex at which each half-edge starts. */
  origins: Uint32Array;
  /** Three coordinates a vertex. */
  positions: Float64Array;
  /** How many neighbours each vertex has. */
  valences: Uint32Array;
  /** Whether each vertex is inside the surface. */
  closed: Uint8Array;
  private twins: Int32Array;
  private leaving: Int32Array;

  constructor(positions: readonly number[], corners: readonly number[]) {
    this.vertexCount = positions.length / 3;
    this.edgeCount = corners.length;
    this.origins = Uint32Array.from(corners);
    this.positions = Float64Array.from(positions);
    this.twins = new Int32Array(corners.length).fill(NONE);
    this.leaving = new Int32Array(this.vertexCount).fill(NONE);
    this.valences = new Uint32Array(this.vertexCount);
    this.closed = new Uint8Array(this.vertexCount);
    this.joinBase();
    corners.forEach((vertex, edge) => {
      if (this.leaving[vertex] === NONE || this.twins[edge] === NONE) this.leaving[vertex] = edge;
    });
    const ring = new Ring();
    for (let vertex = 0; vertex < this.vertexCount; vertex++) {
      this.walk(vertex, ring);
      this.valences[vertex] = ring.vertexCount;
      this.closed[vertex] = Number(ring.isClosed);
    }
  }

  /** Makes room for so many vertices, each with the two triangles of its split. */
  reserve(vertices: number): void {
    const edges = this.edgeCount + 6 * (vertices - this.vertexCount);
    this.positions = grown(this.positions, 3 * vertices);
    this.valences = grown(this.valences, vertices);
    this.closed = grown(this.closed, vertices);
    this.leaving = grown(this.leaving, vertices);
    this.origins = grown(this.origins, edges);
    this.twins = grown(this.twins, edges);
  }

  /** Walks around a vertex, and leaves in a ring what is met. */
  walk(vertex: number, ring: Ring): void {
    const { origins, twins, leaving } = this;
    const first = leaving[vertex]!;
    let count = 0;
    let isOpen = false;
    for (let edge = first; edge !== NONE; ) {
      ring.edges[count] = edge;
      ring.vertices[count++] = origins[next(edge)]!;
      const before = previous(edge);
      edge = twins[before]!;
      if (edge === first) break;
      isOpen = edge === NONE;
      if (isOpen) ring.vertices[count] = origins[before]!;
    }
    ring.edgeCount = count;
    ring.vertexCount = count + Number(isOpen);
  }

  /** Splits a vertex off `red`; false where the star cannot be cut so. There has to be room for it. */
  split(red: number, ring: Ring, cuts: Cuts, position: Point): boolean {
    if (!arePossible(cuts, ring) || !this.isHoleInside(cuts, ring)) return false;
    const blue = this.vertexCount++;
    setPoint(this.positions, blue, position);
    this.leaving[blue] = NONE;
    this.countNeighbours(red, blue, ring, cuts);
    if (cuts.side === Side.Outer) {
      this.give(ring, 0, ring.edgeCount, blue);
      this.leaving[blue] = this.leaving[red]!;
      this.open(blue, red, ring, cuts);
    } else {
      this.open(red, blue, ring, cuts);
    }
    return true;
  }

  /** Whether the third vertex of a hole to be opened, if there is one, is on no boundary yet. */
  private isHoleInside({ side, first, second }: Cuts, ring: Ring): boolean {
    if (side === Side.HoleFirst) return this.closed[ring.vertices[first]!] === 1;
    if (side === Side.HoleSecond) return this.closed[ring.vertices[second]!] === 1;
    return true;
  }

  /** Two half-edges along one edge in opposite directions are joined, unless there are more along it. */
  private joinBase(): void {
    const along = new Map<string, number[]>();
    this.origins.forEach((a, edge) => {
      const b = this.origins[next(edge)]!;
      const key = `${Math.min(a, b)} ${Math.max(a, b)}`;
      along.set(key, [...(along.get(key) ?? []), edge]);
    });
    for (const [one = NONE, other = NONE, ...more] of along.values()) {
      if (other !== NONE && more.length === 0 && this.origins[one] !== this.origins[other]) this.join(one, other);
    }
  }

  private countNeighbours(red: number, blue: number, ring: Ring, { side, first, second }: Cuts): void {
    const count = ring.vertexCount;
    let inner = ((second + count - first) % count) + 2;
    if (side === Side.Front) inner = second + 2;
    if (side === Side.Back) inner = count - first + 1;
    const outer = count + 2 + Number(hasFirst(side)) + Number(hasSecond(side)) - inner;
    const isOuter = side === Side.Outer;
    this.valences[red] = isOuter ? inner : outer;
    this.valences[blue] = isOuter ? outer : inner;
    this.closed[blue] = Number(side === Side.Inner);
    if (isOuter) this.closed[red] = 1;
    if (side === Side.HoleFirst || side === Side.HoleSecond) this.closed[red] = 0;
    if (hasFirst(side)) this.valences[ring.vertices[first]!]! += 1;
    if (hasSecond(side)) this.valences[ring.vertices[second]!]! += 1;
  }

  /** Gives the inner vertex its part of the star of the outer one, and fills the cuts. */
  private open(outer: number, inner: number, ring: Ring, cuts: Cuts): void {
    const { side, first, second } = cuts;
    this.giveInner(inner, ring, cuts);
    // Along the edge between the two, to be joined.
    let ofFirst = NONE;
    let ofSecond = NONE;
    if (side === Side.HoleFirst) {
      this.openHole(edgeBefore(ring, first));
      this.openHole(edgeAt(ring, first));
    } else if (hasFirst(side)) {
      const edge = this.addTriangle(outer, ring.vertices[first]!, inner);
      this.join(edge, edgeBefore(ring, first));
      this.join(edge + 1, edgeAt(ring, first));
      this.lead(edge + 1);
      ofFirst = edge + 2;
      if (first === 0 || ring.isClosed) this.leaving[outer] = edge;
      this.leaving[inner] = edge + 2;
    }
    if (side === Side.HoleSecond) {
      this.openHole(edgeBefore(ring, second));
      this.openHole(edgeAt(ring, second));
    } else if (hasSecond(side)) {
      const edge = this.addTriangle(outer, inner, ring.vertices[second]!);
      this.join(edge + 1, edgeBefore(ring, second));
      this.join(edge + 2, edgeAt(ring, second));
      this.lead(edge + 2);
      ofSecond = edge;
      if (side === Side.HoleFirst) this.leaving[outer] = edge;
      if (side === Side.Front) {
        this.leaving[outer] = edge;
        this.leaving[inner] = second === 0 ? edge + 1 : ring.edges[0]!;
      }
    }
    if (ofFirst !== NONE && ofSecond !== NONE) this.join(ofFirst, ofSecond);
  }

  private giveInner(inner: number, ring: Ring, { side, first, second }: Cuts): void {
    if (side === Side.Front) {
      this.give(ring, 0, second, inner);
    } else if (side === Side.Back) {
      this.give(ring, first, ring.edgeCount, inner);
    } else if (first < second) {
      this.give(ring, first, second, inner);
    } else {
      this.give(ring, first, ring.edgeCount, inner);
      this.give(ring, 0, second, inner);
    }
  }

  /** Lets half-edges of a walk start at a vertex. */
  private give(ring: Ring, from: number, to: number, vertex: number): void {
    for (let place = from; place < to; place++) this.origins[ring.edges[place]!] = vertex;
  }

  /** Parts a half-edge along an edge between red or blue and the third vertex of a hole: walks there begin beside the hole. */
  private openHole(edge: number): void {
    this.twins[edge] = NONE;
    this.lead(edge);
    this.closed[this.origins[edge]!] = 0;
  }

  private addTriangle(a: number, b: number, c: number): number {
    const edge = this.edgeCount;
    this.origins[edge] = a;
    this.origins[edge + 1] = b;
    this.origins[edge + 2] = c;
    this.twins[edge] = NONE;
    this.twins[edge + 1] = NONE;
    this.twins[edge + 2] = NONE;
    this.edgeCount += 3;
    return edge;
  }

  private join(edge: number, twin: number): void {
    this.twins[edge] = twin;
    if (twin !== NONE) this.twins[twin] = edge;
  }

  /** Lets walks around a half-edge's origin begin with it if nothing is to its right. */
  private lead(edge: number): void {
    if (this.twins[edge] === NONE) this.leaving[this.origins[edge]!] = edge;
  }
}

/** The half-edge of a walk at a place, if there is one. */
function edgeAt(ring: Ring, place: number): number {
  return place < ring.edgeCount ? ring.edges[place]! : NONE;
}

/** The one that has the triangle before a place on its left, and comes from there. */
function edgeBefore(ring: Ring, place: number): number {
  if (place > 0) return previous(ring.edges[place - 1]!);
  return ring.isClosed ? previous(ring.edges[ring.edgeCount - 1]!) : NONE;
}

function arePossible({ side, first, second }: Cuts, ring: Ring): boolean {
  const count = ring.vertexCount;
  if (first >= count || second >= count) return false;
  if (ring.isClosed) return first !== second;
  if (side === Side.HoleFirst || side === Side.HoleSecond) return false;
  return side === Side.Front || side === Side.Back || first < second;
}
