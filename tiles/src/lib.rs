//! Where tiles are, what is in them, and how they become bytes: addresses of the geographic scheme, the global
//! lattice, the progressive tile format, the archive, and encoders for map clients.
#![forbid(unsafe_code)]

pub mod address;
pub mod archive;
pub mod codec;
#[cfg(test)]
#[path = "damage_tests.rs"]
mod damage;
pub mod ellipsoid;
mod fields;
pub mod layer_json;
pub mod metadata;
pub mod model;
pub mod progressive;
pub mod quantized_mesh;
pub mod tile;
pub mod x3d;
