//! What files of polygons hold: `.ply`, `.obj`, `.stl`, `.off`, `.gltf` and `.glb`.

use std::io;

use glam::DVec3;
use thiserror::Error;

/// Numbers that vertices have besides their position, such as one component of a normal or a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// As PLY files call it: `nx`, `red`, `s`.
    pub name: String,
    /// What a file keeps it as.
    pub storage: Storage,
    /// One number a vertex.
    pub values: Vec<f64>,
}

/// How a file keeps a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// A whole number from 0 to 255.
    Byte,
    /// Single precision.
    Float,
    /// Double precision.
    Double,
}

/// How much a file of polygons may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolygonLimits {
    /// Vertices.
    pub vertices: u32,
    /// Triangles that its polygons become.
    pub triangles: u32,
}

impl Default for PolygonLimits {
    /// 2²⁷ vertices and twice as many triangles.
    fn default() -> Self {
        Self {
            vertices: 1 << 27,
            triangles: 1 << 28,
        }
    }
}

/// Why a file cannot be read.
#[derive(Debug, Error)]
pub enum PolygonError {
    /// The system says no.
    #[error("cannot be read")]
    Unreadable(#[from] io::Error),
    /// The bytes are not of the format.
    #[error("not a readable {format} file: {reason}")]
    Malformed {
        /// Name of the format.
        format: &'static str,
        /// What its reader says.
        reason: String,
    },
    /// A face uses a vertex that is not there.
    #[error("face {face} uses vertex {vertex}, but there are {count} (counted from 0)")]
    BadIndex {
        /// Number of the face.
        face: usize,
        /// What it uses.
        vertex: u64,
        /// Vertices there are.
        count: usize,
    },
    /// More than the limits allow.
    #[error("more than {0} {1}")]
    TooLarge(u32, &'static str),
}

/// Vertices and triangles as a file has them: positions may be there several times.
#[derive(Clone, Debug, Default)]
pub struct Polygons {
    /// One a vertex, in the file's units; not checked to be finite.
    pub positions: Vec<DVec3>,
    /// What its vertices have besides positions.
    pub columns: Vec<Column>,
    /// Polygons as fans around their first corner; their corners are vertices.
    pub triangles: Vec<[u32; 3]>,
    /// How many polygons there were.
    pub faces: usize,
}

impl Polygons {
    /// Adds a polygon as a fan around its first corner. One of fewer than three corners is none.
    ///
    /// # Errors
    /// A corner that is no vertex, or too many triangles.
    pub(super) fn add_face(&mut self, corners: &[u64], limits: PolygonLimits) -> Result<(), PolygonError> {
        let count = self.positions.len();
        if let Some(&vertex) = corners.iter().find(|&&corner| corner >= count as u64) {
            let face = self.faces;
            return Err(PolygonError::BadIndex { face, vertex, count });
        }
        self.faces += 1;
        let fan = corners.get(1..).unwrap_or_default().windows(2);
        self.triangles
            .extend(fan.map(|pair| [corners[0], pair[0], pair[1]].map(|corner| corner as u32)));
        if self.triangles.len() > limits.triangles as usize {
            return Err(PolygonError::TooLarge(limits.triangles, "triangles"));
        }
        Ok(())
    }
}
