// A pyramid of tiles whose finest surfaces are regular grids, nested and with sides as the format demands.
//
// Level 0 of a tile is a grid of half the cells, its parent's finest. Each cell's diagonal is split at its middle
// (level 1), then the edges between cells are (level 2), and last the edges on each side of the tile.

import type { Address } from "../src/address.ts";
import type { Tile } from "../src/tile.ts";
import { tileOf, type Position, type WrittenLevel, type WrittenVertex } from "./written_tile.ts";

const LEVEL_COUNT = 7;

/** What a pyramid is made of. */
export interface Pyramid {
  readonly leafZoom: number;
  /** Cells along a side of a tile's finest grid: a multiple of 4. */
  readonly cells: number;
  /** Certified error of the leaves' finest surfaces. */
  readonly leafError: number;
  /** Metres at a longitude and latitude in degrees. */
  height(longitude: number, latitude: number): number;
}

/** One tile. */
export function gridTile(pyramid: Pyramid, address: Address): Tile {
  const extentBits = 8 + pyramid.leafZoom - address.zoom;
  const grid = new Grid(pyramid, address, 2 ** extentBits / pyramid.cells);
  return tileOf({ address, extentBits, heightExponent: -3, levels: grid.levels() });
}

class Grid {
  private readonly vertices: WrittenVertex[][] = Array.from({ length: LEVEL_COUNT }, () => []);
  private readonly triangles: number[][] = [];
  private readonly triangleLevels: number[] = [];
  private readonly numbers = new Map<string, number>();
  private readonly trianglesOf: Set<number>[] = [];

  constructor(
    private readonly pyramid: Pyramid,
    private readonly address: Address,
    private readonly unitsPerCell: number,
  ) {
    this.makeCoarsest();
    this.splitAll(1, (column, row) => column % 2 === 1 && row % 2 === 1);
    const { cells } = pyramid;
    const isInside = (column: number, row: number) => column > 0 && row > 0 && column < cells && row < cells;
    this.splitAll(2, isInside);
    this.splitAll(3, (column) => column === 0);
    this.splitAll(4, (_, row) => row === 0);
    this.splitAll(5, (column) => column === cells);
    this.splitAll(6, (_, row) => row === cells);
  }

  levels(): WrittenLevel[] {
    const finest = this.pyramid.leafError * 2 ** (this.pyramid.leafZoom - this.address.zoom);
    return this.vertices.map((vertices, level) => ({
      error: finest * (level === 0 ? 2 : level === 1 ? 1.5 : 1),
      vertices,
      triangles: this.triangles.filter((_, triangle) => this.triangleLevels[triangle] === level),
    }));
  }

  private makeCoarsest(): void {
    const { cells } = this.pyramid;
    for (let row = 0; row <= cells; row += 2) {
      for (let column = 0; column <= cells; column += 2) this.addVertex(column, row, 0);
    }
    for (let row = 0; row < cells; row += 2) {
      for (let column = 0; column < cells; column += 2) {
        const corners = [[0, 0], [2, 0], [2, 2], [0, 2]].map(([x = 0, y = 0]) => this.at(column + x, row + y));
        const [southWest, southEast, northEast, northWest] = corners as [number, number, number, number];
        // The diagonal runs to the centre of the parent's cell, as the parent's own split left it.
        if ((column / 2 + row / 2) % 2 === 0) {
          this.addTriangle([southWest, southEast, northEast], 0);
          this.addTriangle([southWest, northEast, northWest], 0);
        } else {
          this.addTriangle([southWest, southEast, northWest], 0);
          this.addTriangle([southEast, northEast, northWest], 0);
        }
      }
    }
  }

  /** Splits, at each selected grid point that is not in yet, the edge of which it is the middle. */
  private splitAll(level: number, isSelected: (column: number, row: number) => boolean): void {
    const { cells } = this.pyramid;
    for (let row = 0; row <= cells; row++) {
      for (let column = 0; column <= cells; column++) {
        if (isSelected(column, row) && !this.numbers.has(`${column},${row}`)) this.split(column, row, level);
      }
    }
  }

  private split(column: number, row: number, level: number): void {
    const steps = [[1, 0], [0, 1], [1, 1], [1, -1]];
    // Neighbours choose different representatives on their common side, as real ones may.
    const direction = (this.address.x + this.address.y) % 2 === 0 ? 1 : -1;
    for (const [x = 0, y = 0] of steps) {
      const from = this.numbers.get(`${column - direction * x},${row - direction * y}`);
      const to = this.numbers.get(`${column + direction * x},${row + direction * y}`);
      if (from === undefined || to === undefined) continue;
      const sides = [...this.trianglesOf[from]!].filter((triangle) => this.trianglesOf[to]!.has(triangle));
      if (sides.length === 0) continue;
      const middle = this.addVertex(column, row, level, from);
      for (const triangle of sides) this.halve(triangle, from, to, middle, level);
      return;
    }
    throw new Error(`nothing to split at ${column}, ${row}`);
  }

  /** The half at `to` stays; the one at `from` is new, and vanishes when the middle collapses into `from`. */
  private halve(triangle: number, from: number, to: number, middle: number, level: number): void {
    const corners = this.triangles[triangle]!;
    this.addTriangle(corners.map((corner) => (corner === to ? middle : corner)), level);
    this.triangles[triangle] = corners.map((corner) => (corner === from ? middle : corner));
    this.trianglesOf[from]!.delete(triangle);
    this.trianglesOf[middle]!.add(triangle);
  }

  private addVertex(column: number, row: number, level: number, representative?: number): number {
    const number = this.numbers.size;
    const position = this.position(column, row);
    this.vertices[level]!.push(representative === undefined ? { position } : { position, representative });
    this.numbers.set(`${column},${row}`, number);
    this.trianglesOf.push(new Set());
    return number;
  }

  private addTriangle(corners: number[], level: number): void {
    corners.forEach((corner) => this.trianglesOf[corner]!.add(this.triangles.length));
    this.triangles.push(corners);
    this.triangleLevels.push(level);
  }

  private at(column: number, row: number): number {
    return this.numbers.get(`${column},${row}`)!;
  }

  /** Heights in steps of an eighth of a metre. */
  private position(column: number, row: number): Position {
    const { zoom, x, y } = this.address;
    const degrees = 180 / 2 ** zoom;
    const longitude = (x + column / this.pyramid.cells) * degrees - 180;
    const latitude = (y + row / this.pyramid.cells) * degrees - 90;
    const height = Math.round(this.pyramid.height(longitude, latitude) * 8);
    return [column * this.unitsPerCell, row * this.unitsPerCell, height];
  }
}
