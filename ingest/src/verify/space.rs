//! The spaces in which triangles are flat: Earth-centred metres for tiles, the raster's own grid for plain meshes.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use terrain_tiles::ellipsoid::{ECCENTRICITY_SQUARED, SEMI_MAJOR, normal, to_geodetic};

use super::reference::Reference;
use crate::height_grid::HeightGrid;

/// A point of a mesh seen from above.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// Column and row.
    pub(super) grid: DVec2,
    /// Metres.
    pub(super) height: f64,
}

/// Where planes are planes.
pub(super) trait Space: Sync {
    /// The direction along which the deviation at a post is measured, of length 1.
    fn vertical(&self, column: usize, row: usize) -> DVec3;
    /// Where a height at a post is.
    fn position(&self, column: usize, row: usize, height: f64) -> DVec3;
    /// What is under (or over) a point.
    fn foot(&self, position: DVec3) -> Foot;
    /// Whether the foot of a point has no definite place in the grid: the poles.
    fn is_singular(&self, position: DVec3) -> bool;
}

/// The ellipsoid's normal at every post, by row.
pub(super) fn normals(grid: &HeightGrid) -> Vec<DVec3> {
    (0..grid.heights.len())
        .into_par_iter()
        .map(|index| {
            let post = DVec2::new((index % grid.columns) as f64, (index / grid.columns) as f64);
            let place = grid.georeference.geographic(post);
            normal(place.x, place.y)
        })
        .collect()
}

/// Earth-centred metres.
pub(super) struct Earth<'a> {
    pub(super) reference: &'a Reference<'a>,
    pub(super) normals: &'a [DVec3],
    /// Longitudes are taken from the half-turn on either side of this one: the raster's may exceed 180°.
    pub(super) middle_longitude: f64,
}

impl Space for Earth<'_> {
    fn vertical(&self, column: usize, row: usize) -> DVec3 {
        self.normals[row * self.reference.grid.columns + column]
    }

    fn position(&self, column: usize, row: usize, height: f64) -> DVec3 {
        let up = self.vertical(column, row);
        let prime_vertical = SEMI_MAJOR / (1.0 - ECCENTRICITY_SQUARED * up.z * up.z).sqrt();
        let polar = prime_vertical * (1.0 - ECCENTRICITY_SQUARED);
        up * DVec3::new(prime_vertical + height, prime_vertical + height, polar + height)
    }

    fn foot(&self, position: DVec3) -> Foot {
        let place = to_geodetic(position);
        let turns = ((self.middle_longitude - place.longitude) / 360.0).round();
        let geographic = DVec2::new(place.longitude + 360.0 * turns, place.latitude);
        Foot {
            grid: self.reference.grid.georeference.grid(geographic),
            height: place.height,
        }
    }

    fn is_singular(&self, position: DVec3) -> bool {
        position.truncate().length_squared() < 1e-4
    }
}

/// Column, row, metres: an affine picture of the raster's own reference system.
pub(super) struct Raster;

impl Space for Raster {
    fn vertical(&self, _: usize, _: usize) -> DVec3 {
        DVec3::Z
    }

    fn position(&self, column: usize, row: usize, height: f64) -> DVec3 {
        DVec3::new(column as f64, row as f64, height)
    }

    fn foot(&self, position: DVec3) -> Foot {
        Foot {
            grid: position.truncate(),
            height: position.z,
        }
    }

    fn is_singular(&self, _: DVec3) -> bool {
        false
    }
}
