//! Heights as a raster of longitudes and latitudes in a GeoPackage.
//!
//! ```text
//! pixels about as large as the source's cells ─▶ tile by tile, heights of the surface at their middles ─▶ GeoPackage, by GDAL
//! ```

use std::path::Path;

use glam::DVec2;
use rayon::prelude::*;
use terrain_codec::ellipsoid::METRES_IN_A_DEGREE;
use terrain_tiles::archive::Reader;
use terrain_tiles::ground::Place;
use terrain_tiles::metadata::Metadata;

use super::choice::Choice;
use super::unusable::Unusable;
use crate::archive_tiles::Grounds;
use crate::raster::geopackage::{Coverage, GeoPackage, TILE, tile_pixels};

/// Columns or rows, at most: as many as GDAL counts.
const MOST_PIXELS: f64 = i32::MAX as f64;
/// Shares of a pixel that are rounding.
const NEARLY: f64 = 1e-6;

/// Writes the raster of all that `choice` means as `output`. Gives how many tiles have ground.
pub(super) fn write(archive: &Reader, choice: &Choice, spacing: Option<f64>, output: &Path) -> anyhow::Result<usize> {
    let metadata = archive.metadata();
    let zoom = choice.finest_zoom(metadata.max_zoom, |zoom| metadata.finest_error(zoom))?;
    let pixels = Pixels::new(
        metadata,
        choice.bounds(metadata.bounds)?,
        pixel(metadata, zoom, spacing),
    )?;
    let error = metadata.finest_error(zoom);
    let above = metadata.source.tiles_above();
    let file = GeoPackage::create(
        output,
        &Coverage {
            corner: pixels.corner,
            pixel: pixels.pixel,
            size: pixels.size,
            name: "heights",
            description: &format!(
                "metres above {above}; at the middle of a pixel within {error} m of {}",
                metadata.source.files.join(", ")
            ),
        },
    )?;
    let grounds = Grounds::of(archive);
    let [columns, rows] = pixels.size.map(|pixels| pixels.div_ceil(TILE));
    let mut with_ground = 0;
    for row in 0..rows {
        let tiles = (0..columns).into_par_iter().map(|column| {
            let extent = tile_pixels(pixels.size, [column, row]);
            if choice.meets(pixels.bounds(extent)) {
                heights(&grounds, zoom, &pixels.middles(extent))
            } else {
                Ok(None)
            }
        });
        let tiles: Vec<_> = tiles.collect::<anyhow::Result<_>>()?;
        for (column, metres) in tiles.into_iter().enumerate() {
            if let Some(metres) = metres {
                file.write(output, [column, row], metres)?;
                with_ground += 1;
            }
        }
    }
    if with_ground == 0 {
        return Err(Unusable("there is no ground in that box".to_owned()).into());
    }
    file.finish(output)?;
    Ok(with_ground)
}

/// Metres at places, NaN where there is no ground; none if nowhere is any.
fn heights(grounds: &Grounds<&Reader>, zoom: u8, places: &[Place]) -> anyhow::Result<Option<Vec<f32>>> {
    let found = grounds.heights(zoom, places)?;
    let is_there = found.iter().any(Option::is_some);
    let metres = found
        .into_iter()
        .map(|height| height.map_or(f32::NAN, |height| height as f32));
    Ok(is_there.then(|| metres.collect()))
}

/// Degrees of a pixel: as asked for, or as the source's samples are apart, twice that for each zoom above the leaves.
fn pixel(metadata: &Metadata, zoom: u8, spacing: Option<f64>) -> DVec2 {
    let [west, south, east, north] = metadata.bounds;
    if let Some(metres) = spacing {
        let up = metres / METRES_IN_A_DEGREE;
        return DVec2::new(up / south.midpoint(north).to_radians().cos().max(0.01), up);
    }
    let [columns, rows] = metadata.source.samples.map(|count| count.max(2) as f64 - 1.0);
    let zooms_above = i32::from(metadata.max_zoom.saturating_sub(zoom));
    DVec2::new((east - west) / columns, (north - south) / rows) * 2_f64.powi(zooms_above)
}

/// Which pixels there are: their middles are counted from the archive's north-west corner, whatever part of it is asked for.
struct Pixels {
    /// North-west.
    corner: DVec2,
    pixel: DVec2,
    size: [usize; 2],
}

impl Pixels {
    fn new(metadata: &Metadata, [west, south, east, north]: [f64; 4], pixel: DVec2) -> Result<Self, Unusable> {
        let first = DVec2::new(metadata.bounds[0], metadata.bounds[3]);
        let index = |place: DVec2| (place - first) / DVec2::new(pixel.x, -pixel.y);
        let low = (index(DVec2::new(west, north)) - NEARLY).ceil();
        let high = (index(DVec2::new(east, south)) + NEARLY).floor();
        let size = high - low + 1.0;
        if size.min_element() < 1.0 || size.max_element() > MOST_PIXELS {
            return Err(Unusable(format!(
                "there is no raster of {} × {} pixels",
                size.x, size.y
            )));
        }
        Ok(Self {
            corner: first + (low - 0.5) * DVec2::new(pixel.x, -pixel.y),
            pixel,
            size: size.to_array().map(|pixels| pixels as usize),
        })
    }

    /// Of a rectangle of pixels: the first along each axis, and how many.
    fn middles(&self, [[left, columns], [top, rows]]: [[usize; 2]; 2]) -> Vec<Place> {
        let all = (top..top + rows).flat_map(|row| (left..left + columns).map(move |column| (column, row)));
        let place = |(column, row): (usize, usize)| {
            let at = self.at(DVec2::new(column as f64 + 0.5, row as f64 + 0.5));
            Place::turned(at.x, at.y.clamp(-90.0, 90.0))
        };
        all.map(place).collect()
    }

    /// West, south, east, north.
    fn bounds(&self, [[left, columns], [top, rows]]: [[usize; 2]; 2]) -> [f64; 4] {
        let low = self.at(DVec2::new(left as f64, (top + rows) as f64));
        let high = self.at(DVec2::new((left + columns) as f64, top as f64));
        [low.x, low.y, high.x, high.y]
    }

    /// Pixels from the corner to degrees.
    fn at(&self, pixels: DVec2) -> DVec2 {
        self.corner + pixels * DVec2::new(self.pixel.x, -self.pixel.y)
    }
}
