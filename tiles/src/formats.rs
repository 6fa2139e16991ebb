//! File formats under one roof, readers beside writers. They read from and write to memory or streams; opening files is the
//! programs'.

#[cfg(test)]
#[path = "formats/damage_tests.rs"]
mod damage;
mod fields;
pub mod lod;
pub mod obj;
pub mod ply;
pub mod polygons;
pub mod quantized_mesh;
pub mod spm;
pub mod spt;
pub mod x3d;

pub use fields::{DecodeError, LevelLimits};
