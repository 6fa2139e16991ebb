//! A [`QuantizedMesh`] from bytes of any maker.

use glam::DVec3;
use thiserror::Error;

use super::encode::{MEASURED_EXTENSION, NORMALS_EXTENSION, SHORT_INDEX_VERTICES, WATER_MASK_EXTENSION};
use super::{EXTENT, QuantizedMesh, Vertex};
use crate::water::MASK_SIDE;

/// How much a tile may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuantizedMeshLimits {
    /// Largest number of vertices.
    pub vertices: u32,
    /// Largest number of triangles.
    pub triangles: u32,
}

impl Default for QuantizedMeshLimits {
    fn default() -> Self {
        Self {
            vertices: 1 << 22,
            triangles: 1 << 23,
        }
    }
}

/// Why bytes are not a quantized-mesh tile.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum QuantizedMeshError {
    /// The bytes end inside what is named.
    #[error("cut short in the {0}")]
    Truncated(&'static str),
    /// A count is larger than the limits allow.
    #[error("{count} {what}, the limit is {limit}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many the tile says it has.
        count: u32,
        /// How many are allowed.
        limit: u32,
    },
    /// A number of the header is NaN, infinite, or the heights are upside down.
    #[error("the header has numbers that cannot be")]
    BadHeader,
    /// A coordinate leaves 0…32767.
    #[error("vertex {0} is outside the tile")]
    BadVertex(usize),
    /// An index points at no vertex.
    #[error("index {position} of the {what} points at no vertex")]
    BadIndex {
        /// Which array.
        what: &'static str,
        /// Where in it.
        position: usize,
    },
    /// The length of an extension does not fit what it holds.
    #[error("extension {0} has a wrong length")]
    BadExtension(u8),
}

/// Reads a tile. Extensions it does not know are skipped.
///
/// # Errors
/// The first thing that is wrong.
pub fn decode(bytes: &[u8], limits: &QuantizedMeshLimits) -> Result<QuantizedMesh, QuantizedMeshError> {
    let mut input = Input { rest: bytes };
    let mut mesh = read_header(&mut input)?;
    mesh.vertices = read_vertices(&mut input, limits)?;
    let width = if mesh.vertices.len() <= SHORT_INDEX_VERTICES {
        2
    } else {
        4
    };
    if width == 4 {
        input.take((bytes.len() - input.rest.len()).wrapping_neg() % 4, "padding")?;
    }
    mesh.triangles = read_triangles(&mut input, limits, mesh.vertices.len(), width)?;
    for edge in &mut mesh.edges {
        let count = input.u32("edge lists")?;
        *edge = read_indices(&mut input, count as usize, width, "edge lists")?;
        check_indices(edge, mesh.vertices.len(), "edge lists")?;
    }
    while !input.rest.is_empty() {
        read_extension(&mut input, &mut mesh)?;
    }
    Ok(mesh)
}

fn read_header(input: &mut Input) -> Result<QuantizedMesh, QuantizedMeshError> {
    let center = input.vector()?;
    let heights = [input.f32()?, input.f32()?];
    let sphere_center = input.vector()?;
    let sphere_radius = input.f64()?;
    let horizon_occlusion_point = input.vector()?;
    let finite = [center, sphere_center, horizon_occlusion_point]
        .iter()
        .all(|vector| vector.is_finite());
    let sound = heights.iter().all(|height| height.is_finite()) && heights[0] <= heights[1];
    if !finite || !sound || !sphere_radius.is_finite() || sphere_radius < 0.0 {
        return Err(QuantizedMeshError::BadHeader);
    }
    Ok(QuantizedMesh {
        center,
        heights,
        sphere_center,
        sphere_radius,
        horizon_occlusion_point,
        vertices: Vec::new(),
        triangles: Vec::new(),
        edges: Default::default(),
        normals: None,
        water_mask: None,
        measured_triangles: None,
    })
}

fn read_vertices(input: &mut Input, limits: &QuantizedMeshLimits) -> Result<Vec<Vertex>, QuantizedMeshError> {
    let count = input.count("vertices", limits.vertices)?;
    let u = read_coordinates(input, count)?;
    let v = read_coordinates(input, count)?;
    let height = read_coordinates(input, count)?;
    let triples = u.into_iter().zip(v).zip(height);
    Ok(triples.map(|((u, v), height)| Vertex { u, v, height }).collect())
}

