//! Surfaces in space: polygonal models are simplified, and the distance between two surfaces is measured.

pub(crate) mod distance;
pub(crate) mod facet_tree;
pub mod hausdorff;
pub mod simplify;
