//! Heights of terrain at places: an archive is opened once and asked by any number of threads.
//!
//! ```text
//! place ─▶ tile of a zoom ─▶ its surface, decoded once and kept ─▶ height, certified error, normal
//! ```
//! `capi` is the same for C; `include/terrain_heights.h` describes it.

mod capi;
mod heights;

pub use capi::*;
pub use heights::{Heights, HeightsError, Place};
pub use terrain_tiles::ground::Point;
