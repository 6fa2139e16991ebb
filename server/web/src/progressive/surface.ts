// A surface that grows by vertex splits. Half-edge 3t + k starts at the kth corner of triangle t.

const NONE = -1;

/**
 * Part of the triangles around a vertex that goes over to the new one: between two cuts, before one, after one, outside two; or
 * between two of which the first, or the second, becomes a hole of three vertices instead of a triangle.
 */
export const Side = { Inner: 0, Front: 1, Back: 2, Outer: 3, HoleFirst: 4, HoleSecond: 5 } as const;
export type Side = (typeof Side)[keyof typeof Side];

export interface Cuts {
  readonly side: Side;
  readonly first: number;
  readonly second: number;
}

/** The walk around a vertex, counter-clockwise: half-edges that leave it, and its neighbours. */
export interface Ring {
  readonly edges: number[];
  readonly vertices: number[];
  readonly isClosed: boolean;
}

export type Point = readonly [number, number, number];

const next = (edge: number): number => (edge % 3 === 2 ? edge - 2 : edge + 1);
const previous = (edge: number): number => (edge % 3 === 0 ? edge + 2 : edge - 1);
const hasFirst = (side: Side): boolean => side !== Side.Front;
const hasSecond = (side: Side): boolean => side !== Side.Back;

export class Surface {
  /** Vertex at which each half-edge starts. */
  readonly origins: number[];
  private readonly twins: number[];
  private readonly leaving: number[];
  private readonly valences: number[] = [];
  private readonly closed: boolean[] = [];

  constructor(
    readonly positions: Point[],
    corners: readonly number[],
  ) {
    this.origins = [...corners];
    this.twins = corners.map(() => NONE);
    this.leaving = positions.map(() => NONE);
    this.joinBase();
    corners.forEach((vertex, edge) => {
      if (this.leaving[vertex] === NONE || this.twins[edge] === NONE) this.leaving[vertex] = edge;
    });
    positions.forEach((_, vertex) => {
      const ring = this.walk(vertex);
      this.valences.push(ring.vertices.length);
      this.closed.push(ring.isClosed);
    });
  }

  valence(vertex: number): number {
    return this.valences[vertex]!;
  }

  isClosed(vertex: number): boolean {
    return this.closed[vertex]!;
  }

  walk(vertex: number): Ring {
    const edges: number[] = [];
    const vertices: number[] = [];
    const first = this.leaving[vertex]!;
    for (let edge = first; edge !== NONE; ) {
      edges.push(edge);
      vertices.push(this.origins[next(edge)]!);
      edge = this.twins[previous(edge)]!;
      if (edge === first) break;
      if (edge === NONE) vertices.push(this.origins[previous(edges[edges.length - 1]!)]!);
    }
    return { edges, vertices, isClosed: edges.length === vertices.length };
  }

  /** Splits a vertex off `red`; false where the star cannot be cut so. */
  split(red: number, ring: Ring, cuts: Cuts, position: Point): boolean {
    if (!arePossible(cuts, ring) || !this.isHoleInside(cuts, ring)) return false;
    const blue = this.positions.length;
    this.positions.push(position);
    this.leaving.push(NONE);
    this.countNeighbours(red, ring, cuts);
    if (cuts.side === Side.Outer) {
      this.give(ring.edges, blue);
      this.leaving[blue] = this.leaving[red]!;
      this.open(blue, red, ring, cuts);
    } else {
      this.open(red, blue, ring, cuts);
    }
    return true;
  }

  /** Whether the third vertex of a hole to be opened, if there is one, is on no boundary yet. */
  private isHoleInside({ side, first, second }: Cuts, ring: Ring): boolean {
    if (side === Side.HoleFirst) return this.closed[ring.vertices[first]!]!;
    if (side === Side.HoleSecond) return this.closed[ring.vertices[second]!]!;
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

  private countNeighbours(red: number, ring: Ring, { side, first, second }: Cuts): void {
    const count = ring.vertices.length;
    let inner = ((second + count - first) % count) + 2;
    if (side === Side.Front) inner = second + 2;
    if (side === Side.Back) inner = count - first + 1;
    const outer = count + 2 + Number(hasFirst(side)) + Number(hasSecond(side)) - inner;
    const isOuter = side === Side.Outer;
    this.valences[red] = isOuter ? inner : outer;
    this.valences.push(isOuter ? outer : inner);
    this.closed.push(side === Side.Inner);
    if (isOuter) this.closed[red] = true;
    if (side === Side.HoleFirst || side === Side.HoleSecond) this.closed[red] = false;
    if (hasFirst(side)) this.valences[ring.vertices[first]!]! += 1;
    if (hasSecond(side)) this.valences[ring.vertices[second]!]! += 1;
  }

  /** Gives the inner vertex its part of the star of the outer one, and fills the cuts. */
  private open(outer: number, inner: number, ring: Ring, { side, first, second }: Cuts): void {
    const { edges, vertices } = ring;
    if (side === Side.Front) this.give(edges.slice(0, second), inner);
    else if (side === Side.Back) this.give(edges.slice(first), inner);
    else if (first < second) this.give(edges.slice(first, second), inner);
    else this.give([...edges.slice(first), ...edges.slice(0, second)], inner);
    const edgeAt = (place: number) => edges[place] ?? NONE;
    const edgeBefore = (place: number) => {
      const edge = edges[place > 0 ? place - 1 : ring.isClosed ? edges.length - 1 : NONE];
      return edge === undefined ? NONE : previous(edge);
    };
    const between: number[] = [];
    if (side === Side.HoleFirst) {
      this.openHole(edgeBefore(first), edgeAt(first));
    } else if (hasFirst(side)) {
      const edge = this.addTriangle(outer, vertices[first]!, inner);
      this.join(edge, edgeBefore(first));
      this.join(edge + 1, edgeAt(first));
      this.lead(edge + 1);
      between.push(edge + 2);
      if (first === 0 || ring.isClosed) this.leaving[outer] = edge;
      this.leaving[inner] = edge + 2;
    }
    if (side === Side.HoleSecond) {
      this.openHole(edgeBefore(second), edgeAt(second));
    } else if (hasSecond(side)) {
      const edge = this.addTriangle(outer, inner, vertices[second]!);
      this.join(edge + 1, edgeBefore(second));
      this.join(edge + 2, edgeAt(second));
      this.lead(edge + 2);
      between.push(edge);
      if (side === Side.HoleFirst) this.leaving[outer] = edge;
      if (side === Side.Front) {
        this.leaving[outer] = edge;
        this.leaving[inner] = second === 0 ? edge + 1 : edges[0]!;
      }
    }
    const [one, other] = between;
    if (one !== undefined && other !== undefined) this.join(one, other);
  }

  /** Parts the two half-edges along an edge between red or blue and the third vertex of a hole: walks there begin beside the hole. */
  private openHole(...edges: [number, number]): void {
    for (const edge of edges) {
      this.twins[edge] = NONE;
      this.lead(edge);
      this.closed[this.origins[edge]!] = false;
    }
  }

  private give(edges: readonly number[], vertex: number): void {
    for (const edge of edges) this.origins[edge] = vertex;
  }

  private addTriangle(...corners: [number, number, number]): number {
    this.twins.push(NONE, NONE, NONE);
    return this.origins.push(...corners) - 3;
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

function arePossible({ side, first, second }: Cuts, ring: Ring): boolean {
  const count = ring.vertices.length;
  if (first >= count || second >= count) return false;
  if (ring.isClosed) return first !== second;
  if (side === Side.HoleFirst || side === Side.HoleSecond) return false;
  return side === Side.Front || side === Side.Back || first < second;
}
