//! Curved surfaces: cubic triangular Bézier patches and what merges them.
//!
//! Based on M. Gopi, D. Manocha, *A Unified Approach for Simplifying Polygonal and Spline Models*, UNC, 1998.
//!
//! | paper section | module |
//! | --- | --- |
//! | §4 triangular patches, de Casteljau's algorithm | [`patch`] |
//! | §5.1 patches for triangles | [`fit`] |
//! | §5.2 patches for tensor-product patches | [`tensor`] |
//! | §5 the model with its adjacency | [`model`] |
//! | §6.1 mergeable edge pairs and patterns | [`patterns`] |
//! | §7 search for patterns, §8 levels of detail, §10 error | [`simplify`], [`levels`] |
//! | §4.2, §6 merging patterns and swapping a diagonal, §10 what they deviate | [`merging`] |

pub mod fit;
pub mod levels;
pub mod merging;
pub mod model;
pub mod patch;
pub mod patterns;
pub mod simplify;
pub mod tensor;
