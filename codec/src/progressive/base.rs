//! The base mesh in bits: a handful of vertices and triangles, or whatever cannot be collapsed.
//!
//! Vertices are numbered as triangles name them first. A corner is told by how far it is behind the next new number.

use glam::DVec3;

use super::number::NumberModel;
use super::range_coder::Coder;

/// How far base vertices are taken to be from each other, in lattice units.
const USUAL_DISTANCE: f64 = 16_384.0;
/// How far behind the next new number a corner is taken to be.
const USUAL_GAP: f64 = 4.0;

/// A mesh of whole-numbered positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Base {
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Base {
    /// Codes as many vertices and triangles; none where an index or a position is out of range.
    pub(super) fn code(
        coder: &mut impl Coder,
        [vertex_count, triangle_count]: [usize; 2],
        [low, high]: [DVec3; 2],
        told: &Self,
    ) -> Option<Self> {
        let mut models: [NumberModel; 4] = Default::default();
        let mut base = Self::default();
        let mut previous = low;
        for vertex in 0..vertex_count {
            let position = told.positions.get(vertex).copied().unwrap_or_default();
            for axis in 0..3 {
                let guess = USUAL_DISTANCE;
                let difference = position[axis] - previous[axis];
                previous[axis] += models[axis].code(coder, guess, 0, difference);
            }
            let is_inside = previous.cmpge(low).all() && previous.cmple(high).all();
            if !is_inside || coder.is_exhausted() {
                return None;
            }
            base.positions.push(previous);
        }
        let mut next = 0;
        for triangle in 0..triangle_count {
            let corners = told.triangles.get(triangle).copied().unwrap_or_default();
            let mut read = [0; 3];
            for (corner, read) in corners.into_iter().zip(&mut read) {
                let back = models[3].code(coder, USUAL_GAP, 0, f64::from(next) - f64::from(corner));
                if back < 0.0 || back > f64::from(next) {
                    return None;
                }
                *read = next - back as u32;
                next += u32::from(back == 0.0);
            }
            let [a, b, c] = read;
            let is_triangle = a != b && b != c && c != a && next as usize <= vertex_count;
            if !is_triangle || coder.is_exhausted() {
                return None;
            }
            base.triangles.push(read);
        }
        Some(base)
    }
}
