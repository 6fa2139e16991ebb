// Progressive meshes: all of their levels, and what is drawn of them as a view needs it, fine where it is near, coarse where it is far and
// beside the picture. Decoding, splits and collapses are Rust's; docs/formats/spm.md and core/src/levels/view_refinement.rs.

import { DecodeError } from "./decode_error.ts";
import { arraysOf, orDecodeError } from "./decoded.ts";
import { initSync, Model } from "./model_decoder/terrain_model_decoder.js";
import { modelDecoderModule } from "./model_decoder_module.ts";
import type { Surface } from "./tile.ts";

/** What bytes may ask of the browser. */
export interface LevelLimits {
  readonly levels: number;
  readonly vertices: number;
  readonly triangles: number;
}

/** Half a gigabyte or so. */
const LIMITS: LevelLimits = { levels: 1024, vertices: 1 << 22, triangles: 1 << 23 };
/** Vertices of a model that is refined: they take some 800 bytes each, of the four gigabytes that a module may have. */
const MOST_REFINED = 1 << 21;

/** From where a model is looked at; lengths are in its units. */
export interface ModelView {
  readonly eye: readonly [number, number, number];
  /** For each half space in which all of the picture is, the unit normal to its inside and an offset. */
  readonly frustum: readonly number[];
  /** How many pixels a length has that is seen from as far away as it is long. */
  readonly focalLength: number;
  /** How far in pixels the picture may be off. */
  readonly within: number;
}

/** What a view changes in what is drawn; the first one changes all. */
export interface Redrawn {
  /** How many triangles are drawn. */
  readonly triangles: number;
  /** Those of them that change, growing, and three corners for each. */
  readonly places: Uint32Array;
  readonly corners: Uint32Array;
  /** The vertices that move, growing, and three coordinates for each. */
  readonly vertices: Uint32Array;
  readonly positions: Float64Array;
  /** How many vertices were split or collapsed. */
  readonly changes: number;
}

/** Loads what decodes models; before, none can be decoded. */
export async function loadModelDecoder(): Promise<void> {
  startModelDecoder(await modelDecoderModule());
}

/** The same where the module is there already, as in a worker that it was given to. */
export function startModelDecoder(module: WebAssembly.Module): void {
  initSync({ module });
}

/** A model in the decoder's memory, until it is freed. */
export class ProgressiveModel {
  /** All of its levels. */
  readonly mesh: Surface;
  private readonly model: Model;

  /** Decodes a whole file; throws a DecodeError when a length, count, index or coordinate is out of range, or a limit is exceeded. */
  constructor(bytes: Uint8Array, { levels, vertices, triangles }: LevelLimits = LIMITS) {
    this.model = orDecodeError(() => Model.decode(bytes, levels, vertices, triangles));
    this.mesh = arraysOf(this.model);
  }

  /** What a view changes; the first one begins with the coarsest level. Throws a DecodeError where the surface cannot be refined in parts. */
  refine({ eye, frustum, focalLength, within }: ModelView): Redrawn {
    const { model } = this;
    if (this.mesh.levels.at(-1)!.vertexEnd > MOST_REFINED) throw new DecodeError(`it has more than ${MOST_REFINED.toLocaleString("en")} vertices`);
    const redrawn = orDecodeError(() => model.refine(Float64Array.from(eye), Float64Array.from(frustum), focalLength, within));
    const { triangles, places, corners, vertices, positions, changes } = redrawn;
    redrawn.free();
    return { triangles, places, corners, vertices, positions, changes };
  }

  free(): void {
    this.model.free();
  }
}
