//! Pure algorithms of terrain level of detail: a mesh is triangulated, simplified inside a tolerance volume into a
//! [`CollapseLog`], and the log is turned into a [`SurfacePartition`], from which every level of detail is a prefix.
//!
//! ```text
//!  mesh ◀── topology ◀─┬─ levels ◀─┬─ height_field      surfaces over a grid of samples
//!                      │      │    ├─ space             surfaces in space
//!                      ├──────┼────┴─ streaming         progressive multilevel meshes
//!                      └─ curved                        surfaces of Bézier patches
//!  selection ◀────────────────┘                         which of many surfaces to draw, at which level
//! ```
//!
//! Nothing here knows a file, a thread, a raster format, a coordinate reference system or a tile.
#![forbid(unsafe_code)]

pub mod curved;
pub mod height_field;
pub mod levels;
pub mod mesh;
pub mod selection;
pub mod space;
pub mod streaming;
pub mod topology;

pub use height_field::surface::Surface;
pub use levels::collapse_log::{Band, Collapse, CollapseLog};
pub use levels::partition::SurfacePartition;
pub use mesh::Mesh;
