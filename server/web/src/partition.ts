// Levels of detail of a Surface Partition: which stored position each vertex is drawn at.

import { interiorLevels, type Tile } from "./tile.ts";

/** Which level of detail of a tile to draw. */
export interface Detail {
  /** Index of the interior level, 0 the coarsest. */
  readonly interior: number;
  /** Which of the sides west, south, east and north show their own zoom's vertices; needs the finest interior. */
  readonly fineSides: readonly boolean[];
}

/** Finest interior, every side fine. */
export function finestDetail(tile: Pick<Tile, "levels">): Detail {
  return { interior: interiorLevels(tile) - 1, fineSides: [true, true, true, true] };
}

/** What the parent tile shows of this square at its finest. */
export const COARSEST_DETAIL: Detail = { interior: 0, fineSides: [false, false, false, false] };

export function isSameDetail(a: Detail, b: Detail): boolean {
  return a.interior === b.interior && a.fineSides.every((fine, side) => fine === b.fineSides[side]);
}

/** Whether a level is part of a level of detail. */
function isSelected(tile: Pick<Tile, "levels">, detail: Detail, level: number): boolean {
  const side = level - interiorLevels(tile);
  return side < 0 ? level <= detail.interior : detail.fineSides[side] === true;
}

/** For each vertex, the index into the tile's positions of the place it is drawn at. */
export function placesOf(tile: Tile, detail: Detail): Uint32Array {
  return placesWhere(tile, (level) => isSelected(tile, detail, level));
}

/** The same for a partition without sides, of its levels up to one. */
export function placesOfLevel(partition: Pick<Tile, "levels" | "representatives">, last: number): Uint32Array {
  return placesWhere(partition, (level) => level <= last);
}

/**
 * A vertex that is not in yet is at its representative's place, which may itself have moved: a later vertex of the surface put it back
 * where it had been.
 */
function placesWhere({ levels, representatives }: Pick<Tile, "levels" | "representatives">, isIn: (level: number) => boolean): Uint32Array {
  const vertexCount = representatives.length;
  const roots = new Uint32Array(vertexCount);
  for (let root = 0; root < vertexCount; root++) roots[root] = root;
  const current = roots.slice();
  let vertex = 0;
  levels.forEach(({ vertexEnd }, level) => {
    const selected = isIn(level);
    for (; vertex < vertexEnd; vertex++) {
      const representative = representatives[vertex]!;
      if (!selected) {
        roots[vertex] = roots[representative]!;
      } else if (representative !== vertex) {
        current[representative] = vertexCount + vertex;
      }
    }
  });
  for (let at = 0; at < vertexCount; at++) roots[at] = current[roots[at]!]!;
  return roots;
}

/**
 * How many triangles of the array hold all those of the level of detail. Those of sides left out in between have two
 * corners at one place and draw nothing.
 */
export function drawnPrefix(tile: Tile, detail: Detail): number {
  return tile.levels.reduce((end, level, index) => (isSelected(tile, detail, index) ? level.triangleEnd : end), 0);
}

/** How many triangles the level of detail has. */
export function triangleCount(tile: Pick<Tile, "levels">, detail: Detail): number {
  let start = 0;
  let count = 0;
  tile.levels.forEach(({ triangleEnd }, index) => {
    if (isSelected(tile, detail, index)) count += triangleEnd - start;
    start = triangleEnd;
  });
  return count;
}
