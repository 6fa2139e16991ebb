//! A tile of the pyramid: a Surface Partition on the global lattice, whose last four levels are its sides.
//!
//! ```text
//! levels   0 … n−5   interior, coarsest first; all four sides as coarse as the parent tile's
//!          n−4 … n−1 the sides west, south, east, north: their own zoom's vertices come in
//! ```
//! The side levels refine disjoint sets of triangles, so on the finest interior any of them may be left out.

use glam::DVec3;
use terrain_core::{Mesh, SurfacePartition};

use crate::address::{Side, TileAddress};
use crate::ellipsoid::{self, Geodetic};
use crate::filled::Filled;
use crate::progressive::Sampling;

/// Lattice units between a tile's side and the inner line of the strip along it, where there are no vertices. A collapse on the side then
/// disturbs nothing but the strip.
pub const STRIP: i64 = 4;

/// One tile of the pyramid.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Which square of the Earth.
    pub address: TileAddress,
    /// The tile's side is 2^`extent_bits` lattice units.
    pub extent_bits: u8,
    /// Heights are integer multiples of 2^`height_exponent` metres.
    pub height_exponent: i8,
    /// Where the source's samples lie on the lattice, if they are in straight columns and rows along its axes: vertices like to
    /// be samples, and are then told in fewer bytes.
    pub sampling: Option<Sampling>,
    /// What the tile was made from, and what its parent takes over.
    pub lineage: Lineage,
    /// Positions: x, y in lattice units from the tile's south-west corner (integers), z in metres above the
    /// ellipsoid (or whatever the source's vertical datum is). The last four levels are the sides, in the order of
    /// [`Side::ALL`].
    pub partition: SurfacePartition,
    /// For each level, how far in metres its outline may be from the outline of the source, and breaklines from its edges, in plan view.
    pub outline_errors: Vec<f64>,
    /// Edges of the coarsest surface that are along breaklines, by places of their ends on the lattice: its parent keeps them.
    pub breaklines: Vec<[[i64; 2]; 2]>,
    /// Where its ground was not measured.
    pub filled: Filled,
}

/// What a tile was made from, and what its parent takes over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lineage {
    /// A hash of everything that the tile was made from: two tiles of one name are the same. 0 where nobody knows.
    pub name: u128,
    /// What was measured of the coarsest surface, which is the parent's finest, in metres; no more than is claimed.
    pub coarsest_measured: f32,
    /// How far in metres collapses may have moved the outline of the coarsest surface, without the bulge of straight edges in space.
    pub outline_strayed: f32,
}

/// Which level of detail of a tile to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail {
    /// Index of the interior level, 0 the coarsest.
    pub interior: usize,
    /// Which sides, in the order of [`Side::ALL`], show their own zoom's vertices; only on the finest interior.
    pub fine_sides: [bool; 4],
}

impl Tile {
    /// How many interior levels there are.
    #[must_use]
    pub fn interior_levels(&self) -> usize {
        self.partition.levels.len() - Side::ALL.len()
    }

    /// Certified vertical error of the finest surface, metres; infinity of a tile without levels.
    #[must_use]
    pub fn finest_error(&self) -> f64 {
        self.partition.levels.last().map_or(f64::INFINITY, |level| level.error)
    }

    /// The finest surface: finest interior, every side fine.
    #[must_use]
    pub fn finest(&self) -> Detail {
        Detail {
            interior: self.interior_levels() - 1,
            fine_sides: [true; 4],
        }
    }

    /// Certified vertical error of the surface at `detail`, metres, or that of the finest interior where only some sides are fine.
    #[must_use]
    pub fn error(&self, detail: Detail) -> f64 {
        if detail == self.finest() {
            return self.finest_error();
        }
        self.partition
            .levels
            .get(detail.interior)
            .map_or(f64::INFINITY, |level| level.error)
    }

    /// The coarsest surface, which is the parent's finest over this tile's square.
    #[must_use]
    pub fn coarsest(&self) -> Detail {
        Detail {
            interior: 0,
            fine_sides: [false; 4],
        }
    }

    /// The surface at `detail` in lattice coordinates. Fine sides are shown on the finest interior only; on a coarser
    /// one they are ignored, since their vertices split triangles that are not there.
    #[must_use]
    pub fn surface(&self, detail: Detail) -> Mesh {
        let interior = self.interior_levels();
        self.partition.lod_of(|level| {
            level <= detail.interior
                || (level >= interior && detail.interior + 1 == interior && detail.fine_sides[level - interior])
        })
    }

    /// Longitude, latitude and height of a lattice position of this tile.
    #[must_use]
    pub fn geodetic(&self, position: DVec3) -> Geodetic {
        let degrees_per_unit = self.address.degrees() / (1_u64 << self.extent_bits) as f64;
        Geodetic {
            longitude: self.address.west() + position.x * degrees_per_unit,
            latitude: self.address.south() + position.y * degrees_per_unit,
            height: position.z,
        }
    }

    /// Earth-centred metres of a lattice position of this tile.
    #[must_use]
    pub fn earth_centred(&self, position: DVec3) -> DVec3 {
        ellipsoid::to_earth_centred(self.geodetic(position))
    }
}
