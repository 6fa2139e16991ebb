// Where the ground of a tile was not measured: its source has voids there that were filled from their rims; docs/formats/spt.md.

/** Cells along a side of a tile. */
export const FILLED_CELLS = 256;

/** Whether there is filled ground in the cell of a place, from 0 to 1 eastwards and northwards through the tile's square. */
export function isFilled(cells: Uint8Array, x: number, y: number): boolean {
  const [column, row] = [x, y].map((part) => Math.min(Math.max(Math.floor(part * FILLED_CELLS), 0), FILLED_CELLS - 1)) as [number, number];
  return isSet(cells, row * FILLED_CELLS + column);
}

/** A texel a cell, 255 where it is filled. */
export function filledTexels(cells: Uint8Array): Uint8Array<ArrayBuffer> {
  const texels = new Uint8Array(FILLED_CELLS * FILLED_CELLS);
  for (let cell = 0; cell < texels.length; cell++) texels[cell] = isSet(cells, cell) ? 255 : 0;
  return texels;
}

function isSet(cells: Uint8Array, cell: number): boolean {
  return ((cells[cell >> 3]! >> (cell & 7)) & 1) === 1;
}