fn read_coordinates(input: &mut Input, count: usize) -> Result<Vec<u16>, QuantizedMeshError> {
    let mut value = 0;
    let codes = input
        .take(count * 2, "vertices")?
        .chunks_exact(2)
        .map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    let values = codes.enumerate().map(|(index, code)| {
        value += i32::from(code >> 1) ^ -i32::from(code & 1);
        u16::try_from(value)
            .ok()
            .filter(|value| *value <= EXTENT)
            .ok_or(QuantizedMeshError::BadVertex(index))
    });
    values.collect()
}

/// High-water-mark codes: each is how far its index is below the next one never used.
fn read_triangles(
    input: &mut Input,
    limits: &QuantizedMeshLimits,
    vertices: usize,
    width: usize,
) -> Result<Vec<[u32; 3]>, QuantizedMeshError> {
    let what = "triangles";
    let count = input.count(what, limits.triangles)?;
    let mut indices = read_indices(input, count * 3, width, what)?;
    let mut next = 0_u32;
    for (position, index) in indices.iter_mut().enumerate() {
        let code = *index;
        *index = next
            .checked_sub(code)
            .ok_or(QuantizedMeshError::BadIndex { what, position })?;
        next += u32::from(code == 0);
    }
    check_indices(&indices, vertices, what)?;
    Ok(indices.as_chunks().0.to_vec())
}

fn read_indices(
    input: &mut Input,
    count: usize,
    width: usize,
    what: &'static str,
) -> Result<Vec<u32>, QuantizedMeshError> {
    let bytes = input.take(
        count.checked_mul(width).ok_or(QuantizedMeshError::Truncated(what))?,
        what,
    )?;
    let little_endian = |index: &[u8]| index.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
    Ok(bytes.chunks_exact(width).map(little_endian).collect())
}

fn check_indices(indices: &[u32], vertices: usize, what: &'static str) -> Result<(), QuantizedMeshError> {
    match indices.iter().position(|&index| index as usize >= vertices) {
        Some(position) => Err(QuantizedMeshError::BadIndex { what, position }),
        None => Ok(()),
    }
}

fn read_extension(input: &mut Input, mesh: &mut QuantizedMesh) -> Result<(), QuantizedMeshError> {
    let what = "extensions";
    let id = input.take(1, what)?[0];
    let length = input.u32(what)?;
    let content = input.take(length as usize, what)?;
    match id {
        NORMALS_EXTENSION => {
            let (pairs, rest) = content.as_chunks();
            if pairs.len() != mesh.vertices.len() || !rest.is_empty() {
                return Err(QuantizedMeshError::BadExtension(id));
            }
            mesh.normals = Some(pairs.to_vec());
        }
        WATER_MASK_EXTENSION => {
            if ![1, MASK_SIDE * MASK_SIDE].contains(&content.len()) {
                return Err(QuantizedMeshError::BadExtension(id));
            }
            mesh.water_mask = Some(content.to_vec());
        }
        MEASURED_EXTENSION => {
            let count = content
                .try_into()
                .map(u32::from_le_bytes)
                .map_err(|_| QuantizedMeshError::BadExtension(id))?;
            if count as usize > mesh.triangles.len() {
                return Err(QuantizedMeshError::BadExtension(id));
            }
            mesh.measured_triangles = Some(count);
        }
        _ => {}
    }
    Ok(())
}

/// What is left of the bytes.
struct Input<'a> {
    rest: &'a [u8],
}

impl<'a> Input<'a> {
    fn take(&mut self, length: usize, what: &'static str) -> Result<&'a [u8], QuantizedMeshError> {
        let (taken, rest) = self
            .rest
            .split_at_checked(length)
            .ok_or(QuantizedMeshError::Truncated(what))?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], QuantizedMeshError> {
        let (taken, rest) = self
            .rest
            .split_first_chunk()
            .ok_or(QuantizedMeshError::Truncated(what))?;
        self.rest = rest;
        Ok(*taken)
    }

    fn u32(&mut self, what: &'static str) -> Result<u32, QuantizedMeshError> {
        self.array(what).map(u32::from_le_bytes)
    }

    fn count(&mut self, what: &'static str, limit: u32) -> Result<usize, QuantizedMeshError> {
        let count = self.u32(what)?;
        if count > limit {
            Err(QuantizedMeshError::TooMany { what, count, limit })
        } else {
            Ok(count as usize)
        }
    }

    fn f32(&mut self) -> Result<f32, QuantizedMeshError> {
        self.array("header").map(f32::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64, QuantizedMeshError> {
        self.array("header").map(f64::from_le_bytes)
    }

    fn vector(&mut self) -> Result<DVec3, QuantizedMeshError> {
        Ok(DVec3::new(self.f64()?, self.f64()?, self.f64()?))
    }
}
