// Decodes the progressive terrain tile; docs/formats/spt.md is its definition. The decoder has to be loaded: `loadDecoder`.

import type { Address } from "./address.ts";
import { DecodeError, HeaderCut } from "./decode_error.ts";
import { arraysOf, levelsOf } from "./decoded.ts";
import { answerOf } from "./decoder.ts";
import { TileDecoder as Decoder } from "./decoder/terrain_decoder.js";
import type { Level, Tile } from "./tile.ts";

/** Decodes a whole tile; throws a {@link DecodeError} when a length, count, index or coordinate is out of range. */
export function decodeTile(bytes: Uint8Array): Tile {
  const decoder = new TileDecoder(bytes);
  if (decoder.levelsThere < decoder.ends.length) {
    decoder.free();
    throw new DecodeError("the levels are cut off");
  }
  return decoder.last();
}

/**
 * Decodes as much of a tile as its first bytes tell, at least its base. A level that is cut has the splits that are whole, and
 * the error of the one before, for which alone it is certified; infinity if it is the first. Levels that are missing add nothing.
 */
export function decodeTilePrefix(bytes: Uint8Array): Tile {
  const decoder = new TileDecoder(bytes);
  decoder.cut();
  return decoder.last();
}

/** Decodes a tile while its bytes come in, each level as soon as it is whole. Its memory is to be freed. */
export class TileDecoder {
  readonly address: Address;
  /** Bytes of the tile up to the end of each level. */
  readonly ends: readonly number[];
  /** The levels as the header tells them, also those that are not there yet. */
  readonly levels: readonly Level[];
  /** A bit for each cell of the tile whose ground was filled; undefined where all was measured. */
  readonly filled: Uint8Array | undefined;
  private readonly decoder: Decoder;

  /** Begins with at least the header; if that is cut, throws {@link HeaderCut}. */
  constructor(first: Uint8Array) {
    const decoder = answerOf(() => Decoder.begin(first));
    if (decoder === undefined) throw new HeaderCut("the header is cut off");
    this.decoder = decoder;
    const [zoom, x, y] = decoder.address() as unknown as [number, number, number];
    this.address = { zoom, x, y };
    this.ends = [...decoder.ends()];
    this.levels = levelsOf(decoder.levels());
    this.filled = decoder.filled();
  }

  /** How many levels are whole. */
  get levelsThere(): number {
    return this.decoder.levels_there();
  }

  /** How many bytes of the tile have come. */
  get bytesThere(): number {
    return this.decoder.bytes_there();
  }

  /** Goes on with the bytes that come next. */
  add(bytes: Uint8Array): void {
    this.answer(() => this.decoder.add(bytes));
  }

  /** Decodes what is there of the level that is not whole, for nothing more will come. */
  cut(): void {
    this.answer(() => this.decoder.cut());
  }

  /** What has been decoded so far. Levels that are missing add nothing and have the error of the last that is whole. */
  tile(): Tile {
    const surface = this.answer(() => this.decoder.surface());
    const arrays = arraysOf(surface);
    surface.free();
    return { address: this.address, extentBits: this.decoder.extent_bits(), ...arrays };
  }

  /** The same, if nothing more is to come. */
  last(): Tile {
    const tile = this.tile();
    this.free();
    return tile;
  }

  /** Gives its memory back; it is of no more use. */
  free(): void {
    this.decoder.free();
  }

  /** What the decoder answers; where it fails, nothing more will come of it. */
  private answer<T>(call: () => T): T {
    try {
      return answerOf(call);
    } catch (error) {
      this.free();
      throw error;
    }
  }
}
