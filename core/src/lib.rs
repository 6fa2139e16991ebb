//! Pure algorithms of terrain level of detail: a mesh is triangulated, simplified inside a tolerance volume into a
//! [`CollapseLog`], and the log is turned into a [`SurfacePartition`], from which every level of detail is a prefix.
//!
//! ```text
//! reference surface ──triangulate──▶ Mesh ──simplify──▶ CollapseLog ──partition──▶ SurfacePartition
//! ```
//!
//! Nothing here knows a file, a thread, a raster format, a coordinate reference system or a tile.
//!
//! | paper section | module |
//! | --- | --- |
//! | Surface Partitions §2.1 representatives, §2.2 levels, §2.3 moving red vertices | [`partition`] |
//! | Surface Partitions §2.4 collapse logs of any simplifier | [`collapse_log`] |
#![forbid(unsafe_code)]

pub mod chain;
pub mod clustering;
pub mod collapse_log;
mod filters;
pub mod mesh;
pub mod multilevel;
mod outline;
pub mod partition;
pub mod plan;
pub mod reference;
pub mod simplify;
pub mod triangulate;

pub use collapse_log::{Band, Collapse, CollapseLog};
pub use mesh::Mesh;
pub use partition::SurfacePartition;
