import assert from "node:assert/strict";
import { test } from "node:test";
import type { Texture } from "three";
import { keyOf, type Address } from "../src/address.ts";
import type { Clock } from "../src/circuit_breaker.ts";
import { SquareRasters, type RasterOrder } from "../src/square_rasters.ts";

/** A clock that is moved by hand; what is promised meanwhile comes before its next alarm. */
class HandClock implements Clock {
  private time = 0;
  private alarms: { readonly at: number; readonly call: () => void }[] = [];

  now(): number {
    return this.time;
  }

  after(milliseconds: number, call: () => void): () => void {
    const alarm = { at: this.time + milliseconds, call };
    this.alarms.push(alarm);
    return () => (this.alarms = this.alarms.filter((other) => other !== alarm));
  }

  async pass(milliseconds: number): Promise<void> {
    const end = this.time + milliseconds;
    for (;;) {
      await promises();
      const next = this.alarms.filter(({ at }) => at <= end).sort((a, b) => a.at - b.at)[0];
      if (next === undefined) break;
      this.time = next.at;
      this.alarms = this.alarms.filter((alarm) => alarm !== next);
      next.call();
    }
    this.time = end;
  }
}

const promises = () => new Promise((resolve) => setImmediate(resolve));

const [FILES, PARALLEL] = [12, 8];

/** A page that shows squares of some files each, from a server whose answers a test decides. */
function pageOf(squares: readonly Address[], answer: (address: Address) => unknown) {
  const clock = new HandClock();
  const asked: { readonly key: string; readonly at: number }[] = [];
  const get = async (address: Address) => {
    asked.push({ key: keyOf(address), at: clock.now() });
    await undefined;
    const found = answer(address);
    if (found instanceof Error) throw found;
    return found;
  };
  const load = async ({ address, ask }: RasterOrder) => {
    const files = await Promise.all(Array.from({ length: FILES }, () => ask(() => get(address))));
    return files[0] === undefined ? undefined : { texture: { dispose() {} } as Texture, bytesLoaded: 1, bytesKept: 1 };
  };
  const page = { squares, request: () => rasters.request(page.squares.map((address) => ({ address, detail: 0 }))) };
  const rasters = new SquareRasters({ load, parallelSquares: 4, parallelRequests: PARALLEL, mostBytes: 1e6 }, () => page.request(), clock);
  page.request();
  const askedSince = (time: number) => asked.filter(({ at }) => at >= time);
  return { page, rasters, clock, asked, askedSince };
}

const DOWN = new Error("its server answers 503");
const squaresOf = (count: number) => Array.from({ length: count }, (_, x) => ({ zoom: 8, x, y: 0 }));

test("a server that fails is left alone ever longer, is asked for one file at a time, and all comes when it works again", async () => {
  let isDown = true;
  const { rasters, clock, asked, askedSince } = pageOf(squaresOf(100), () => (isDown ? DOWN : "file"));
  await clock.pass(999);
  assert.ok(asked.length >= 4 && asked.length <= PARALLEL + 4, `${asked.length} requests at first`);
  assert.equal(rasters.failure, "its server answers 503");
  const first = asked.length;
  await clock.pass(120_000 - 999);
  const probes = asked.slice(first).map(({ at }) => at);
  assert.deepEqual(probes, [1000, 3000, 7000, 15_000, 31_000, 47_000, 63_000, 79_000, 95_000, 111_000]);
  assert.ok(new Set(asked.slice(first).map(({ key }) => key)).size >= 3, "not the same square again and again");
  isDown = false;
  await clock.pass(7000);
  assert.equal(rasters.failure, undefined);
  assert.ok(squaresOf(100).every((square) => rasters.finest(square) !== undefined), "all squares are there");
  assert.equal(askedSince(120_000).length, 100 * FILES);
  rasters.close();
});

test("a square that fails is asked for again ever later, the others are not disturbed, and that is told while it is in sight", async () => {
  let isBroken = true;
  const { page, rasters, clock, asked } = pageOf(squaresOf(6), ({ x }) => (isBroken && x === 2 ? new Error("its server answers 500") : "file"));
  const timesOfBroken = () => [...new Set(asked.filter(({ key }) => key === "8/2/0").map(({ at }) => at))];
  await clock.pass(100_000);
  assert.deepEqual(timesOfBroken().slice(0, 5), [0, 2000, 6000, 14_000, 30_000]);
  assert.equal(new Set(asked.map(({ key }) => key)).size, 6);
  const others = asked.filter(({ key }) => key !== "8/2/0");
  assert.ok(others.length === 5 * FILES && others.every(({ at }) => at === 0));
  assert.ok(asked.filter(({ key, at }) => key === "8/2/0" && at === 2000).length <= PARALLEL, "the rest of it is not asked for");
  assert.equal(rasters.failure, "its server answers 500");
  page.squares = squaresOf(2);
  page.request();
  assert.equal(rasters.failure, undefined);
  page.squares = squaresOf(6);
  isBroken = false;
  page.request();
  await clock.pass(64_000);
  assert.equal(rasters.failure, undefined);
  assert.ok(rasters.finest({ zoom: 8, x: 2, y: 0 }));
  rasters.close();
});

test("where there is none it is not asked again, and the nearest square above that has one does", async () => {
  const { rasters, clock, asked } = pageOf(squaresOf(9), ({ zoom }) => (zoom > 6 ? undefined : "file"));
  await clock.pass(1_000_000);
  assert.equal(new Set(asked.map(({ key }) => key)).size, 9 + 5 + 3);
  assert.equal(asked.length, FILES * (9 + 5 + 3));
  const { of, size, x } = rasters.finest({ zoom: 8, x: 5, y: 0 })!;
  assert.deepEqual([keyOf(of), size, x], ["6/1/0", 0.25, 0.25]);
  assert.equal(rasters.failure, undefined);
  assert.equal(rasters.isEmpty, false);
  rasters.close();
});

test("a server that has nothing is asked for every square once, up to the whole Earth", async () => {
  const { rasters, clock, asked } = pageOf(squaresOf(2), () => undefined);
  await clock.pass(1_000_000);
  assert.equal(asked.length, FILES * (2 + 8));
  assert.equal(rasters.isEmpty, true);
  assert.equal(rasters.finest({ zoom: 8, x: 0, y: 0 }), undefined);
});

test("nothing is asked for after the end", async () => {
  const { rasters, clock, asked } = pageOf(squaresOf(40), () => DOWN);
  await clock.pass(500);
  rasters.close();
  const before = asked.length;
  await clock.pass(1_000_000);
  assert.equal(asked.length, before);
});
