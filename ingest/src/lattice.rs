//! The pyramid's own squares and places: columns counted on past the antimeridian, so that a raster that crosses it
//! lies in one piece; only the address of a finished tile wraps.

use glam::{DVec2, DVec3};
use terrain_codec::address::{Side, TileAddress};
use terrain_codec::progressive::Sampling;
pub(crate) use terrain_codec::tile::STRIP;

use crate::georeference::GeoReference;

/// Lattice units along a side of a leaf tile, as a power of two, where that is fine enough, and at most: beyond, the exact
/// tests of the triangulation would leave their integers.
const LEAF_BITS: [f64; 2] = [15.0, 28.0];
/// Lattice units along a side of a root tile, as a power of two, at most: what the tile format takes.
const MOST_ROOT_BITS: f64 = 40.0;
/// Asked errors by which the rounding of a vertex in plan may change its height, at most.
const ROUNDING_SHARE: f64 = 0.25;
/// Height steps in the asked error, at least, as a power of two.
const STEPS_IN_AN_ERROR: f64 = 6.0;
/// Height steps of the highest height, as a power of two, at most: one less than what the tile format takes.
const MOST_STEPS: f64 = 30.0;

/// What a lattice must be fine enough for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    /// Shorter side of a cell, in degrees of latitude.
    pub(crate) cell: f64,
    /// Largest error of a leaf, metres.
    pub(crate) max_error: f64,
    /// Greatest difference between two neighbouring samples, metres.
    pub(crate) steepest_step: f64,
    /// Greatest height above or depth below 0, metres.
    pub(crate) farthest_height: f64,
}

/// A square of the pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Square {
    pub(crate) zoom: u8,
    /// Column from longitude −180 on, not wrapped.
    pub(crate) x: i64,
    pub(crate) y: i64,
}

impl Square {
    pub(crate) fn children(self) -> [Self; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| Self {
            zoom: self.zoom + 1,
            x: 2 * self.x + x,
            y: 2 * self.y + y,
        })
    }

    pub(crate) fn parent(self) -> Option<Self> {
        let zoom = self.zoom.checked_sub(1)?;
        let [x, y] = [self.x, self.y].map(|index| index.div_euclid(2));
        Some(Self { zoom, x, y })
    }

    pub(crate) fn address(self) -> TileAddress {
        TileAddress {
            zoom: self.zoom,
            x: self.x.rem_euclid(2 << self.zoom) as u32,
            y: self.y as u32,
        }
    }

    pub(crate) fn edge(self, side: Side) -> Edge {
        let Self { zoom, x, y } = self;
        match side {
            Side::West => Edge {
                zoom,
                is_meridian: true,
                line: x,
                along: y,
            },
            Side::East => Edge {
                zoom,
                is_meridian: true,
                line: x + 1,
                along: y,
            },
            Side::South => Edge {
                zoom,
                is_meridian: false,
                line: y,
                along: x,
            },
            Side::North => Edge {
                zoom,
                is_meridian: false,
                line: y + 1,
                along: x,
            },
        }
    }
}

/// One side of a square, the same whichever of its two squares asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Edge {
    pub(crate) zoom: u8,
    /// Runs south to north; otherwise west to east.
    pub(crate) is_meridian: bool,
    /// Number of the meridian or parallel at this zoom.
    pub(crate) line: i64,
    /// Number of the stretch along it.
    pub(crate) along: i64,
}

impl Edge {
    /// The same meridian in −180 … 180, not 180 itself.
    pub(crate) fn wrapped(self) -> Self {
        let line = if self.is_meridian {
            self.line.rem_euclid(2 << self.zoom)
        } else {
            self.line
        };
        Self { line, ..self }
    }

    /// Both ends, south or west first, in squares of its zoom.
    pub(crate) fn ends(self) -> [[i64; 2]; 2] {
        [0, 1].map(|end| {
            let along = self.along + end;
            if self.is_meridian {
                [self.line, along]
            } else {
                [along, self.line]
            }
        })
    }

    /// The two halves, a zoom down.
    pub(crate) fn halves(self) -> [Self; 2] {
        [0, 1].map(|half| Self {
            zoom: self.zoom + 1,
            line: self.line * 2,
            along: self.along * 2 + half,
            ..self
        })
    }
}

