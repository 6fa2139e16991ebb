//! Curved surfaces: cubic triangular Bézier patches and what merges them.
//!
//! Based on M. Gopi, D. Manocha, *A Unified Approach for Simplifying Polygonal and Spline Models*, UNC, 1998.
//!
//! | paper section | module |
//! | --- | --- |
//! | §4 triangular patches, de Casteljau's algorithm | [`patch`] |
//! | §5.1 patches for triangles | [`fit`], with normals at their corners by [`corner_normals`] |
//! | §5.2 patches for tensor-product patches | [`tensor`], halved in `strips`, made [`tensor_triangles`], turned to agree by `orientation` |
//! | (heights on a grid as tensor-product patches) | [`height_patches`] |
//! | §5 the model with its adjacency | [`model`] |
//! | §6.1 mergeable edge pairs and patterns | [`patterns`] |
//! | §7 search for patterns, §8 levels of detail, §10 error | [`simplify`], [`levels`] |
//! | §4.2, §6 merging patterns and swapping a diagonal, §10 what they deviate | [`merging`] |
//! | §1, §2.1 static and dynamic tessellation | [`tessellation`] of [`edge_cuts`], bounded by [`flatness`] |

pub mod corner_normals;
mod curve_twins;
pub mod edge_cuts;
pub mod fit;
pub mod flatness;
pub mod height_patches;
pub mod level_record;
pub mod levels;
pub mod merging;
pub mod model;
mod orientation;
pub mod patch;
mod patch_lattice;
pub mod patterns;
pub mod simplify;
mod strips;
pub mod tensor;
pub mod tensor_triangles;
mod tessellated_numbers;
pub mod tessellation;
