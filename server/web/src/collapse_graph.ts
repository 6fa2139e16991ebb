// The partial order of edge collapses: which others each one needs (Surface Partitions §3); core/src/levels/dag.rs is the same in Rust.
//
//   for each collapse, in order:
//     for each vertex in the star of its edge that was a red vertex before:
//       the collapse needs the last one into that vertex
//
// A collapse is called by its blue vertex. Vertices are numbered as splits make them, so that collapses go from the last to the first,
// and what one needs has a larger number.

const NONE = -1;

/** Vertices of which each has a representative, and triangles of the finest surface; see `Tile`. */
export interface Splits {
  readonly representatives: Uint32Array;
  /** Three corners a triangle. */
  readonly corners: Uint32Array;
}

/** Collapses, by their blue vertices, and what each needs. */
export interface CollapseGraph {
  /** The vertices below it never collapse. */
  readonly first: number;
  /** By the vertex less `first`: those that have to collapse before it, falling. */
  readonly needs: readonly (readonly number[])[];
  /** Of these, those that none of the others needs, directly or not: the smallest graph with the same order. */
  readonly reduced: readonly (readonly number[])[];
  /** 1 for a collapse that needs none, otherwise one more than the highest of what it needs. */
  readonly levels: Uint32Array;
  readonly edgeCount: number;
  /** The highest level. */
  readonly depth: number;
}

/** Replays the collapses of all vertices from `first` on, in time that grows with their stars. */
export function collapseGraph({ representatives, corners }: Splits, first: number): CollapseGraph {
  const surface = new CollapsingSurface(representatives.length, corners);
  const count = representatives.length - first;
  const lastInto = new Int32Array(representatives.length).fill(NONE);
  const needs: number[][] = Array.from({ length: count }, () => []);
  const levels = new Uint32Array(count);
  let [edgeCount, depth] = [0, 0];
  for (let blue = representatives.length - 1; blue >= first; blue--) {
    const red = representatives[blue]!;
    const star = surface.star(blue, red);
    const needed = [...star].map((vertex) => lastInto[vertex]!).filter((last) => last !== NONE);
    needs[blue - first] = needed.sort((a, b) => b - a);
    levels[blue - first] = needed.reduce((level, other) => Math.max(level, levels[other - first]! + 1), 1);
    edgeCount += needed.length;
    depth = Math.max(depth, levels[blue - first]!);
    surface.collapse(blue, red);
    lastInto[red] = blue;
  }
  return { first, needs, reduced: reducedOf(needs, first), levels, edgeCount, depth };
}

function reducedOf(needs: readonly (readonly number[])[], first: number): number[][] {
  const reachedBy = new Int32Array(needs.length).fill(NONE);
  return needs.map((needed, from) => {
    const farthest = needed[0] ?? NONE;
    // The nearest first, since the others may be reached through it.
    const kept = needed.slice().reverse().filter((vertex) => {
      if (reachedBy[vertex - first] === from) return false;
      for (const open = [vertex]; open.length > 0; ) {
        for (const other of needs[open.pop()! - first]!) {
          if (other > farthest || reachedBy[other - first] === from) continue;
          reachedBy[other - first] = from;
          open.push(other);
        }
      }
      return true;
    });
    return kept.reverse();
  });
}

/** Triangles while edges collapse. */
export class CollapsingSurface {
  private readonly corners: Uint32Array;
  /** The triangles around each vertex. */
  private readonly around: number[][];

  constructor(vertexCount: number, corners: Uint32Array) {
    this.corners = corners.slice();
    this.around = Array.from({ length: vertexCount }, () => []);
    this.corners.forEach((vertex, corner) => this.around[vertex]!.push(Math.floor(corner / 3)));
  }

  /** The vertices of the triangles around two vertices. */
  star(blue: number, red: number): Set<number> {
    return new Set([...this.around[blue]!, ...this.around[red]!].flatMap((triangle) => this.cornersOf(triangle)));
  }

  /** Triangles along the edge vanish, all others of blue go over to red. Tells how many vanish. */
  collapse(blue: number, red: number): number {
    const vanish = new Set(this.around[blue]!.filter((triangle) => this.cornersOf(triangle).includes(red)));
    for (const vertex of [...vanish].flatMap((triangle) => this.cornersOf(triangle))) {
      this.around[vertex] = this.around[vertex]!.filter((triangle) => !vanish.has(triangle));
    }
    for (const triangle of this.around[blue]!) {
      this.corners[3 * triangle + this.cornersOf(triangle).indexOf(blue)] = red;
      this.around[red]!.push(triangle);
    }
    this.around[blue] = [];
    return vanish.size;
  }

  private cornersOf(triangle: number): number[] {
    return [...this.corners.subarray(3 * triangle, 3 * triangle + 3)];
  }
}

/** Collapses around one: at most so many, the nearest along edges of the reduced graph, whichever way these run, and few levels away. */
export function collapsesAround({ reduced, levels, first }: CollapseGraph, middle: number, most: number, mostLevels: number): number[] {
  const neededBy: number[][] = reduced.map(() => []);
  reduced.forEach((needed, at) => needed.forEach((other) => neededBy[other - first]!.push(first + at)));
  const isNear = (vertex: number) => Math.abs(levels[vertex - first]! - levels[middle - first]!) <= mostLevels;
  const found = new Set([middle]);
  for (const vertex of found) {
    for (const other of [...neededBy[vertex - first]!, ...reduced[vertex - first]!]) if (found.size < most && isNear(other)) found.add(other);
  }
  return [...found];
}

/** How often the collapses of each row are brought in order. */
const SWEEPS = 8;

/**
 * The rows of a picture of some collapses: each level's, the highest first. In a row each collapse is about where those that it is joined to
 * are in theirs, from left to right.
 */
export function rowsOf(graph: CollapseGraph, shown: readonly number[]): number[][] {
  const { levels, first } = graph;
  const joined = new Map(shown.map((vertex) => [vertex, [] as number[]]));
  for (const vertex of shown) {
    for (const other of graph.reduced[vertex - first]!) {
      joined.get(other)?.push(vertex);
      if (joined.has(other)) joined.get(vertex)!.push(other);
    }
  }
  const heights = [...new Set(shown.map((vertex) => levels[vertex - first]!))].sort((a, b) => b - a);
  const rows = heights.map((level) => shown.filter((vertex) => levels[vertex - first] === level));
  const along = new Map<number, number>();
  const place = (row: number[]) => row.forEach((vertex, at) => along.set(vertex, (at + 0.5) / row.length));
  rows.forEach(place);
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    for (const row of sweep % 2 === 0 ? rows : [...rows].reverse()) {
      const wish = new Map(row.map((vertex) => [vertex, middleOf(joined.get(vertex)!.map((other) => along.get(other)!)) ?? along.get(vertex)!]));
      row.sort((a, b) => wish.get(a)! - wish.get(b)!);
      place(row);
    }
  }
  return rows;
}

function middleOf(places: readonly number[]): number | undefined {
  return places.length === 0 ? undefined : places.reduce((sum, place) => sum + place, 0) / places.length;
}
