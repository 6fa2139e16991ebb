//! Where tiles are, what is in them, and how they become bytes: addresses of the geographic scheme, the global
//! lattice, the progressive codec, file formats, and the archive.
//!
//! ```text
//! address, ellipsoid ──▶ tile ──────────▶ formats::spt ─────▶ archive ◀── metadata ──▶ layer_json
//! where on the Earth     what is there    quantized_mesh      all tiles   of the whole   for map clients
//!                                                             tile_file   any tiles, as PMTiles
//!
//! tile ────────────────▶ ground                              heights at places
//! ground ──────────────▶ raster_dem                          raster tiles of heights
//! tile ────────────────▶ pyramid                             what to select from
//! tile ────────────────▶ shading                             its finest surface, with normals, for formats of others
//!
//! progressive ─────────▶ formats::spt, formats::spm           vertex splits as bytes
//!
//! formats, readers beside writers
//!   spt             a progressive tile                        read, written      docs/formats/spt.md
//!   spm             a progressive mesh of any manifold        read, written      docs/formats/spm.md
//!   clod            curved levels of detail                   read, written      docs/formats/clod.md
//!   lod             a multilevel mesh as text                 read, written      (the papers' grammar)
//!   ply, obj, gltf  a mesh of polygons                        read, written
//!   stl, off        a mesh of polygons                        read
//!   bezier          tensor-product Bézier patches             read
//!   x3d             a world that streams a `.lod` file        written            docs/formats/world.md
//!   quantized_mesh  a tile for map clients                    read, written      docs/formats/quantized-mesh.md
//! ```
#![forbid(unsafe_code)]

pub mod address;
pub mod archive;
pub mod ellipsoid;
pub mod filled;
pub mod formats;
pub mod ground;
pub mod layer_json;
pub mod mercator;
pub mod metadata;
pub mod new_file;
pub mod outside;
pub mod progressive;
pub mod pyramid;
pub mod raster_dem;
pub mod shading;
pub mod spread;
pub mod tile;
pub mod tile_file;
pub mod water;
