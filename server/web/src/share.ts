// The view in the page's address, so that a link leads to it: #name/latitude,longitude,height,azimuth,down

import type { Pose } from "./viewer.ts";

/** The address's part for a view of a tileset. */
export function linkOf(name: string, { latitude, longitude, height, azimuth, down }: Pose): string {
  const numbers = [latitude.toFixed(6), longitude.toFixed(6), height.toFixed(1), azimuth.toFixed(2), down.toFixed(2)];
  return `#${encodeURIComponent(name)}/${numbers.join(",")}`;
}

/** What such a part says; undefined where it is none. */
export function readLink(hash: string): { name: string; pose: Pose } | undefined {
  const [, name, list] = /^#([^/]+)\/([-\d.,]+)$/.exec(hash) ?? [];
  const numbers = list?.split(",").map(Number) ?? [];
  if (name === undefined || numbers.length !== 5 || !numbers.every(Number.isFinite)) return undefined;
  const [latitude, longitude, height, azimuth, down] = numbers as [number, number, number, number, number];
  if (Math.abs(latitude) > 90 || Math.abs(longitude) > 180 || Math.abs(down) > 90) return undefined;
  return { name: decodeURIComponent(name), pose: { latitude, longitude, height, azimuth, down } };
}
