//! Raster tiles of heights, in Web Mercator, for MapLibre and its kin: from the surface that is drawn.
//!
//! ```text
//! pixel centres ─▶ heights of the surface of a zoom ─▶ voids filled ─▶ rounded once ─▶ numbers in colours ─▶ PNG, WebP
//! ```
//!
//! | | a colour (r, g, b) is, in metres |
//! | --- | --- |
//! | terrarium | 256 r + g + b / 256 − 32,768 |
//! | mapbox | (65,536 r + 256 g + b) / 10 − 10,000 |

mod beside;
mod fill;
pub mod image;
mod webp;

use std::io;
use std::ops::Deref;

use serde_json::{Value, json};
use terrain_codec::address::TileAddress;

use self::image::{Encoding, Format};
use crate::ground::{Ground, Place, answers};
use crate::mercator;
use crate::metadata::Metadata;
use crate::tile_file::SquareTile;

/// Pixels along a side; a tile of 512 covers the square of one of 256.
pub const SIZES: [u32; 2] = [256, 512];
/// Rounding takes no more than this part of the surface's error.
const PART_OF_ERROR: f64 = 0.25;
/// Metres: where errors are large, heights are rounded to no more than this.
const COARSEST_QUANTUM: f64 = 32.0;

/// What a raster tile looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RasterForm {
    /// Pixels along a side, one of [`SIZES`].
    pub size: u32,
    /// How colours stand for heights.
    pub encoding: Encoding,
    /// What file.
    pub format: Format,
}

impl RasterForm {
    /// The surface's zoom that rasters of a zoom are drawn from. A tile of 256 pixels of zoom z is two tiles of the surface's zoom z
    /// wide; one of 512 has the pixels of the next.
    #[must_use]
    pub fn surface_zoom(&self, metadata: &Metadata, zoom: u8) -> u8 {
        (zoom + self.zooms_finer()).min(metadata.max_zoom)
    }

    /// The last zoom that shows more than the one before.
    #[must_use]
    pub fn finest_zoom(&self, metadata: &Metadata) -> u8 {
        metadata.max_zoom.saturating_sub(self.zooms_finer())
    }

    fn zooms_finer(&self) -> u8 {
        u8::from(self.size == SIZES[1])
    }

    /// How far a pixel's height may be from the source at its middle, metres: the surface's certified error, and what is rounded.
    #[must_use]
    pub fn error(&self, metadata: &Metadata, zoom: u8) -> f64 {
        self.surface_error(metadata, zoom) + self.quantum(metadata, zoom) / 2.0
    }

    fn surface_error(&self, metadata: &Metadata, zoom: u8) -> f64 {
        metadata.finest_error(self.surface_zoom(metadata, zoom))
    }

    /// Metres to which heights of a zoom are rounded: a power of two times the encoding's own step.
    #[must_use]
    pub fn quantum(&self, metadata: &Metadata, zoom: u8) -> f64 {
        let most = (self.surface_error(metadata, zoom) * PART_OF_ERROR).min(COARSEST_QUANTUM);
        let mut quantum = self.encoding.step();
        while quantum * 2.0 <= most {
            quantum *= 2.0;
        }
        quantum
    }

    /// What clients are told of the rasters of zooms 0 to `finest` within `bounds`, as TileJSON has it, but for their address.
    #[must_use]
    pub fn description(&self, metadata: &Metadata, finest: u8, bounds: [f64; 4]) -> Value {
        let zoom = |zoom| {
            json!({
                "zoom": zoom,
                "error": self.surface_error(metadata, zoom),
                "quantum": self.quantum(metadata, zoom),
            })
        };
        json!({
            "encoding": self.encoding.name(),
            "tileSize": self.size,
            "minzoom": 0,
            "maxzoom": finest,
            "bounds": mercator::within(bounds),
            "attribution": metadata.source.attribution(),
            "heights_above": metadata.source.tiles_above(),
            "from": "surface",
            "zooms": (0..=finest).map(zoom).collect::<Vec<_>>(),
        })
    }

    /// The file of a tile of the archive that `metadata` describe, from the surfaces that `ground_at` gives. Voids among the data are filled from
    /// around them; beside the data is what the archive has outside, without a step where that goes on from their edge.
    ///
    /// # Errors
    /// What `ground_at` says, or the encoder.
    pub fn draw<G: Deref<Target = Ground> + Clone, E: From<io::Error>>(
        &self,
        metadata: &Metadata,
        tile: SquareTile,
        ground_at: impl FnMut(TileAddress) -> Result<Option<G>, E>,
    ) -> Result<Vec<u8>, E> {
        let places = mercator::pixel_centres(tile, self.size);
        let zoom = self.surface_zoom(metadata, tile.zoom);
        let outside = |place: Place| metadata.outside.height(place.longitude, place.latitude);
        let pixel = mercator::degrees(tile.zoom) / f64::from(self.size);
        let nearest = places.iter().map(|&place| beside::nearest(metadata, place, pixel));
        let (near, grounds): (Vec<usize>, Vec<beside::Nearest>) =
            (0..).zip(nearest).filter(|(_, ground)| ground.share > 0.0).unzip();
        let asked: Vec<Place> = grounds.iter().map(|ground| ground.place).collect();
        let found = answers(zoom, &asked, ground_at, |ground, at| {
            ground.height(at.longitude, at.latitude)
        })?;
        let mut heights: Vec<Option<f64>> = places.iter().map(|&place| Some(outside(place))).collect();
        for ((index, ground), height) in near.into_iter().zip(grounds).zip(found) {
            // Within the bounds that is the height itself, to the bit.
            let rest = outside(places[index]) - outside(ground.place) * ground.share;
            heights[index] = height.map(|height| height * ground.share + rest);
        }
        fill::fill_voids(&mut heights, self.size as usize);
        let quantum = self.quantum(metadata, tile.zoom);
        let colours: Vec<u8> = heights
            .iter()
            .zip(&places)
            .flat_map(|(metres, &place)| self.encoding.colour(metres.unwrap_or_else(|| outside(place)), quantum))
            .collect();
        Ok(image::write(
            self.format,
            image::Pixels::Colour,
            &colours,
            [self.size; 2],
        )?)
    }
}

#[cfg(test)]
#[path = "raster_dem_tests.rs"]
mod tests;
