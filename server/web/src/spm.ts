// Decodes the progressive mesh; docs/formats/spm.md is its definition. The decoder has to be loaded: `loadDecoder`.

import { answerOf, taken } from "./decoder.ts";
import { decode_mesh } from "./decoder/terrain_decoder.js";
import type { Surface } from "./tile.ts";

/** What bytes may ask of the browser. */
export interface LevelLimits {
  readonly levels: number;
  readonly vertices: number;
  readonly triangles: number;
}

/** Half a gigabyte or so. */
const LIMITS: LevelLimits = { levels: 1024, vertices: 1 << 22, triangles: 1 << 23 };

/** Decodes a whole file; throws a DecodeError when a length, count, index or coordinate is out of range, or a limit is exceeded. */
export function decodeModel(bytes: Uint8Array, { levels, vertices, triangles }: LevelLimits = LIMITS): Surface {
  return taken(answerOf(() => decode_mesh(bytes, levels, vertices, triangles)));
}
