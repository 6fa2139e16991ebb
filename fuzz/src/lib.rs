//! What the fuzz targets have in common.

use terrain_tiles::formats::LevelLimits;

/// Low enough that a made-up count never costs the fuzzer much memory or time, and above what the seeds in `corpus` need.
pub const LIMITS: LevelLimits = LevelLimits {
    levels: 64,
    vertices: 1 << 16,
    triangles: 1 << 17,
};
