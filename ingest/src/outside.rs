//! What is drawn around the data and in their holes: heights on a coarse grid, made from those at the edges of the data.
//!
//! ```text
//! tiles of a low zoom ─▶ vertices on the outline ─▶ means at nodes ─▶ spread, fading with the distance ─▶ field
//! ```

use std::collections::BTreeSet;

use glam::DVec3;
use terrain_codec::ellipsoid::Geodetic;
use terrain_codec::tile::Tile;
use terrain_core::mesh::boundary_edges;
use terrain_tiles::outside::HeightField;
use terrain_tiles::spread::Values;

use crate::distances::{distances, fading};
use crate::georeference::nearest_turn;

/// Nodes along the longer side of the data.
const NODES: f64 = 32.0;
/// Spreading by squares as wide as all nodes.
const LEVELS: u32 = 7;
/// Degrees from node to node of the sea level's height: the geoid is smooth.
const SEA_STEP: f64 = 2.5;

/// Longitudes, latitudes and heights of the vertices at which a tile's finest surface ends inside the tile.
pub(crate) fn outline_of(tile: &Tile) -> Vec<DVec3> {
    let mesh = tile.surface(tile.finest());
    let extent = (1_u64 << tile.extent_bits) as f64;
    let is_on_side = |a: DVec3, b: DVec3| {
        let on = |of: fn(DVec3) -> f64| of(a) == of(b) && (of(a) == 0.0 || of(a) == extent);
        on(|at| at.x) || on(|at| at.y)
    };
    let ends = boundary_edges(&mesh.triangles)
        .into_iter()
        .filter(|&(a, b)| !is_on_side(mesh.positions[a as usize], mesh.positions[b as usize]))
        .flat_map(|(a, b)| [a, b]);
    let numbers: BTreeSet<u32> = ends.collect();
    let place = |number: u32| {
        let Geodetic {
            longitude,
            latitude,
            height,
        } = tile.geodetic(mesh.positions[number as usize]);
        DVec3::new(longitude, latitude, height)
    };
    numbers.into_iter().map(place).collect()
}

/// Heights that go on from an outline and come down to 0 as far from it as the data are wide; `bounds` are those of the data.
pub(crate) fn extended(outline: &[DVec3], bounds: [f64; 4]) -> HeightField {
    let [west, south, east, north] = bounds;
    let longer = (east - west).max(north - south);
    let step = longer / NODES;
    let beside = [longer.min((360.0 - (east - west)) / 2.0), longer];
    let low = [west - beside[0], (south - beside[1]).max(-90.0)];
    let high = [east + beside[0], (north + beside[1]).min(90.0)];
    let [columns, rows] = [0, 1].map(|axis| ((high[axis] - low[axis]) / step).ceil().max(1.0) as usize + 1);
    let steps = [0, 1].map(|axis| (high[axis] - low[axis]) / [columns, rows][axis].saturating_sub(1) as f64);
    let mut sums = vec![(0.0, 0.0); columns * rows];
    for place in outline {
        // Longitudes of tiles are those of one turn, those of the data go on over the antimeridian.
        let at = nearest_turn(place.truncate(), f64::midpoint(west, east));
        let x = ((at.x - low[0]) / steps[0]).round();
        let y = ((at.y - low[1]) / steps[1]).round();
        let node = y.clamp(0.0, rows as f64 - 1.0) as usize * columns + x.clamp(0.0, columns as f64 - 1.0) as usize;
        sums[node] = (sums[node].0 + place.z, sums[node].1 + 1.0);
    }
    let means: Vec<f32> = sums.iter().map(|(sum, count)| (sum / count) as f32).collect();
    let marked: Vec<bool> = means.iter().map(|mean| !mean.is_nan()).collect();
    let spread = Values {
        first: [0, 0],
        columns,
        rows,
        values: means,
    }
    .spread(LEVELS);
    let narrower = f64::midpoint(south, north).to_radians().cos();
    let away = distances(&marked, columns, [steps[0] * narrower, steps[1]]);
    let reach = beside[0].min(beside[1]) * narrower;
    let decimetre = |(height, away): (f32, f32)| {
        if height.is_nan() {
            return 0;
        }
        (f64::from(height) * fading(f64::from(away) / reach) * 10.0).round() as i32
    };
    HeightField {
        bounds: [low[0], low[1], high[0], high[1]],
        columns,
        decimetres: spread.into_iter().zip(away).map(decimetre).collect(),
    }
}

/// The sea level's height over the whole Earth, of metres at longitudes and latitudes; none where the grid does not reach.
pub(crate) fn sea_level(undulation: impl Fn(f64, f64) -> Option<f64>) -> HeightField {
    let columns = (360.0 / SEA_STEP) as usize + 1;
    let rows = (180.0 / SEA_STEP) as usize + 1;
    let place = |index: usize| {
        let (column, row) = (index % columns, index / columns);
        (-180.0 + column as f64 * SEA_STEP, -90.0 + row as f64 * SEA_STEP)
    };
    let decimetre = |index: usize| {
        let (longitude, latitude) = place(index);
        undulation(longitude, latitude).map_or(0, |metres| (metres * 10.0).round() as i32)
    };
    HeightField {
        bounds: [-180.0, -90.0, 180.0, 90.0],
        columns,
        decimetres: (0..columns * rows).map(decimetre).collect(),
    }
}

#[cfg(test)]
#[path = "outside_tests.rs"]
mod tests;
