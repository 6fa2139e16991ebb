//! Lines of every kind over a random raster: across it and each other, beside it, along its grid and along tiles' sides, through voids,
//! closed, touching themselves, without length, in a thousand tiny parts, around more than half of the Earth.

use std::f64::consts::TAU;

use fastrand::Rng;
use glam::DVec2;
use serde_json::{Value, json};

use crate::random_raster::RandomRaster;

/// Kinds of lines.
const KINDS: usize = 8;

/// Lines over a raster, as GeoJSON in its reference system.
#[must_use]
pub fn random_lines(raster: &RandomRaster, seed: u64) -> Value {
    let mut random = Rng::with_seed(seed);
    let count = random.usize(1..=6);
    let mut lines: Vec<Vec<DVec2>> = (0..count).map(|_| line(raster, &mut random)).collect();
    if random.u8(0..4) == 0 {
        lines.push(lines[0].clone());
    }
    let features: Vec<Value> = lines
        .iter()
        .map(|line| {
            let coordinates: Vec<[f64; 2]> = line.iter().map(DVec2::to_array).collect();
            let is_ring = line.len() > 3 && line.first() == line.last();
            let geometry = if is_ring && random.bool() {
                json!({"type": "Polygon", "coordinates": [coordinates]})
            } else {
                json!({"type": "LineString", "coordinates": coordinates})
            };
            json!({"type": "Feature", "properties": {}, "geometry": geometry})
        })
        .collect();
    let name = format!("urn:ogc:def:crs:EPSG::{}", raster.epsg());
    let mut file = json!({"type": "FeatureCollection", "features": features});
    if raster.epsg() != 4326 {
        file["crs"] = json!({"type": "name", "properties": {"name": name}});
    }
    file
}

/// A line in coordinates of the raster's reference system.
fn line(raster: &RandomRaster, random: &mut Rng) -> Vec<DVec2> {
    let size = DVec2::new(raster.columns as f64, raster.rows as f64) - 1.0;
    let anywhere = |random: &mut Rng| (DVec2::new(random.f64(), random.f64()) * 1.4 - 0.2) * size;
    let on_grid = match random.usize(0..KINDS) {
        0 => (0..random.usize(2..=5)).map(|_| anywhere(random)).collect(),
        1 => along_grid(anywhere(random).round(), size, random.bool()),
        2 => ring(
            anywhere(random),
            size.min_element() * 0.3 * random.f64(),
            random.usize(4..=9),
        ),
        3 => ring(anywhere(random), size.min_element() * 0.4 * random.f64(), 1000),
        4 => {
            let (corner, [a, b, c, d]) = (anywhere(random), [(); 4].map(|()| anywhere(random)));
            vec![corner, a, b, corner, c, d, corner]
        }
        5 => vec![anywhere(random); 2],
        6 => {
            let (at, way) = (anywhere(random), anywhere(random) * 1e-4);
            (0..50).map(|step| at + way * f64::from(step)).collect()
        }
        _ => return along_a_tile(raster, size, random),
    };
    on_grid.into_iter().map(|at| raster.place(at)).collect()
}

/// From one end of the grid to the other, through samples.
fn along_grid(at: DVec2, size: DVec2, is_column: bool) -> Vec<DVec2> {
    if is_column {
        vec![DVec2::new(at.x, -1.0), DVec2::new(at.x, size.y + 1.0)]
    } else {
        vec![DVec2::new(-1.0, at.y), DVec2::new(size.x + 1.0, at.y)]
    }
}

fn ring(middle: DVec2, radius: f64, count: usize) -> Vec<DVec2> {
    let corner = |step: usize| middle + radius * DVec2::from_angle(TAU * step as f64 / count as f64);
    let first = corner(0);
    (0..count).map(corner).chain([first]).collect()
}

/// Through the raster's middle; of one in degrees, along a side of a tile there.
fn along_a_tile(raster: &RandomRaster, size: DVec2, random: &mut Rng) -> Vec<DVec2> {
    let ends = [DVec2::new(-1.0, size.y / 2.0), DVec2::new(size.x + 1.0, size.y / 2.0)].map(|at| raster.place(at));
    if raster.epsg() != 4326 {
        return ends.to_vec();
    }
    let tile = 180.0 / f64::from(1 << random.u8(2..12));
    let y = (ends[0].y / tile).round() * tile;
    ends.map(|end| DVec2::new(end.x, y)).to_vec()
}
