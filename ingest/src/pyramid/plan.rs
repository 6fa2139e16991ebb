//! What is decided before the first tile is made, and the names that follow from it.

use glam::DVec2;
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::simplify::Quality;

use terrain_tiles::ellipsoid::METRES_IN_A_DEGREE;

use super::Options;
use crate::georeference::GeoReference;
use crate::lattice::{Lattice, Square};
use crate::store::Name;
use crate::tin::bound_name;

/// Counts up whenever the same inputs would give other tiles than before: what was made then is not taken for what is made now.
const ALGORITHM: u32 = 1;
/// Samples across a leaf tile, roughly: enough triangles that its sides do not weigh much.
const SAMPLES_ACROSS_A_LEAF: f64 = 128.0;
/// The asked error where none is given, in cells: a slope of about 6 % over one cell.
const DEFAULT_ERROR_IN_CELLS: f64 = 1.0 / 16.0;
/// Height steps in the asked error, at least.
const STEPS_IN_AN_ERROR: f64 = 64.0;

/// What holds for all tiles of a build.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) lattice: Lattice,
    /// Largest error of the leaves, metres.
    pub(crate) max_error: f64,
    pub(crate) bound: Bound,
    pub(crate) quality: Quality,
    /// West, south, east, north of the samples, degrees.
    pub(crate) bounds: [f64; 4],
    /// Of all of this: other parameters make other tiles.
    pub(crate) name: Name,
}

impl Plan {
    pub(crate) fn new(georeference: &GeoReference, size: [usize; 2], options: &Options) -> Self {
        let centre = DVec2::new(size[0] as f64 - 1.0, size[1] as f64 - 1.0) / 2.0;
        let cell = georeference.cell_metres(centre).min_element();
        let max_error = options.max_error.unwrap_or_else(|| default_error(cell));
        let lattice = lattice(cell, max_error);
        let parameters = format!(
            "{ALGORITHM} {lattice:?} {max_error:?} {} {:?} {}",
            bound_name(options.bound),
            options.quality,
            georeference.fingerprint(),
        );
        Self {
            lattice,
            max_error,
            bound: options.bound,
            quality: options.quality,
            bounds: georeference.geographic_bounds(),
            name: Name::of([parameters.as_bytes()]),
        }
    }

    /// The error of a zoom's finest surfaces, metres.
    pub(crate) fn error_at(&self, zoom: u8) -> f64 {
        self.max_error * f64::from(self.lattice.leaf_zoom - zoom).exp2()
    }

    /// Zooms that a square is above the leaves.
    pub(crate) fn height(&self, square: Square) -> u8 {
        self.lattice.leaf_zoom - square.zoom
    }

    /// The squares of zoom 0 that the samples may lie in.
    pub(crate) fn roots(&self) -> Vec<Square> {
        let extent = self.lattice.extent(0) as f64;
        let [west, _, east, _] = self.bounds;
        let column = |longitude: f64| self.lattice.global(DVec2::new(longitude, 0.0)).x / extent;
        let columns = column(west).floor() as i64..(column(east).ceil() as i64).max(column(west).floor() as i64 + 1);
        columns.map(|x| Square { zoom: 0, x, y: 0 }).collect()
    }
}

/// The error that suits cells of such a size: a sixteenth of one, rounded to 1, 2 or 5 times a power of ten.
#[must_use]
pub(crate) fn default_error(cell: f64) -> f64 {
    let wanted = cell * DEFAULT_ERROR_IN_CELLS;
    let power = 10.0_f64.powi(wanted.log10().floor() as i32);
    let nearest = [1.0, 2.0, 5.0, 10.0].into_iter().min_by(|a, b| {
        let off = |step: &f64| (step * power / wanted).ln().abs();
        off(a).total_cmp(&off(b))
    });
    nearest.unwrap_or(1.0) * power
}

fn lattice(cell: f64, max_error: f64) -> Lattice {
    let degrees = cell / METRES_IN_A_DEGREE;
    let zoom = (180.0 / (degrees * SAMPLES_ACROSS_A_LEAF))
        .log2()
        .round()
        .clamp(0.0, 24.0);
    let height_exponent = (max_error / STEPS_IN_AN_ERROR).log2().floor().clamp(-20.0, 20.0);
    Lattice {
        leaf_zoom: zoom as u8,
        height_exponent: height_exponent as i8,
    }
}
