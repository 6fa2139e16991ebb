// A tile small enough to check by hand.

import type { WrittenTile } from "./written_tile.ts";

/** Two triangles; then vertex 4 splits vertex 0, which goes back to the corner. The sides have nothing to add. */
export const SMALL: WrittenTile = {
  address: { zoom: 3, x: 4, y: 5 },
  extentBits: 40,
  heightExponent: -2,
  levels: [
    {
      error: 8,
      vertices: [[10, 20, -5], [2 ** 40, 0, 6], [2 ** 40, 2 ** 40, 7], [0, 2 ** 40, 8]].map(([x = 0, y = 0, h = 0]) => ({
        position: [x, y, h] as const,
      })),
      triangles: [[4, 1, 2], [4, 2, 3]],
    },
    {
      error: 2,
      vertices: [{ position: [300, 200, 4], representative: 0, restored: [0, 0, -4] }],
      triangles: [[0, 1, 4], [0, 4, 3]],
    },
    ...[1, 2, 3, 4].map(() => ({ error: 2, vertices: [], triangles: [] })),
  ],
};
