//! 3D Tiles 1.1 (OGC 22-025r4): tiles as GLB, and two kinds of tilesets over them.
//!
//! ```text
//!  tile ─▶ finest surface, as it is ───────────────▶ GLB ◀── explicit tileset: each tile's own certified error
//!  tile ─▶ quantized-mesh, over the whole square ──▶ GLB ◀── implicit tileset: two roots, as CesiumJS wants terrain
//! ```
//!
//! `docs/formats/3d-tiles.md` tells what is in them, and why there are two.

mod compressed;
mod explicit;
mod glb;
mod implicit;
mod packing;
mod region;
mod surface;

pub use explicit::{DOCUMENT_ZOOMS, Described, document};
pub use glb::file;
pub use implicit::{SUBTREE_LEVELS, Squares, subtree, tileset};
pub use packing::Packing;
pub use surface::TileSurface;

#[cfg(test)]
#[path = "three_d_tiles_tests.rs"]
mod tests;
