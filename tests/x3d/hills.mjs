// A landscape for tests: hills and a cliff, 1 km wide, at coordinates as large as those of a map projection, on a grid of
// which every other row and column is clustered away, again and again.

const FINEST_STEPS = 32;
const COARSEST_STEPS = 2;
const [EAST, NORTH] = [500_000, 4_000_000];

/** A test vector of kind `clustering`, z up. */
export function hills() {
  const clusterings = [];
  for (let steps = FINEST_STEPS / 2; steps >= COARSEST_STEPS; steps /= 2) {
    const mapping = onGrid(2 * steps, (column, row) => (row >> 1) * (steps + 1) + (column >> 1));
    clusterings.push({ positions: positions(steps), mapping });
  }
  return { kind: "clustering", dimension: 3, positions: positions(FINEST_STEPS), triangles: triangles(), clusterings };
}

function onGrid(steps, make) {
  const along = Array.from({ length: steps + 1 }, (_, index) => index);
  return along.flatMap((row) => along.map((column) => make(column, row)));
}

function positions(steps) {
  return onGrid(steps, (column, row) => {
    const [x, y] = [column, row].map((step) => (1000 * step) / steps);
    return [EAST + x, NORTH + y, height(x, y)];
  });
}

function height(x, y) {
  const hills = 80 * Math.sin(x / 150) * Math.cos(y / 130) + 30 * Math.sin(x / 40 + y / 60);
  return 300 + hills + (x > 700 ? 60 : 0);
}

function triangles() {
  const corners = onGrid(FINEST_STEPS - 1, (column, row) => row * (FINEST_STEPS + 1) + column);
  return corners.flatMap((corner) => {
    const above = corner + FINEST_STEPS + 1;
    return [
      [corner, corner + 1, above + 1],
      [corner, above + 1, above],
    ];
  });
}
