// The view in the page's address, so that a link leads to it: #name/latitude,longitude,height,azimuth,down,roll; of ground that is
// nowhere on the Earth #name/x,y,height,azimuth,down,roll,m; #name alone is the archive as it is first seen. The roll may be left away.

import { EARTH } from "./earth.ts";
import { PLANE_METRES } from "./local_ground.ts";
import type { Pose } from "./pose.ts";

/** The address's part for a view of a tileset. */
export function linkOf(name: string, pose: Required<Pose>, isLocal: boolean): string {
  const [x, y] = PLANE_METRES.numbersOf(pose);
  const place = isLocal ? [x.toFixed(2), y.toFixed(2)] : [pose.latitude.toFixed(7), pose.longitude.toFixed(7)];
  const numbers = [...place, ...[pose.height, pose.azimuth, pose.down, pose.roll].map(hundredths), ...(isLocal ? ["m"] : [])];
  return `#${encodeURIComponent(name)}/${numbers.join(",")}`;
}

/** What such a part says; undefined where it names nothing. A pose that is none is left out. */
export function readLink(hash: string): { name: string; pose: Pose | undefined } | undefined {
  const [, name, pose] = /^#([^/]+)(?:\/(.*))?$/.exec(hash) ?? [];
  return name === undefined ? undefined : { name: decoded(name), pose: poseOf(pose ?? "") };
}

function poseOf(text: string): Pose | undefined {
  const [, list, metres] = /^([-\d.,]+?)(,m)?$/.exec(text) ?? [];
  const numbers = list?.split(",").map(Number) ?? [];
  if (numbers.length < 5 || numbers.length > 6 || !numbers.every(Number.isFinite)) return undefined;
  const [first, second, height, azimuth, down, roll] = numbers as [number, number, number, number, number, number?];
  const { longitude, latitude } = metres === undefined ? EARTH.placeOf([second, first]) : PLANE_METRES.placeOf([first, second]);
  // Far from its middle the plane has no place on the Earth.
  if (!(Math.abs(latitude) <= 90 && Math.abs(longitude) <= 180) || Math.abs(down) > 90) return undefined;
  return { latitude, longitude, height, azimuth, down, ...(roll !== undefined && { roll }) };
}

/** Without a sign where all of them are 0. */
function hundredths(number: number): string {
  return (Math.round(100 * number) / 100 + 0).toFixed(2);
}

/** A percent sign that begins no byte is one. */
function decoded(name: string): string {
  try {
    return decodeURIComponent(name);
  } catch {
    return name;
  }
}
