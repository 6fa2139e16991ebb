// A tile's surface as a picture shows it, asked for at places in plan.

import { degreesOf } from "./address.ts";
import { tileBounds } from "./frame.ts";
import { between, onSide, sideVertices, type SideVertex, type Spot } from "./spots.ts";
import type { Tile } from "./tile.ts";

/** Cells along a side of the grid that triangles are found by. */
const CELLS = 32;

/** A tile's finest surface as a map in plan to where a picture has its vertices. */
export class PlanSurface {
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
