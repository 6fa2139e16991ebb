// Decoders of tiles that begin with the first bytes of each and go on with the next ones: the work of a worker.

import { DecodeError, HeaderCut } from "./decode_error.ts";
import { TileDecoder } from "./spt.ts";
import type { Tile } from "./tile.ts";

/** Bytes of a tile: its first ones where its number is new, else those that come next. Without bytes, the tile is forgotten. */
export interface Job {
  readonly number: number;
  readonly bytes: Uint8Array | undefined;
}

/** What is known of a tile by the bytes that have come. */
export interface Decoded extends Pick<TileDecoder, "address" | "ends" | "levels" | "levelsThere" | "bytesThere" | "filled"> {
  /** Undefined before the first level is whole. */
  readonly tile: Tile | undefined;
}

/** What came of the bytes of a tile: they are decoded, or at fault. */
export type Outcome =
  | { readonly number: number; readonly decoded: Decoded }
  | { readonly number: number; readonly fault: string; readonly isHeaderCut: boolean };

/** Keeps a decoder for each tile that is not whole. */
export class TileDesk {
  private readonly decoders = new Map<number, TileDecoder>();

  /** Does a job; nothing comes of a tile that is to be forgotten. */
  do({ number, bytes }: Job): Outcome | undefined {
    if (bytes === undefined) {
      this.decoders.get(number)?.free();
      this.decoders.delete(number);
      return undefined;
    }
    try {
      return { number, decoded: this.decode(number, bytes) };
    } catch (error) {
      this.decoders.delete(number);
      if (!(error instanceof DecodeError)) throw error;
      return { number, fault: error.message, isHeaderCut: error instanceof HeaderCut };
    }
  }

  private decode(number: number, bytes: Uint8Array): Decoded {
    const known = this.decoders.get(number);
    known?.add(bytes);
    const decoder = known ?? new TileDecoder(bytes);
    const { address, ends, levels, levelsThere, bytesThere, filled } = decoder;
    const isWhole = levelsThere === ends.length;
    if (isWhole) this.decoders.delete(number);
    else this.decoders.set(number, decoder);
    const tile = isWhole ? decoder.last() : levelsThere > 0 ? decoder.tile() : undefined;
    return { address, ends, levels, levelsThere, bytesThere, filled, tile };
  }
}
