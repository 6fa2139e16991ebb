//! A whole raster as one curved surface of cubic triangular patches, in its own coordinate reference system.
//!
//! ```text
//! outline ← where the raster's valid cells end
//! surface ← its triangulation, refined until every sample is within the error of curved triangles
//! surface ← collapses that keep it so
//! measure ← every sample
//! ```

use std::fmt;

use anyhow::{Context, Result, bail};
use glam::{DVec2, DVec3};
use indicatif::HumanCount;
use serde::Serialize;
use terrain_codec::ellipsoid::METRES_IN_A_DEGREE;
use terrain_core::curved::levels::{CurvedLevels, LevelPatch};
use terrain_core::curved::patch::CubicPatch;
use terrain_core::height_field::cubic::{Cubic, SlopedPoint};
use terrain_core::height_field::cubic_surface::CubicSurface;
use terrain_core::height_field::reference::Bound;

use crate::height_grid::HeightGrid;
use crate::progress::Progress;
use crate::whole_raster::{self, LEAST_ALTITUDE, SHARE};

/// Where the surface is: x and y of its control points are `scale` × (coordinates of the raster's reference system − `origin`),
/// which for degrees is metres east and north, more or less; z is metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Frame {
    /// The south-western corner of the outermost samples, in coordinates of the reference system.
    pub origin: [f64; 2],
    /// Units of x and of y in one of the reference system's.
    pub scale: [f64; 2],
}

/// What was made.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Patches of the surface.
    pub patches: usize,
    /// Corners of patches.
    pub vertices: usize,
    /// Largest difference in metres between the finished surface and a sample.
    pub certified_error: f64,
    /// Where it is.
    pub frame: Frame,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            patches,
            vertices,
            certified_error,
            frame: Frame { origin, scale },
        } = self;
        writeln!(
            f,
            "{patches} cubic patches, {vertices} corners, certified error {certified_error} m (at every sample)"
        )?;
        let ([east, north], [across, up]) = (origin, scale);
        write!(f, "x = {across} · (X − {east}), y = {up} · (Y − {north}), z in metres")
    }
}

/// Makes a curved surface within `max_error` metres of every sample of cells with four of them, as the one level of a curved
/// model.
///
/// # Errors
/// When the error asked for is none, or the raster has no surface.
pub fn run(grid: &HeightGrid, max_error: f64, progress: &Progress) -> Result<(CurvedLevels, Report)> {
    if !(max_error.is_finite() && max_error > 0.0) {
        bail!("the largest error must be more than 0 m");
    }
    let curvature = vec![DVec2::ZERO; grid.rows];
    let reference = whole_raster::reference(grid, &curvature, Bound::Samples);
    progress.open_stage("placing patches");
    let triangulated = whole_raster::triangulated(&reference, &[])?;
    let mut surface = CubicSurface::refined(triangulated, max_error * SHARE, LEAST_ALTITUDE);
    let count = surface.corners().count();
    if count == 0 {
        bail!("the raster has no cell with four valid samples");
    }
    progress.open_stage(&format!("joining {} patches", HumanCount(count as u64)));
    surface.thin(max_error * SHARE);
    progress.done();
    let report = Report {
        patches: surface.corners().count(),
        vertices: surface.vertex_count(),
        certified_error: whole_raster::rounded_up(surface.deviation().size),
        frame: frame(grid),
    };
    Ok((levels(grid, &surface, &report)?, report))
}

fn frame(grid: &HeightGrid) -> Frame {
    let last = DVec2::new((grid.columns - 1) as f64, (grid.rows - 1) as f64);
    let corners = [DVec2::ZERO, DVec2::new(last.x, 0.0), DVec2::new(0.0, last.y), last]
        .map(|corner| grid.georeference.crs_coordinates(corner));
    let low = corners.into_iter().fold(DVec2::INFINITY, DVec2::min);
    let high = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
    let scale = if grid.georeference.is_geographic() {
        let latitude = (low.y + high.y) / 2.0;
        [latitude.to_radians().cos() * METRES_IN_A_DEGREE, METRES_IN_A_DEGREE]
    } else {
        [1.0; 2]
    };
    Frame {
        origin: low.to_array(),
        scale,
    }
}

/// One level of all patches; the error of each is that of the surface.
fn levels(grid: &HeightGrid, surface: &CubicSurface, report: &Report) -> Result<CurvedLevels> {
    let mut used: Vec<u32> = surface.corners().flatten().collect();
    used.sort_unstable();
    used.dedup();
    let number = |corner: u32| used.partition_point(|&vertex| vertex < corner) as u32;
    let patches = surface
        .corners()
        .zip(surface.triangles())
        .filter_map(|(numbers, corners)| {
            let patch = patch(grid, report.frame, corners)?;
            let made = LevelPatch::new(patch, numbers.map(number), [false; 3], report.certified_error);
            Some(made.shown_by(0..1))
        });
    CurvedLevels::from_patches(patches.collect(), 1).context("the patches do not meet")
}

/// Control points are at thirds of the edges: what both patches of an edge compute there is the same to the bit.
fn patch(grid: &HeightGrid, frame: Frame, corners: [SlopedPoint; 3]) -> Option<CubicPatch> {
    let heights = Cubic::through(corners)?.control_heights;
    let [origin, scale] = [frame.origin, frame.scale].map(DVec2::from);
    let [a, b, c] = corners.map(|corner| (grid.georeference.crs_coordinates(corner.point.grid) - origin) * scale);
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
    let mut points = [DVec3::ZERO; 10];
    for ((control, place), height) in points.iter_mut().zip(places).zip(heights) {
        *control = place.extend(height);
    }
    Some(CubicPatch { points })
}
