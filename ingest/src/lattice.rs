//! The pyramid's own squares and places: columns counted on past the antimeridian, so that a raster that crosses it
//! lies in one piece; only the address of a finished tile wraps.

use glam::{DVec2, DVec3};
use terrain_tiles::address::{LEAF_EXTENT_BITS, Side, TileAddress};
use terrain_tiles::progressive::Sampling;

use crate::georeference::GeoReference;

/// Lattice units between a tile's side and the inner line of the strip along it. A collapse on the side then disturbs
/// nothing but the strip.
pub(crate) const STRIP: i64 = 4;

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

/// The global lattice of one archive: units of its leaf tiles' 2^15th part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lattice {
    pub(crate) leaf_zoom: u8,
    /// Heights are multiples of 2^this metres.
    pub(crate) height_exponent: i8,
}

impl Lattice {
    pub(crate) fn extent_bits(self, zoom: u8) -> u8 {
        LEAF_EXTENT_BITS + self.leaf_zoom - zoom
    }

    /// Units along a square's side.
    pub(crate) fn extent(self, zoom: u8) -> i64 {
        1 << self.extent_bits(zoom)
    }

    pub(crate) fn degrees_per_unit(self) -> f64 {
        180.0 / (1_u64 << (LEAF_EXTENT_BITS + self.leaf_zoom)) as f64
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

    /// Where the samples of a raster of that many rows lie in a square, if they do in columns and rows along the lattice's axes.
    pub(crate) fn sampling(self, georeference: &GeoReference, rows: usize, square: Square) -> Option<Sampling> {
        let last_row = rows.saturating_sub(1) as f64;
        let at = |column: f64, row: f64| {
            let geographic = georeference.geographic(DVec2::new(column, last_row - row));
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
