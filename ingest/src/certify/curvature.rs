//! How far the ground bends away between the corners of a block of cells.
//!
//! Over the unit square a function differs from the bilinear one through its corners by at most an eighth of its greatest
//! second derivatives along both sides. For the height of a plane above the ellipsoid they follow from those of the place
//! c(column, row) in space: with the slope t and the radius R they are at most |n·c″| + t |c″ − n (n·c″)| + 2 t² |c′|² / R.
//!
//! Inside a triangle the last term is at most twice the square of its rise over R, however steep it is. And where the ground is
//! less steep than the triangle everywhere in a cell, the difference has no extreme inside: the slope that matters is at most
//! that of the ground, which no cell makes larger than the highest mountain over its side.

use std::ops::Range;

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::{self, ECCENTRICITY_SQUARED, LEAST_CURVATURE_RADIUS};

use crate::georeference::GeoReference;

/// Third-order terms, and what the places looked at do not show, as a share.
const HIGHER_ORDER: f64 = 1.1;
/// More than the ground rises anywhere, metres.
const HIGHEST: f64 = 10_000.0;
/// Places looked at along each axis.
const PLACES: usize = 5;
/// Cells over which differences are taken: more than rounding of positions in space can spoil.
const STEP: f64 = 8.0;

/// Bounds under a window, by axis: column and row.
pub(super) struct Curvature {
    /// |n·c″|, |c″ − n (n·c″)| and |c′|² / R, metres per squared cell.
    upwards: DVec2,
    sideways: DVec2,
    of_slope: DVec2,
}

impl Curvature {
    pub(super) fn under(georeference: &GeoReference, [columns, rows]: [usize; 2], window: &[Range<usize>; 2]) -> Self {
        let mut found = Self {
            upwards: DVec2::ZERO,
            sideways: DVec2::ZERO,
            of_slope: DVec2::ZERO,
        };
        let last = DVec2::new((columns - 1) as f64, (rows - 1) as f64);
        let step = (last / 2.0).min(DVec2::splat(STEP));
        let share = |place: usize| place as f64 / (PLACES - 1) as f64;
        let along = |range: &Range<usize>, place: usize| range.start as f64 + range.len() as f64 * share(place);
        for place in 0..PLACES * PLACES {
            let at = DVec2::new(along(&window[0], place % PLACES), along(&window[1], place / PLACES));
            found.look(georeference, at.clamp(step, last - step), step);
        }
        found
    }

    fn look(&mut self, georeference: &GeoReference, at: DVec2, step: DVec2) {
        let up = |at: DVec2| {
            let geographic = georeference.geographic(at);
            ellipsoid::normal(geographic.x, geographic.y)
        };
        let normal = up(at);
        let here = ellipsoid::above(normal, 0.0);
        for axis in 0..2 {
            let length = step[axis];
            let mut offset = DVec2::ZERO;
            offset[axis] = length;
            let [before, after]: [DVec3; 2] = [at - offset, at + offset].map(|at| ellipsoid::above(up(at), 0.0));
            let second = (before + after - 2.0 * here) / (length * length);
            let upwards = normal.dot(second);
            let keep = |kept: &mut DVec2, value: f64| kept[axis] = kept[axis].max(value);
            keep(&mut self.upwards, upwards.abs());
            keep(&mut self.sideways, (second - normal * upwards).length());
            keep(
                &mut self.of_slope,
                (after - before).length_squared() / (4.0 * length * length * LEAST_CURVATURE_RADIUS),
            );
        }
    }

    /// Metres by which the height above a plane of that steepness may be more or less inside a block of so many cells along its
    /// side than bilinear between its corners.
    pub(super) fn in_block(&self, side: f64, steepness: f64) -> f64 {
        let second = self.upwards + self.sideways * steepness + self.of_slope * (2.0 * steepness * steepness);
        HIGHER_ORDER * second.element_sum() * side * side / 8.0
    }

    /// The same inside one cell and a triangle that is `extent` columns and rows large and rises by so many metres.
    pub(super) fn in_triangle(&self, extent: DVec2, steepness: f64, rise: f64) -> f64 {
        let cells = extent.min(DVec2::ONE);
        let steps = (self.of_slope * LEAST_CURVATURE_RADIUS).map(f64::sqrt);
        let steepness = steepness.min(HIGHEST / steps.min_element().max(f64::MIN_POSITIVE));
        let rises = (steps * cells * steepness).min(DVec2::splat(rise));
        let bend =
            (self.upwards + self.sideways * steepness) * cells * cells + 2.0 * rises * rises / LEAST_CURVATURE_RADIUS;
        HIGHER_ORDER * bend.element_sum() / 8.0
    }

    /// Metres sideways by which places inside such a block may leave those that are bilinear between its corners, and a share of how far
    /// they are from anything that is added to that.
    ///
    /// How far a place with the ellipsoid's normal n is beyond the vertical plane through an edge is n·(p × q) over the edge's length on a
    /// sphere, and but for the flattening on the ellipsoid: its second derivative is that of the place, and of n times the distance.
    pub(super) fn beside_block(&self, side: f64) -> [f64; 2] {
        let of_block = HIGHER_ORDER * side * side / 8.0;
        let bend = (self.sideways + self.of_slope * (4.0 * ECCENTRICITY_SQUARED)).element_sum();
        [
            of_block * bend,
            of_block * self.of_slope.element_sum() / LEAST_CURVATURE_RADIUS,
        ]
    }
}
