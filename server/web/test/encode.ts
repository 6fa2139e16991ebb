// Writes tiles of the format, to have something to read: docs/formats/spt.md is the definition.

import { deflateRawSync } from "node:zlib";
import type { Address } from "../src/address.ts";

export type Position = readonly [number, number, number];

/** A vertex; all but those of the coarsest level say whom they split from, and where that one then goes. */
export interface EncodedVertex {
  readonly position: Position;
  readonly representative?: number;
  readonly restored?: Position;
}

export interface EncodedLevel {
  readonly kind: number;
  readonly error: number;
  readonly vertices: readonly EncodedVertex[];
  readonly triangles: readonly (readonly number[])[];
}

export interface EncodedTile {
  readonly address: Address;
  readonly extentBits: number;
  readonly heightExponent: number;
  readonly levels: readonly EncodedLevel[];
}

/** The bytes of a tile. */
export function encode(tile: EncodedTile): Uint8Array {
  const payloads = encodeLevels(tile.levels);
  const start = 32 + 32 * tile.levels.length;
  const bytes = Buffer.alloc(start + payloads.reduce((sum, { deflated }) => sum + deflated.length, 0));
  writeHeader(bytes, tile);
  let [offset, vertices, triangles] = [start, 0, 0];
  tile.levels.forEach((level, index) => {
    const { deflated, length } = payloads[index]!;
    const at = 32 + 32 * index;
    vertices += level.vertices.length;
    triangles += level.triangles.length;
    bytes.writeUInt8(level.kind, at);
    [offset, deflated.length, vertices, triangles].forEach((value, n) => bytes.writeUInt32LE(value, at + 4 + 4 * n));
    bytes.writeFloatLE(level.error, at + 20);
    bytes.writeUInt32LE(length, at + 28);
    offset += deflated.copy(bytes, offset);
  });
  return bytes;
}

function writeHeader(bytes: Buffer, { address, extentBits, heightExponent, levels }: EncodedTile): void {
  const heights = levels.flatMap((level) => level.vertices.map(({ position }) => position[2]));
  bytes.write("SPTL");
  bytes.writeUInt8(1, 4);
  bytes.writeUInt8(address.zoom, 5);
  bytes.writeUInt8(extentBits, 6);
  bytes.writeInt8(heightExponent, 7);
  bytes.writeUInt32LE(address.x, 8);
  bytes.writeUInt32LE(address.y, 12);
  bytes.writeInt32LE(Math.min(...heights), 16);
  bytes.writeInt32LE(Math.max(...heights), 20);
  bytes.writeUInt16LE(levels.length, 24);
  bytes.writeUInt32LE(bytes.length, 28);
}

function encodeLevels(levels: readonly EncodedLevel[]): { deflated: Buffer; length: number }[] {
  const current: Position[] = [];
  return levels.map(({ vertices, triangles }) => {
    const run: number[] = [];
    let previous: Position = [0, 0, 0];
    for (const { position, representative, restored } of vertices) {
      pushDifference(run, position, previous);
      previous = position;
      current.push(position);
      if (representative === undefined) continue;
      pushUnsigned(run, current.length - 1 - representative);
      const place = restored ?? current[representative]!;
      pushDifference(run, place, current[representative]!);
      current[representative] = place;
    }
    let first = 0;
    for (const [a = 0, b = 0, c = 0] of triangles) {
      [a - first, b - a, c - b].forEach((difference) => pushSigned(run, difference));
      first = a;
    }
    const bytes = Uint8Array.from(run);
    return { deflated: deflateRawSync(bytes), length: bytes.length };
  });
}

function pushDifference(run: number[], position: Position, origin: Position): void {
  position.forEach((value, axis) => pushSigned(run, value - origin[axis]!));
}

function pushSigned(run: number[], value: number): void {
  pushUnsigned(run, value < 0 ? -2 * value - 1 : 2 * value);
}

function pushUnsigned(run: number[], value: number): void {
  for (; value >= 128; value = Math.floor(value / 128)) run.push((value % 128) + 128);
  run.push(value);
}
