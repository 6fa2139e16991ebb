//! What is streamed, and its bytes: tiles, meshes and curved levels, from coarse to fine.
//!
//! ```text
//! address, ellipsoid ──▶ tile ───▶ spt     a progressive tile                     docs/formats/spt.md
//! where on the Earth               spm     a progressive mesh of any manifold     docs/formats/spm.md
//!                                  clod    curved levels of detail                docs/formats/clod.md
//! filled ──────────────▶ tile              which of its ground was not measured
//! progressive ─────────▶ spt, spm          vertex splits as bytes
//! ```
//! It has no files, no threads and no foreign code: it runs in a browser as it does elsewhere.
#![forbid(unsafe_code)]

pub mod address;
pub mod clod;
#[cfg(test)]
#[path = "damage_tests.rs"]
mod damage;
pub mod ellipsoid;
mod fields;
pub mod filled;
mod level_stream;
pub mod progressive;
pub mod spm;
pub mod spt;
pub mod tile;

pub use fields::{DecodeError, LevelLimits};
