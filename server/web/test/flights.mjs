// Recorded flights.

export const VIEWPORT = { width: 640, height: 360 };
/** Frames between two moments of a flight. */
export const FRAMES = 24;

const pose = (longitude, latitude, height, azimuth, down) => ({ longitude, latitude, height, azimuth, down });
/** Moments of flights, by the beginning of an archive's name. */
export const FLIGHTS = {
  jacksboro_fault: [pose(-84.3, 36.2, 9000, 20, 40), pose(-84.28, 36.22, 3000, 30, 30), pose(-84.22, 36.26, 2500, 60, 30), pose(-84.2, 36.3, 6000, 0, 45)],
  vancouver: [
    pose(-123.1, 49.12, 30000, 0, 40), pose(-123.12, 49.3, 6000, 20, 28), pose(-123.04, 49.4, 3500, 60, 28),
    pose(-122.8, 49.5, 4000, 80, 28), pose(-122.5, 49.55, 3500, 300, 30), pose(-122.6, 49.5, 25000, 330, 45),
  ],
  // A site of 4 km with cells of 5 m in a country with cells of 90 m: `site.py`.
  site_in_country: [
    pose(-70.43, -32.56, 8500, 20, 45), pose(-70.42, -32.53, 6200, 25, 40), pose(-70.406, -32.513, 4300, 25, 32), pose(-70.39, -32.506, 4300, 300, 34),
    pose(-70.415, -32.495, 4500, 120, 36), pose(-70.38, -32.55, 9500, 340, 50),
  ],
};

/** A pose between two others. */
export function between(from, to, share) {
  const turn = ((to.azimuth - from.azimuth + 540) % 360) - 180;
  const mixed = Object.keys(from).map((part) => [part, from[part] + (to[part] - from[part]) * share]);
  return { ...Object.fromEntries(mixed), azimuth: (from.azimuth + turn * share + 360) % 360 };
}
