import assert from "node:assert/strict";
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { collapseGraph, collapsesAround, rowsOf, type CollapseGraph, type Splits } from "../src/collapse_graph.ts";
import { loadDecoder } from "../src/decoder.ts";
import { decodeTile } from "../src/spt.ts";

await loadDecoder();

/** What Rust recorded: collapses by their place in the log, blue first. */
interface Vector {
  readonly name: string;
  readonly kind: string;
  readonly collapses: readonly (readonly [number, number])[];
  readonly positions: readonly unknown[];
  readonly triangles: readonly (readonly number[])[];
  /** With all collapses into a vertex of the star, as the papers record them. */
  readonly expected: { readonly collapse_constraints: readonly (readonly number[])[]; readonly reduced: readonly (readonly number[])[] };
}

/** Of this project, and, where it stands beside it, of an independent reference. */
const FOLDERS = ["../../tests/vectors", "../../../shared/vectors"].filter((folder) => existsSync(folder));
const vectors = FOLDERS.flatMap((folder) => readdirSync(folder).map((file) => `${folder}/${file}`))
  .filter((path) => path.endsWith(".json"))
  .map((path) => JSON.parse(readFileSync(path, "utf8")) as Vector)
  .filter(({ kind }) => kind === "dag");

/** The vertices of a vector in the order in which splits make them, the last collapse first. */
function splitsOf({ collapses, positions, triangles }: Vector): Splits & { first: number } {
  const blues = collapses.map(([blue]) => blue).reverse();
  const order = [...positions.keys()].filter((vertex) => !blues.includes(vertex)).concat(blues);
  const numbers = new Map(order.map((vertex, number) => [vertex, number]));
  const reds = new Map(collapses);
  return {
    first: order.length - collapses.length,
    representatives: Uint32Array.from(order, (vertex) => numbers.get(reds.get(vertex) ?? vertex)!),
    corners: Uint32Array.from(triangles.flat(), (vertex) => numbers.get(vertex)!),
  };
}

/** All that each collapse needs, directly or not. */
function closure(needs: CollapseGraph["needs"], first: number): number[][] {
  const all: number[][] = [];
  for (let at = needs.length - 1; at >= 0; at--) all[at] = [...new Set(needs[at]!.flatMap((other) => [other, ...all[other - first]!]))].sort((a, b) => a - b);
  return all;
}

for (const vector of vectors) {
  test(`${vector.name}: what each collapse needs is what Rust recorded`, () => {
    const splits = splitsOf(vector);
    const graph = collapseGraph(splits, splits.first);
    const count = vector.collapses.length;
    // The last collapse is that of the first vertex.
    const toPlaces = (vertices: Iterable<number>) => [...vertices].map((vertex) => count - 1 - (vertex - graph.first)).sort((a, b) => a - b);
    for (let collapse = 0; collapse < count; collapse++) {
      const at = count - 1 - collapse;
      const direct = toPlaces(graph.needs[at]!);
      const literal = vector.expected.collapse_constraints[collapse]!;
      const lasts = literal.filter((other) => !literal.some((later) => later > other && vector.collapses[later]![1] === vector.collapses[other]![1]));
      assert.deepEqual(direct, lasts, `collapse ${collapse}`);
      assert.deepEqual(toPlaces(graph.reduced[at]!), vector.expected.reduced[collapse]);
    }
  });
}

/**
 * Slowly, and by sets of triangles alone: a collapse needs another one if both are in a vertex of its star, as the triangles were
 * when all before it had been performed.
 */
function neededSlowly({ representatives, corners }: Splits, first: number): number[][] {
  const needs: number[][] = [];
  for (let blue = representatives.length - 1; blue >= first; blue--) {
    const drawnAt = (vertex: number): number => (vertex > blue ? drawnAt(representatives[vertex]!) : vertex);
    const star = new Set<number>();
    for (let at = 0; at < corners.length; at += 3) {
      const triangle = [0, 1, 2].map((corner) => drawnAt(corners[at + corner]!));
      const isAround = triangle.includes(blue) || triangle.includes(representatives[blue]!);
      if (new Set(triangle).size === 3 && isAround) triangle.forEach((vertex) => star.add(vertex));
    }
    const later = (vertex: number) => representatives.findIndex((red, other) => other > blue && red === vertex);
    needs[blue - first] = [...star].map(later).filter((other) => other >= 0).sort((a, b) => b - a);
  }
  return needs;
}

for (const name of ["jacksboro_v3", "holes_v4", "small_v3"]) {
  test(`${name}: a graph of a real tile is that of slow sets of triangles`, () => {
    const tile = decodeTile(readFileSync(`../../codec/golden/${name}.spt`));
    const first = tile.levels[0]!.vertexEnd;
    const graph = collapseGraph(tile, first);
    assert.deepEqual(graph.needs, neededSlowly(tile, first));
    assert.equal(graph.edgeCount, graph.needs.flat().length);
    assert.deepEqual(closure(graph.reduced, first), closure(graph.needs, first));
    assert.ok(graph.needs.every((needed, at) => graph.levels[at] === 1 + Math.max(0, ...needed.map((other) => graph.levels[other - first]!))));
  });
}

test("a part of a graph is what is nearest, in rows by level, where edges go down", () => {
  const tile = decodeTile(readFileSync("../../codec/golden/jacksboro_v3.spt"));
  const first = tile.levels[0]!.vertexEnd;
  const graph = collapseGraph(tile, first);
  const middle = first + Math.floor(graph.needs.length / 2);
  const levelOf = (vertex: number) => graph.levels[vertex - first]!;
  const shown = collapsesAround(graph, middle, 40, 3);
  assert.ok(shown.length > 10 && shown.length <= 40 && new Set(shown).size === shown.length);
  const near = graph.reduced[middle - first]!.filter((other) => levelOf(other) >= levelOf(middle) - 3);
  assert.ok(near.length > 0 && shown.includes(middle) && near.every((other) => shown.includes(other)));
  assert.ok(shown.every((vertex) => Math.abs(levelOf(vertex) - levelOf(middle)) <= 3));
  const rows = rowsOf(graph, shown);
  assert.deepEqual(rows.flat().sort(), [...shown].sort());
  const rowOf = new Map(rows.flatMap((row, at) => row.map((vertex) => [vertex, at] as const)));
  for (const vertex of shown) {
    for (const other of graph.needs[vertex - first]!) assert.ok((rowOf.get(other) ?? Infinity) > rowOf.get(vertex)!, "what is needed is below");
  }
});
