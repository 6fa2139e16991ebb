//! Which raster tile, and from which zoom's surface it is drawn.

use super::image::{Encoding, Format};
use crate::failure::Failure;
use crate::form::whole_number;
use crate::tileset::Tileset;

/// Pixels along a side; a tile of 512 covers the square of one of 256.
pub(super) const SIZES: [u32; 2] = [256, 512];
/// Degrees north and south to which Web Mercator's square reaches.
pub(super) const LATITUDES: f64 = 85.051_128_779_806_6;
/// Columns and rows of finer zooms do not fit their numbers.
const FINEST: u8 = 26;

/// A tile of Web Mercator, rows from the north.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MercatorTile {
    pub(crate) zoom: u8,
    pub(crate) x: u32,
    pub(crate) y: u32,
}

/// Which raster, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RasterRequest {
    pub(crate) tile: MercatorTile,
    pub(crate) size: u32,
    pub(crate) encoding: Encoding,
    pub(crate) format: Format,
}

impl MercatorTile {
    /// Degrees, at a part of the tile's width from its west side.
    pub(super) fn longitude(self, part: f64) -> f64 {
        (f64::from(self.x) + part) / f64::from(1_u32 << self.zoom) * 360.0 - 180.0
    }

    /// Degrees, at a part of its height from its north side (the sphere's Mercator, EPSG:3857).
    pub(super) fn latitude(self, part: f64) -> f64 {
        let y = (f64::from(self.y) + part) / f64::from(1_u32 << self.zoom);
        ((1.0 - 2.0 * y) * std::f64::consts::PI).sinh().atan().to_degrees()
    }

    fn meets(self, [west, south, east, north]: [f64; 4]) -> bool {
        let meets = |turn: f64| self.longitude(0.0) + turn <= east && west <= self.longitude(1.0) + turn;
        (meets(0.0) || meets(360.0)) && self.latitude(1.0) <= north && south <= self.latitude(0.0)
    }
}

impl RasterRequest {
    /// From the path's last three segments and the query.
    pub(super) fn parse(
        [z, x, file]: [&str; 3],
        query: &str,
        encoding: Encoding,
        tileset: &Tileset,
    ) -> Result<Self, Failure> {
        let (y, ending) = file.split_once('.').unwrap_or((file, ""));
        let format = Format::named(ending)?;
        let asked = query.split('&').find_map(|part| part.strip_prefix("size="));
        let size = match asked {
            Some(text) => size(whole_number(text).unwrap_or(0))?,
            None => SIZES[0],
        };
        let tile = match (whole_number(z), whole_number(x), whole_number(y)) {
            (Some(zoom), Some(x), Some(y)) if zoom <= u32::from(FINEST) && x >> zoom == 0 && y >> zoom == 0 => {
                MercatorTile { zoom: zoom as u8, x, y }
            }
            _ => {
                return Err(Failure::BadRequest(format!(
                    "{z}/{x}/{file} is no tile of Web Mercator"
                )));
            }
        };
        if tile.zoom > finest_zoom(tileset, size) || !tile.meets(tileset.metadata().bounds) {
            let name = &tileset.name;
            return Err(Failure::NotFound(format!(
                "tileset “{name}” has no raster tile {z}/{x}/{file}"
            )));
        }
        Ok(Self {
            tile,
            size,
            encoding,
            format,
        })
    }

    /// The surface's zoom.
    pub(super) fn surface_zoom(&self, tileset: &Tileset) -> u8 {
        surface_zoom(tileset, self.tile.zoom, self.size)
    }

    /// What tells it from other rasters of the same surface.
    pub(super) fn tag(&self) -> String {
        let MercatorTile { zoom, x, y } = self.tile;
        let (encoding, format) = (self.encoding.name(), self.format.name());
        format!("{zoom}-{x}-{y}-{encoding}-{}-{format}", self.size)
    }
}

pub(super) fn size(size: u32) -> Result<u32, Failure> {
    SIZES
        .contains(&size)
        .then_some(size)
        .ok_or_else(|| Failure::BadRequest("tiles have 256 or 512 pixels a side".to_owned()))
}

/// A tile of 256 pixels of zoom z is two tiles of the surface's zoom z wide; one of 512 has the pixels of the next.
fn surface_zoom(tileset: &Tileset, zoom: u8, size: u32) -> u8 {
    let zoom = zoom + u8::from(size == SIZES[1]);
    zoom.min(tileset.metadata().max_zoom)
}

/// The last zoom that shows more than the one before.
pub(super) fn finest_zoom(tileset: &Tileset, size: u32) -> u8 {
    tileset.metadata().max_zoom.saturating_sub(u8::from(size == SIZES[1]))
}

/// Largest certified error of the surface that rasters of a zoom are drawn from, metres.
pub(super) fn error(tileset: &Tileset, zoom: u8, size: u32) -> f64 {
    let surface = surface_zoom(tileset, zoom, size);
    let zooms = &tileset.metadata().zooms;
    zooms
        .iter()
        .find(|entry| entry.zoom == surface)
        .map_or(0.0, |entry| entry.finest_error)
}
