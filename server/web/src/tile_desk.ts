// Decoders of tiles that begin with the first bytes of each and go on with the next ones: the work of a worker.

import { filledCells } from "./filled.ts";
import { DecodeError } from "./progressive/decode_error.ts";
import { HeaderCut } from "./progressive/fields.ts";
import { TileDecoder, type Tile } from "./spt.ts";

/** Bytes of a tile: its first ones where its number is new, else those that come next. Without bytes, the tile is forgotten. */
export interface Job {
  readonly number: number;
  readonly bytes: Uint8Array | undefined;
}

/** What is known of a tile by the bytes that have come. */
export interface Decoded extends Pick<TileDecoder, "address" | "ends" | "levels" | "levelsThere" | "bytesThere"> {
  /** Undefined before the first level is whole. */
  readonly tile: Tile | undefined;
  /** A bit for each cell of the tile whose ground was filled; undefined where all was measured. */
  readonly filled: Uint8Array | undefined;
}

/** What came of the bytes of a tile: they are decoded, or at fault. */
export type Outcome =
  | { readonly number: number; readonly decoded: Decoded }
  | { readonly number: number; readonly fault: string; readonly isHeaderCut: boolean };

/** Keeps a decoder for each tile that is not whole. */
export class TileDesk {
  private readonly decoders = new Map<number, TileDecoder>();

  /** Does a job; nothing comes of a tile that is to be forgotten. */
  async do({ number, bytes }: Job): Promise<Outcome | undefined> {
    if (bytes === undefined) {
      this.decoders.delete(number);
      return undefined;
    }
    try {
      return { number, decoded: await this.decode(number, bytes) };
    } catch (error) {
      this.decoders.delete(number);
      if (!(error instanceof DecodeError)) throw error;
      return { number, fault: error.message, isHeaderCut: error instanceof HeaderCut };
    }
  }

  private async decode(number: number, bytes: Uint8Array): Promise<Decoded> {
    const known = this.decoders.get(number);
    known?.add(bytes);
    const decoder = known ?? new TileDecoder(bytes);
    const { address, ends, levels, levelsThere, bytesThere, filledBytes } = decoder;
    if (levelsThere < ends.length) this.decoders.set(number, decoder);
    else this.decoders.delete(number);
    const tile = levelsThere > 0 ? decoder.tile() : undefined;
    const filled = filledBytes && (await filledCells(filledBytes));
    if (filledBytes !== undefined && filled === undefined) throw new DecodeError("the filled ground is broken");
    return { address, ends, levels, levelsThere, bytesThere, tile, filled };
  }
}
