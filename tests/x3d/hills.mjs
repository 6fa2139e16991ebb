// A landscape for tests: hills and a cliff, 1 km wide, at coordinates as large as those of a map projection.

const STEPS = 32;
const [EAST, NORTH] = [500_000, 4_000_000];

/** As Wavefront OBJ, z up. */
export function hillsAsObj() {
  const lines = [];
  for (let row = 0; row <= STEPS; row++) {
    for (let column = 0; column <= STEPS; column++) {
      const [x, y] = [column, row].map((step) => (1000 * step) / STEPS);
      lines.push(`v ${EAST + x} ${NORTH + y} ${height(x, y)}`);
    }
  }
  for (let row = 0; row < STEPS; row++) {
    for (let column = 0; column < STEPS; column++) {
      const corner = row * (STEPS + 1) + column + 1;
      const above = corner + STEPS + 1;
      lines.push(`f ${corner} ${corner + 1} ${above + 1}`, `f ${corner} ${above + 1} ${above}`);
    }
  }
  return `${lines.join("\n")}\n`;
}

function height(x, y) {
  const hills = 80 * Math.sin(x / 150) * Math.cos(y / 130) + 30 * Math.sin(x / 40 + y / 60);
  return 300 + hills + (x > 700 ? 60 : 0);
}
