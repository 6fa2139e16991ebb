//! Pure algorithms of terrain level of detail: a mesh is triangulated, simplified inside a tolerance volume into a
//! [`CollapseLog`], and the log is turned into a [`SurfacePartition`], from which every level of detail is a prefix.
//!
//! ```text
//! reference ──triangulate, refine──▶ Surface ──thin──▶ Mesh ──simplify──▶ CollapseLog ──partition──▶ SurfacePartition
//! ```
//!
//! Nothing here knows a file, a thread, a raster format, a coordinate reference system or a tile.
//!
//! | paper section | module |
//! | --- | --- |
//! | Surface Partitions §1.1 stars, 2-manifolds | [`connectivity`], [`manifold`], [`parting`] |
//! | Surface Partitions §2.1 representatives, §2.2 levels | [`replay`], [`partition`] |
//! | Surface Partitions §2.2 changing the level, path compression | [`level_view`] |
//! | Surface Partitions §2.3 moving red vertices, attributes | [`attribute`] |
//! | Surface Partitions §2.4 collapse logs of any simplifier | [`collapse_log`], [`collapse_list`] |
//! | Surface Partitions §3 graph of the collapses | [`dag`] |
//! | Surface Partitions §3 local levels of detail, queues | [`adaptive_surface`], [`refinement_queues`], [`view_error`] |
//! | Streaming Geometry, progressive multilevel mesh, its file, geomorphs | [`multilevel`] |
//! | Streaming Geometry, vertex clustering | [`clustering`] |
//! | Streaming Geometry, coupling with a geometry-compression method | [`forest_split`] |
#![forbid(unsafe_code)]

pub mod adaptive_surface;
pub mod attribute;
pub mod chain;
pub mod clustering;
mod collapse;
pub mod collapse_list;
pub mod collapse_log;
pub mod compressed_rows;
pub mod connectivity;
pub mod dag;
mod distance;
mod facet_tree;
mod fan;
mod filters;
pub mod forest_split;
mod half_edges;
pub mod hausdorff;
mod improve;
mod index_set;
mod interval;
pub mod level_view;
pub mod manifold;
pub mod mesh;
pub mod model;
pub mod multilevel;
mod outline;
pub mod parting;
pub mod partition;
pub mod plan;
pub mod reference;
pub mod refine;
pub mod refinement_queues;
pub mod replay;
mod samples;
pub mod scan;
pub mod simplify;
pub mod surface;
pub mod triangulate;
pub mod view_error;

pub use collapse_log::{Band, Collapse, CollapseLog};
pub use mesh::Mesh;
pub use partition::SurfacePartition;
pub use surface::Surface;
