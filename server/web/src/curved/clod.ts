// Reads `.clod` files: curved levels of detail, as docs/formats/clod.md says.

/** Patches of all levels: control points in the order 300 210 201 120 111 102 030 021 012 003, in units from `origin`. */
export interface CurvedLevels {
  readonly levelCount: number;
  readonly patchCount: number;
  readonly origin: readonly [number, number, number];
  /** Three numbers a control point, ten points a patch, from the origin. */
  readonly points: Float32Array;
  /** The first level that shows each patch, and the first after that which does not. */
  readonly born: Uint32Array;
  readonly died: Uint32Array;
  readonly errors: Float32Array;
  /** For each patch's curves AB, BC and CA: twice the curve's number, and one more where it runs the other way. */
  readonly curves: Uint32Array;
  readonly curveCount: number;
}

/** Control points of a patch's curves, from its corners A, B and C to the next one. */
export const CURVES = [
  [0, 1, 3, 6],
  [6, 7, 8, 9],
  [9, 5, 2, 0],
] as const;

const MAGIC = 0x444f4c43;
const VERSION = 1;
const CENTRE = 4;
/** The least bytes of a patch. */
const LEAST_PATCH = 15;

type Point = [number, number, number];

/** Numbers of seven bits a byte, the lowest first, and others, little-endian. */
class Fields {
  private at = 0;
  constructor(private readonly view: DataView) {}

  get left(): number {
    return this.view.byteLength - this.at;
  }

  private take(bytes: number): number {
    if (this.left < bytes) throw new Error("The file ends too early.");
    this.at += bytes;
    return this.at - bytes;
  }

  u8 = () => this.view.getUint8(this.take(1));
  u32 = () => this.view.getUint32(this.take(4), true);
  f32 = () => this.view.getFloat32(this.take(4), true);
  f64 = () => this.view.getFloat64(this.take(8), true);

  number(): number {
    let [value, scale] = [0, 1];
    for (;;) {
      const byte = this.u8();
      value += (byte & 127) * scale;
      if (byte < 128) break;
      scale *= 128;
    }
    if (!Number.isSafeInteger(value)) throw new Error("A number is too large.");
    return value;
  }

  /** Zigzag: 0, −1, 1, −2, … */
  signed(): number {
    const value = this.number();
    return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
  }

  offset(): Point {
    return [this.signed(), this.signed(), this.signed()];
  }
}

const plus = (a: Point, b: Point): Point => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

/** Reads a file; throws an error of one sentence where it is none. */
export function readCurvedLevels(bytes: ArrayBuffer): CurvedLevels {
  const fields = new Fields(new DataView(bytes));
  if (fields.u32() !== MAGIC) throw new Error("This is no .clod file.");
  const version = fields.u8();
  if (version !== VERSION) throw new Error(`This is a .clod file of version ${version}; version ${VERSION} is read.`);
  const origin: Point = [fields.f64(), fields.f64(), fields.f64()];
  const step = fields.f64();
  const levelCount = fields.number();
  const patchCount = fields.number();
  if (patchCount * LEAST_PATCH > fields.left) throw new Error("The file is shorter than it says.");
  return new Reader(fields, step, patchCount).all(levelCount, origin);
}

class Reader {
  private readonly vertices: Point[] = [];
  private readonly inner: [Point, Point][] = [];
  private readonly points: Float32Array;

  constructor(
    private readonly fields: Fields,
    private readonly step: number,
    private readonly patchCount: number,
  ) {
    this.points = new Float32Array(30 * patchCount);
  }

  all(levelCount: number, origin: Point): CurvedLevels {
    const [born, died, curves] = [1, 1, 3].map((count) => new Uint32Array(count * this.patchCount)) as [
      Uint32Array,
      Uint32Array,
      Uint32Array,
    ];
    const errors = new Float32Array(this.patchCount);
    for (let patch = 0; patch < this.patchCount; patch++) {
      born[patch] = this.fields.number();
      died[patch] = born[patch]! + Math.floor(this.fields.number() / 8);
      if (died[patch]! > levelCount) throw new Error("A patch belongs to a level that is not there.");
      errors[patch] = this.fields.f32();
      this.readPoints(patch, curves);
    }
    const { patchCount, points } = this;
    return { levelCount, patchCount, origin, points, born, died, errors, curves, curveCount: this.inner.length };
  }

  private readPoints(patch: number, curves: Uint32Array): void {
    const corners = [0, 1, 2].map(() => this.vertex()) as [Point, Point, Point];
    let sum: Point = [0, 0, 0];
    for (const [curve, [from, first, second]] of CURVES.entries()) {
      const { use, inner } = this.curve(corners[curve]!, corners[(curve + 1) % 3]!);
      curves[3 * patch + curve] = use;
      sum = plus(plus(sum, inner[0]), inner[1]);
      this.set(patch, from, corners[curve]!);
      this.set(patch, first, inner[0]);
      this.set(patch, second, inner[1]);
    }
    const average = sum.map((coordinate) => Math.floor(coordinate / 6)) as Point;
    this.set(patch, CENTRE, plus(average, this.fields.offset()));
  }

  private set(patch: number, point: number, at: Point): void {
    at.forEach((coordinate, axis) => (this.points[30 * patch + 3 * point + axis] = coordinate * this.step));
  }

  private vertex(): Point {
    const ago = this.fields.number();
    if (ago === 0) {
      const last = this.vertices[this.vertices.length - 1] ?? [0, 0, 0];
      this.vertices.push(plus(last, this.fields.offset()));
    }
    const found = this.vertices[this.vertices.length - Math.max(ago, 1)];
    if (found === undefined) throw new Error("A vertex is used before it is there.");
    return found;
  }

  /** A curve's inner points from `start` to `end`. */
  private curve(start: Point, end: Point): { use: number; inner: [Point, Point] } {
    const told = this.fields.number();
    if (told === 0) {
      const third = (near: Point, far: Point) =>
        near.map((coordinate, axis) => Math.floor((2 * coordinate + far[axis]!) / 3)) as Point;
      const first = plus(third(start, end), this.fields.offset());
      const second = plus(third(end, start), this.fields.offset());
      this.inner.push([first, second]);
      return { use: 2 * (this.inner.length - 1), inner: [first, second] };
    }
    const number = this.inner.length - Math.floor(told / 2);
    const inner = this.inner[number];
    if (inner === undefined) throw new Error("A curve is used before it is there.");
    const isReversed = told % 2 === 1;
    return { use: 2 * number + Number(isReversed), inner: isReversed ? [inner[1], inner[0]] : inner };
  }
}

/** The patches that a level shows, and the largest of their errors. */
export function patchesOf(levels: CurvedLevels, level: number): { patches: Uint32Array; error: number } {
  const shown: number[] = [];
  let error = 0;
  for (let patch = 0; patch < levels.patchCount; patch++) {
    if (levels.born[patch]! > level || level >= levels.died[patch]!) continue;
    shown.push(patch);
    error = Math.max(error, levels.errors[patch]!);
  }
  return { patches: Uint32Array.from(shown), error };
}
