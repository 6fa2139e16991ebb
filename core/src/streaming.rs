//! What the paper on streaming geometry describes: progressive multilevel meshes, their file, and other ways to them.
//!
//! | paper section | module |
//! | --- | --- |
//! | Streaming Geometry, progressive multilevel mesh, its file, geomorphs | [`multilevel`] |
//! | Streaming Geometry, vertex clustering | [`clustering`] |
//! | Streaming Geometry, coupling with a geometry-compression method | [`forest_split`] |

pub mod clustering;
pub mod forest_split;
pub mod multilevel;
