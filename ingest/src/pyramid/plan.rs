//! What is decided before the first tile is made, and the names that follow from it.

use std::collections::BTreeSet;

use glam::DVec2;
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::simplify::Quality;

use terrain_codec::ellipsoid::{MEAN_RADIUS, METRES_IN_A_DEGREE};
use terrain_tiles::metadata::OutsidePolicy;

use super::depths::Depths;
use crate::georeference::GeoReference;
use crate::lattice::{Demand, Lattice, Square};
use crate::samples::Raster;
use crate::store::Name;
use crate::tin::bound_name;

/// Counts up whenever the same inputs would give other tiles than before: what was made then is not taken for what is made now.
const ALGORITHM: u32 = 11;
/// Samples across a leaf tile, roughly, at the default error and at most: enough triangles that its sides do not weigh much.
const SAMPLES_ACROSS_A_LEAF: [f64; 2] = [128.0, 512.0];
/// Cells are taken to be no longer than this: beside a pole columns meet.
const MOST_LENGTHENED: f64 = 10.0;
/// The asked error where none is given, in cells: about the vertical accuracy of elevation products.
const DEFAULT_ERROR_IN_CELLS: f64 = 1.0 / 8.0;
/// Metres, where cells are not so long that the Earth bends away more.
const MOST_DEFAULT_ERROR: f64 = 200.0;
/// Times the sagitta of a cell that diagonals of cells in several tiles come to.
const SAGITTAS: f64 = 4.0;
/// No surface errs more than this, metres: triangles of larger sagitta span so much of the Earth that a plan cannot tell where they are.
const MOST_ERROR: f64 = 50_000.0;
/// Degrees by which rectangles are widened where it is asked which squares they meet.
const SLIGHTLY: f64 = 1e-9;

/// What to build.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Largest error of the leaves in metres; derived from the raster's cells where not given.
    pub max_error: Option<f64>,
    /// Where the error is to hold.
    pub bound: Bound,
    /// How much work goes into few triangles.
    pub quality: Quality,
    /// Leaves of a subtree that is finished as one piece, roughly.
    pub leaves_of_subtree: u32,
    /// Bytes of memory to stay below, roughly.
    pub memory: u64,
    /// What is to be where nothing was measured.
    pub outside: OutsidePolicy,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_error: None,
            bound: Bound::Surface,
            quality: Quality::Default,
            leaves_of_subtree: 256,
            memory: 1 << 30,
            outside: OutsidePolicy::Extend,
        }
    }
}

/// What the lattice must be fine enough for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Relief {
    /// Greatest difference between two neighbouring samples of a row or a column, metres.
    pub(crate) steepest_step: f64,
    /// Greatest height above or depth below 0, metres.
    pub(crate) farthest_height: f64,
}

/// What holds for all tiles of a build.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) lattice: Lattice,
    /// Largest error of the leaves, metres.
    pub(crate) max_error: f64,
    pub(crate) bound: Bound,
    pub(crate) quality: Quality,
    /// Where subtrees begin that are finished as one piece.
    pub(crate) subtree_zoom: u8,
    /// West, south, east, north of the samples, degrees.
    pub(crate) bounds: [f64; 4],
    /// Which squares have no children.
    pub(crate) depths: Depths,
    /// Of all of this but the depths: other parameters make other tiles.
    pub(crate) name: Name,
}

impl Plan {
    /// For a raster as it is seen, of which these are the samples.
    pub(crate) fn new(
        raster: &dyn Raster,
        georeference: &GeoReference,
        size: [usize; 2],
        relief: Relief,
        options: &Options,
    ) -> Self {
        let (cell, max_error) = cell_and_error(georeference, size, options);
        let lattice = lattice(cell, max_error, relief);
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
            subtree_zoom: subtree_zoom(lattice.leaf_zoom, options.leaves_of_subtree),
            depths: depths(raster, lattice.leaf_zoom, cell, max_error),
            bounds: georeference.geographic_bounds(),
            name: Name::of([parameters.as_bytes()]),
        }
    }

    /// The error of a zoom's finest surfaces, metres.
    pub(crate) fn error_at(&self, zoom: u8) -> f64 {
        (self.max_error * f64::from(self.lattice.leaf_zoom - zoom).exp2()).min(MOST_ERROR)
    }

    /// Whether the error of a leaf of such a zoom is what was asked for, but for the rounding of claims.
    pub(crate) fn keeps_the_error(&self, zoom: u8, error: f64) -> bool {
        error <= self.error_at(zoom) * (1.0 + 1e-6)
    }

    /// Zooms that a square is above the deepest leaves.
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

