//! Topology: which vertices and triangles touch. No coordinate is looked at.
//!
//! | paper section | module |
//! | --- | --- |
//! | Surface Partitions §1.1 stars, 2-manifolds | [`connectivity`], [`manifold`], [`parting`] |

pub mod compressed_rows;
pub mod connectivity;
pub(crate) mod edge_collapse;
pub(crate) mod half_edges;
pub(crate) mod index_set;
pub mod manifold;
pub mod parting;
