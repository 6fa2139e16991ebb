//! File formats of others under one roof, readers beside writers. They read from and write to memory or streams; opening files is the
//! programs'.

pub mod bezier;
pub mod gltf;
pub mod lod;
pub mod obj;
pub mod off;
pub mod ply;
pub mod polygons;
pub mod quantized_mesh;
pub mod stl;
pub mod three_d_tiles;
pub mod x3d;
