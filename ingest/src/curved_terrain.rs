//! A whole raster as one curved surface of cubic triangular patches, in its own coordinate reference system.
//!
//! ```text
//! outline ← where the raster's valid cells end
//! surface ← its triangulation, refined until every sample is within the error of curved triangles
//! surface ← collapses that keep it so
//! measure ← every sample
//! ```

use std::fmt;

use anyhow::{Result, bail};
use glam::DVec3;
use indicatif::HumanCount;
use serde::Serialize;
use terrain_core::height_field::cubic::{Cubic, SlopedPoint};
use terrain_core::height_field::cubic_surface::CubicSurface;
use terrain_core::height_field::reference::Bound;

use crate::height_grid::HeightGrid;
use crate::progress::Progress;
use crate::whole_raster::{self, LEAST_ALTITUDE, SHARE};

/// Control points of a patch, metres above x and y of the raster's reference system, in the order 300 210 201 120 111 102
/// 030 021 012 003.
pub type Patch = [DVec3; 10];

/// What was made.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Patches of the surface.
    pub patches: usize,
    /// Corners of patches.
    pub vertices: usize,
    /// Largest difference in metres between the finished surface and a sample.
    pub certified_error: f64,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            patches,
            vertices,
            certified_error,
        } = self;
        write!(
            f,
            "{patches} cubic patches, {vertices} corners, certified error {certified_error} m (at every sample)"
        )
    }
}

/// Makes a curved surface within `max_error` metres of every sample of cells with four of them.
///
/// # Errors
/// When the error asked for is none, or the raster has no surface.
pub fn run(grid: &HeightGrid, max_error: f64, progress: &Progress) -> Result<(Vec<Patch>, Report)> {
    if !(max_error.is_finite() && max_error > 0.0) {
        bail!("the largest error must be more than 0 m");
    }
    let curvature = vec![glam::DVec2::ZERO; grid.rows];
    let reference = whole_raster::reference(grid, &curvature, Bound::Samples);
    progress.open_stage("placing patches");
    let triangulated = whole_raster::triangulated(&reference)?;
    let mut surface = CubicSurface::refined(triangulated, max_error * SHARE, LEAST_ALTITUDE);
    let count = surface.triangles().count();
    if count == 0 {
        bail!("the raster has no cell with four valid samples");
    }
    progress.open_stage(&format!("joining {} patches", HumanCount(count as u64)));
    surface.thin(max_error * SHARE);
    progress.done();
    let patches: Vec<Patch> = surface.triangles().filter_map(|corners| patch(grid, corners)).collect();
    let report = Report {
        patches: patches.len(),
        vertices: surface.vertex_count(),
        certified_error: whole_raster::rounded_up(surface.deviation().size),
    };
    Ok((patches, report))
}

/// Corners are at thirds of the edges: what both patches of an edge compute there is the same to the bit.
fn patch(grid: &HeightGrid, corners: [SlopedPoint; 3]) -> Option<Patch> {
    let heights = Cubic::through(corners)?.control_heights;
    let [a, b, c] = corners.map(|corner| grid.georeference.crs_coordinates(corner.point.grid));
    let places = [
        a,
        (2.0 * a + b) / 3.0,
        (2.0 * a + c) / 3.0,
        (2.0 * b + a) / 3.0,
        (a + b + c) / 3.0,
        (2.0 * c + a) / 3.0,
        b,
        (2.0 * b + c) / 3.0,
        (2.0 * c + b) / 3.0,
        c,
    ];
    let mut patch = [DVec3::ZERO; 10];
    for ((control, place), height) in patch.iter_mut().zip(places).zip(heights) {
        *control = place.extend(height);
    }
    Some(patch)
}
