//! What bounds a tile whose surface is not looked at: its square, and a range of heights.

use glam::{DVec2, DVec3};
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{Geodetic, LEAST_CURVATURE_RADIUS, to_earth_centred};

use crate::formats::quantized_mesh::bounds;

/// Cells along a tile's side in whose corners its square is looked at.
const CELLS: u32 = 16;

/// A square of the Earth between two heights, in metres above the ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Region {
    pub(super) address: TileAddress,
    pub(super) heights: [f64; 2],
}

impl Region {
    /// West, south, east, north in radians, least and greatest height: the `region` of 3D Tiles, with room for edges that are straight
    /// in space. Such an edge over d radians leaves a parallel by d²/4 at most, times the tangent of the latitude where that is more
    /// than 45°, and by no more than d anywhere; it never leaves its meridians.
    pub(super) fn radians(&self) -> [f64; 6] {
        let Self { address, heights } = *self;
        let side = address.degrees().to_radians();
        let [west, south] = [address.west(), address.south()].map(f64::to_radians);
        let diagonal = side * 2.0_f64.sqrt();
        let steepest = south.abs().max((south + side).abs()).tan().abs();
        let margin = (diagonal * diagonal / 4.0 * (1.0 + steepest)).min(diagonal);
        let quarter = std::f64::consts::FRAC_PI_2;
        let [south, north] = [south - margin, south + side + margin].map(|latitude| latitude.clamp(-quarter, quarter));
        [west, south, west + side, north, heights[0], heights[1]]
    }

    /// How far a triangle over the square may dip below its corners: its circumscribed circle's radius is at most the diagonal / √3.
    pub(super) fn dip(address: TileAddress) -> f64 {
        let diagonal = address.degrees().to_radians() * 2.0_f64.sqrt() * LEAST_CURVATURE_RADIUS;
        diagonal * diagonal / (6.0 * LEAST_CURVATURE_RADIUS)
    }

    /// Centre and radius, in Earth-centred metres, of a sphere around all of it.
    pub(super) fn sphere(&self) -> (DVec3, f64) {
        let [low, high] = self.heights.map(|height| self.points(height));
        let (center, radius) = bounds::sphere(&[low, high].concat());
        let cell = self.address.degrees().to_radians() / f64::from(CELLS) * 2.0_f64.sqrt();
        // Between the points it bulges by half a cell's diagonal, squared, over two radii.
        let scale = terrain_codec::ellipsoid::SEMI_MAJOR + self.heights[1].max(0.0);
        (center, radius + cell * cell / 8.0 * scale)
    }

    /// The point behind the horizon exactly if all of it is, on the ray through `center`.
    pub(super) fn horizon_occlusion_point(&self, center: DVec3) -> DVec3 {
        bounds::horizon_occlusion_point(center, &self.points(self.heights[1]))
    }

    /// Corners of cells at a height.
    fn points(&self, height: f64) -> Vec<DVec3> {
        let corner = DVec2::new(self.address.west(), self.address.south());
        let cell = self.address.degrees() / f64::from(CELLS);
        let grid =
            (0..=CELLS).flat_map(|row| (0..=CELLS).map(move |column| DVec2::new(f64::from(column), f64::from(row))));
        let at = |place: DVec2| {
            to_earth_centred(Geodetic {
                longitude: place.x,
                latitude: place.y,
                height,
            })
        };
        grid.map(|place| at(corner + place * cell)).collect()
    }
}
