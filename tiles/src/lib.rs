//! What is made of tiles: the archive, what is asked of it, and file formats of others.
//!
//! ```text
//! archive ◀── metadata ──▶ layer_json      all tiles, of the whole, for map clients
//! tile_file                                any tiles, as PMTiles
//!
//! tile ────────────────▶ ground            heights at places
//! ground ──────────────▶ raster_dem        raster tiles of heights
//! tile ────────────────▶ pyramid           what to select from
//! tile ────────────────▶ shading           its finest surface, with normals, for formats of others
//!
//! formats, readers beside writers
//!   lod             a multilevel mesh as text                 read, written      (the papers' grammar)
//!   ply, obj, gltf  a mesh of polygons                        read, written
//!   stl, off        a mesh of polygons                        read
//!   bezier          tensor-product Bézier patches             read
//!   x3d             a world that streams a `.lod` file        written            docs/formats/world.md
//!   quantized_mesh  a tile for map clients                    read, written      docs/formats/quantized-mesh.md
//! ```
#![deny(unsafe_code)]

pub mod archive;
#[cfg(test)]
#[path = "fixture_tests.rs"]
mod fixture;
pub mod formats;
pub mod ground;
pub mod layer_json;
pub mod mercator;
pub mod metadata;
pub mod new_file;
pub mod outside;
pub mod pyramid;
pub mod raster_dem;
pub mod shading;
pub mod spread;
pub mod tile_file;
pub mod water;
