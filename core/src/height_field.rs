//! Height fields: a mesh over a grid of samples is triangulated, refined and simplified inside a tolerance volume.
//!
//! ```text
//! reference ──triangulate, refine──▶ Surface ──thin──▶ Mesh ──simplify──▶ CollapseLog
//! ```

pub(crate) mod attempts;
pub(crate) mod bilinear;
pub mod blocks;
pub mod chain;
pub mod chunks;
pub(crate) mod corner_fit;
pub mod cubic;
pub mod cubic_surface;
pub(crate) mod evaluator;
pub(crate) mod fan;
pub(crate) mod filters;
pub mod finer;
pub(crate) mod flat;
pub mod ground;
pub mod heights;
pub(crate) mod improve;
pub(crate) mod interval;
pub(crate) mod kept_chains;
pub mod plan;
pub mod reference;
pub mod refine;
pub mod relief;
pub(crate) mod ring;
pub mod rules;
pub(crate) mod sampled_surface;
pub(crate) mod samples;
pub mod scan;
pub mod simplify;
pub mod snapping;
pub mod surface;
pub mod triangulate;