/// The global lattice of one archive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lattice {
    pub(crate) leaf_zoom: u8,
    /// The side of a leaf tile is 2^this units.
    pub(crate) leaf_bits: u8,
    /// Heights are multiples of 2^this metres.
    pub(crate) height_exponent: i8,
}

impl Lattice {
    /// The coarsest lattice on which rounding leaves most of the error to the triangles, as far as the formats reach.
    pub(crate) fn new(leaf_zoom: u8, demand: Demand) -> Self {
        // Half a unit along a column and along a row, each across the steepest step.
        let units_in_a_cell = demand.steepest_step / (ROUNDING_SHARE * demand.max_error);
        let cells = 180.0 / f64::from(leaf_zoom).exp2() / demand.cell;
        let most = LEAF_BITS[1].min(MOST_ROOT_BITS - f64::from(leaf_zoom));
        let leaf_bits = (cells * units_in_a_cell).log2().ceil().clamp(LEAF_BITS[0], most);
        let for_the_error = demand.max_error.log2().floor() - STEPS_IN_AN_ERROR;
        let for_the_format = demand.farthest_height.max(1.0).log2().ceil() - MOST_STEPS;
        Self {
            leaf_zoom,
            leaf_bits: leaf_bits as u8,
            height_exponent: for_the_error.clamp(-20.0, 20.0).max(for_the_format) as i8,
        }
    }

    pub(crate) fn extent_bits(self, zoom: u8) -> u8 {
        self.leaf_bits + self.leaf_zoom - zoom
    }

    /// Units along a square's side.
    pub(crate) fn extent(self, zoom: u8) -> i64 {
        1 << self.extent_bits(zoom)
    }

    pub(crate) fn degrees_per_unit(self) -> f64 {
        180.0 / (1_u64 << (self.leaf_bits + self.leaf_zoom)) as f64
    }

    pub(crate) fn height_step(self) -> f64 {
        f64::from(self.height_exponent).exp2()
    }

    /// Longitude (not wrapped) and latitude of a global lattice position.
    pub(crate) fn geographic(self, global: DVec2) -> DVec2 {
        global * self.degrees_per_unit() - DVec2::new(180.0, 90.0)
    }

    /// Global lattice position, not rounded.
    pub(crate) fn global(self, geographic: DVec2) -> DVec2 {
        (geographic + DVec2::new(180.0, 90.0)) / self.degrees_per_unit()
    }

    /// Global lattice position of a square's south-west corner.
    pub(crate) fn origin(self, square: Square) -> DVec2 {
        DVec2::new(square.x as f64, square.y as f64) * self.extent(square.zoom) as f64
    }

    /// Longitude (not wrapped) and latitude of a square's middle.
    pub(crate) fn middle(self, square: Square) -> DVec2 {
        self.geographic(self.origin(square) + self.extent(square.zoom) as f64 / 2.0)
    }

    /// Where the samples of a raster lie in a square, if they do in columns and rows along the lattice's axes: the place is that
    /// of the sample, or where one would be, next to the square's south-west corner.
    pub(crate) fn sampling(self, georeference: &GeoReference, square: Square) -> Option<Sampling> {
        let nearest = georeference.grid(self.geographic(self.origin(square))).round();
        let at = |columns: f64, rows_up: f64| {
            let geographic = georeference.geographic(nearest + DVec2::new(columns, -rows_up));
            self.global(geographic) - self.origin(square)
        };
        let [corner, beside, above] = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
        let is_along_axes = georeference.is_geographic() && beside.y == corner.y && above.x == corner.x;
        let step = [beside.x - corner.x, above.y - corner.y];
        (is_along_axes && step.into_iter().all(|step| step > 0.0)).then(|| Sampling {
            origin: corner.to_array(),
            step,
        })
    }

    /// Moves positions of a child into its parent's frame.
    pub(crate) fn in_parent(self, child: Square, position: DVec3) -> DVec3 {
        let offset = DVec2::new(child.x.rem_euclid(2) as f64, (child.y % 2) as f64) * self.extent(child.zoom) as f64;
        position + offset.extend(0.0)
    }
}

#[cfg(test)]
#[path = "lattice_tests.rs"]
mod tests;
