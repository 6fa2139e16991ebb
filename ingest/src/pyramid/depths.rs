//! How deep the pyramid is, and where: leaves are as small as the rasters there are fine.
//!
//! ```text
//! a square has children where a raster that is worth its zoom's next one is in it, or within a side's length of it
//! ```
//! So squares that share a side and have no children are of zooms that differ by one at most: if a child of a neighbour has
//! children, its raster is within half a side of that child, and so within a side of the square.

use std::ops::Range;

use crate::lattice::Square;
use crate::samples::Raster;

/// Share of a zoom by which cells may be shorter than twice others, and yet be worth one zoom less.
const SLIGHTLY: f64 = 1e-6;
/// Degrees of longitude from a place to the same one.
const TURNS: [f64; 3] = [0.0, 360.0, -360.0];

/// The deepest zoom of each raster.
#[derive(Clone, Debug)]
pub(crate) struct Depths {
    /// Of the finest.
    leaf_zoom: u8,
    rasters: Vec<Depth>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Depth {
    leaf_zoom: u8,
    /// West, south, east, north in degrees.
    bounds: [f64; 4],
}

impl Depths {
    /// Of rasters on one lattice, the finest of which have leaves at `leaf_zoom`. `zooms_up` tells by how many zooms leaves may end
    /// sooner where cells are so many times longer than the finest, and still be exact enough.
    pub(crate) fn new(raster: &dyn Raster, leaf_zoom: u8, zooms_up: impl Fn(f64) -> f64) -> Self {
        let georeference = raster.georeference();
        let depth = |([columns, rows], coarseness): ([Range<usize>; 2], f64)| {
            let first = [columns.start as i64, rows.start as i64];
            let zooms_up = (coarseness.log2().min(zooms_up(coarseness)) + SLIGHTLY).max(0.0) as u8;
            Depth {
                leaf_zoom: leaf_zoom.saturating_sub(zooms_up),
                bounds: georeference
                    .window(first, columns.len(), rows.len())
                    .geographic_bounds(),
            }
        };
        let rasters = raster.extents().into_iter().zip(raster.coarseness());
        // An underlay may be beside what it is to be around.
        let there = rasters.filter(|(extent, _)| extent.iter().all(|range| !range.is_empty()));
        Self {
            leaf_zoom,
            rasters: there.map(depth).collect(),
        }
    }

    /// Whether a square has no children.
    pub(crate) fn is_leaf(&self, square: Square) -> bool {
        square.zoom >= self.leaf_zoom || self.deeper_near(square).next().is_none()
    }

    /// Whether all squares above one have children.
    pub(crate) fn is_reached(&self, square: Square) -> bool {
        std::iter::successors(square.parent(), |above| above.parent()).all(|above| !self.is_leaf(above))
    }

    /// West, south, east, north of each raster, degrees.
    pub(crate) fn bounds(&self) -> impl Iterator<Item = [f64; 4]> {
        self.rasters.iter().map(|raster| raster.bounds)
    }

    /// All that the squares with children in and below one depend on.
    pub(crate) fn fingerprint(&self, square: Square) -> String {
        format!("{:?}", self.deeper_near(square).collect::<Vec<_>>())
    }

    /// The rasters that go deeper than a square and are in it or within a side's length of it.
    fn deeper_near(&self, square: Square) -> impl Iterator<Item = &Depth> {
        let side = 180.0 / f64::from(square.zoom).exp2();
        let [west, south] = [square.x as f64 * side - 180.0, square.y as f64 * side - 90.0];
        let is_near = move |[left, low, right, high]: [f64; 4]| {
            let beside = |turn: f64| left + turn <= west + 2.0 * side && right + turn >= west - side;
            low <= south + 2.0 * side && high >= south - side && TURNS.into_iter().any(beside)
        };
        let deeper = self.rasters.iter().filter(move |raster| raster.leaf_zoom > square.zoom);
        deeper.filter(move |raster| is_near(raster.bounds))
    }
}

#[cfg(test)]
#[path = "depths_tests.rs"]
mod tests;
