// Tile addresses of the geographic scheme: two root tiles side by side, rows counted from the south.

/** A tile: zoom z has 2^(z+1) columns from the antimeridian eastwards and 2^z rows from the south pole northwards. */
export interface Address {
  readonly zoom: number;
  readonly x: number;
  readonly y: number;
}

/** Largest zoom of the scheme. */
export const MAX_ZOOM = 26;

/** `zoom/x/y`, as in the tile's URL; also the key of every map of tiles. */
export function keyOf({ zoom, x, y }: Address): string {
  return `${zoom}/${x}/${y}`;
}

/** Degrees along a side of a tile. */
export function degreesOf(zoom: number): number {
  return 180 / 2 ** zoom;
}

/** The tile a zoom up that holds this one, which must not be a root. */
export function parentOf({ zoom, x, y }: Address): Address {
  return { zoom: zoom - 1, x: x >>> 1, y: y >>> 1 };
}

/** South-west, south-east, north-west, north-east. */
export function childrenOf({ zoom, x, y }: Address): Address[] {
  return [0, 1, 2, 3].map((child) => ({ zoom: zoom + 1, x: 2 * x + (child & 1), y: 2 * y + (child >> 1) }));
}

/**
 * The tiles across the west, south, east and north side; columns wrap at the antimeridian, there is nothing beyond
 * the poles.
 */
export function neighboursOf({ zoom, x, y }: Address): (Address | undefined)[] {
  const columns = 2 ** (zoom + 1);
  return [
    { zoom, x: (x + columns - 1) % columns, y },
    y > 0 ? { zoom, x, y: y - 1 } : undefined,
    { zoom, x: (x + 1) % columns, y },
    y + 1 < 2 ** zoom ? { zoom, x, y: y + 1 } : undefined,
  ];
}
