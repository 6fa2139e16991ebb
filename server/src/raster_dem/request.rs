//! Which raster tile is asked for.

use terrain_tiles::mercator;
use terrain_tiles::raster_dem::image::{Encoding, Format};
use terrain_tiles::raster_dem::{RasterForm, SIZES};
use terrain_tiles::tile_file::SquareTile;

use crate::failure::Failure;
use crate::form::{square_tile, whole_number};
use crate::tileset::Tileset;

/// Which raster, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RasterRequest {
    pub(crate) tile: SquareTile,
    pub(crate) form: RasterForm,
}

impl RasterRequest {
    /// From the path's last three segments and the query.
    pub(super) fn parse(
        [z, x, file]: [&str; 3],
        query: &str,
        encoding: Encoding,
        tileset: &Tileset,
    ) -> Result<Self, Failure> {
        let (_, ending) = file.split_once('.').unwrap_or((file, ""));
        let format = format(ending)?;
        let asked = query.split('&').find_map(|part| part.strip_prefix("size="));
        let size = match asked {
            Some(text) => size(whole_number(text).unwrap_or(0))?,
            None => SIZES[0],
        };
        let tile = square_tile([z, x, file])?;
        let form = RasterForm { size, encoding, format };
        let metadata = tileset.metadata();
        if tile.zoom > form.finest_zoom(metadata) || !mercator::meets(tile, metadata.bounds) {
            let name = &tileset.name;
            return Err(Failure::NotFound(format!(
                "tileset “{name}” has no raster tile {z}/{x}/{file}"
            )));
        }
        Ok(Self { tile, form })
    }

    /// What tells it from other rasters of the same surface.
    pub(super) fn tag(&self) -> String {
        let SquareTile { zoom, x, y } = self.tile;
        let RasterForm { size, encoding, format } = self.form;
        format!("{zoom}-{x}-{y}-{}-{size}-{}", encoding.name(), format.name())
    }
}

pub(super) fn size(size: u32) -> Result<u32, Failure> {
    SIZES
        .contains(&size)
        .then_some(size)
        .ok_or_else(|| Failure::BadRequest("tiles have 256 or 512 pixels a side".to_owned()))
}

pub(super) fn format(ending: &str) -> Result<Format, Failure> {
    let unknown = || Failure::BadRequest(format!("raster tiles end in .png or .webp, not in “{ending}”"));
    Format::named(ending).ok_or_else(unknown)
}