/// The squares in which subtrees may begin that are finished as one piece, of a raster as it is seen. No sample need be read for it.
pub(crate) fn subtrees(raster: &dyn Raster, options: &Options) -> Vec<Square> {
    let (cell, max_error) = cell_and_error(raster.georeference(), raster.size(), options);
    let leaf_zoom = leaf_zoom(cell, max_error);
    let zoom = subtree_zoom(leaf_zoom, options.leaves_of_subtree);
    let depths = depths(raster, leaf_zoom, cell, max_error);
    let squares = depths.bounds().flat_map(|bounds| squares_over(bounds, zoom));
    let reached = squares.filter(|&square| depths.is_reached(square));
    reached.collect::<BTreeSet<Square>>().into_iter().collect()
}

/// A raster of coarser cells than `cell` metres errs by no more than was asked, or by what suits its cells if that is more.
fn depths(raster: &dyn Raster, leaf_zoom: u8, cell: f64, max_error: f64) -> Depths {
    let doublings = |coarseness: f64| (default_error(cell * coarseness) / max_error).log2();
    Depths::new(raster, leaf_zoom, doublings)
}

/// All squares of a zoom that meet a rectangle of longitudes and latitudes; those that only touch it, too.
fn squares_over([west, south, east, north]: [f64; 4], zoom: u8) -> Vec<Square> {
    let squares = |from: f64, to: f64, first: f64| {
        let at = |degrees: f64| ((degrees - first) / 180.0 * f64::from(zoom).exp2()).floor() as i64;
        at(from - SLIGHTLY)..=at(to + SLIGHTLY)
    };
    let rows = squares(south, north, -90.0);
    let last_row = (1 << zoom) - 1;
    let rows = (*rows.start()).max(0)..=(*rows.end()).min(last_row);
    rows.flat_map(|y| squares(west, east, -180.0).map(move |x| Square { zoom, x, y }))
        .collect()
}

fn cell_and_error(georeference: &GeoReference, size: [usize; 2], options: &Options) -> (f64, f64) {
    let centre = DVec2::new(size[0] as f64 - 1.0, size[1] as f64 - 1.0) / 2.0;
    let sides = georeference.cell_metres(centre);
    let cell = sides.min_element().max(sides.max_element() / MOST_LENGTHENED);
    let max_error = options.max_error.unwrap_or_else(|| default_error(cell));
    (cell, max_error.min(MOST_ERROR))
}

fn subtree_zoom(leaf_zoom: u8, leaves: u32) -> u8 {
    leaf_zoom.saturating_sub((leaves.max(1).ilog2() / 2) as u8)
}

/// The error that suits cells of which the shorter side is so many metres long: an eighth of it, rounded to 1, 2 or 5 times a power of
/// ten; but mountains are no higher where cells are wider, as long as sides of cells, which are straight in space, keep to the Earth.
#[must_use]
pub(crate) fn default_error(cell: f64) -> f64 {
    let sagitta = cell * cell / (8.0 * MEAN_RADIUS);
    let most = MOST_DEFAULT_ERROR.max(SAGITTAS * sagitta);
    let wanted = (cell * DEFAULT_ERROR_IN_CELLS).min(most);
    let power = 10.0_f64.powi(wanted.log10().floor() as i32);
    let nearest = [1.0, 2.0, 5.0, 10.0].into_iter().min_by(|a, b| {
        let off = |step: &f64| (step * power / wanted).ln().abs();
        off(a).total_cmp(&off(b))
    });
    nearest.unwrap_or(1.0) * power
}

fn lattice(cell: f64, max_error: f64, relief: Relief) -> Lattice {
    let demand = Demand {
        cell: cell / METRES_IN_A_DEGREE,
        max_error,
        steepest_step: relief.steepest_step,
        farthest_height: relief.farthest_height,
    };
    Lattice::new(leaf_zoom(cell, max_error), demand)
}

fn leaf_zoom(cell: f64, max_error: f64) -> u8 {
    let degrees = cell / METRES_IN_A_DEGREE;
    let zoom = (180.0 / (degrees * samples_across_a_leaf(cell, max_error))).log2();
    zoom.round().clamp(0.0, 24.0) as u8
}

/// About as many as give a leaf the same number of triangles whatever the error.
fn samples_across_a_leaf(cell: f64, max_error: f64) -> f64 {
    let [least, most] = SAMPLES_ACROSS_A_LEAF;
    (least * (max_error / (cell * DEFAULT_ERROR_IN_CELLS)).sqrt()).clamp(least, most)
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
