//! Heights of terrain at places: an archive is opened once and asked by any number of threads.
//!
//! ```text
//! place ─▶ tile of a zoom ─▶ its surface, decoded once and kept ─▶ height, certified error, normal
//! metres east and north in a local frame ─▶ the frame's vertical there ─▶ the tiles that it may pass through ─▶ the same
//! ```
//! `capi` is the same for C; `include/terrain_heights.h` describes it.

mod capi;
mod frame;
mod heights;

pub use capi::*;
pub use frame::Frame;
pub use heights::{Heights, HeightsError, Place};
pub use terrain_tiles::ground::Point;
