//! Which raster tile is asked for.

use terrain_codec::address::TileAddress;
use terrain_tiles::metadata::Metadata;
use terrain_tiles::raster_dem::image::{Encoding, Format};
use terrain_tiles::raster_dem::{RasterForm, SIZES};
use terrain_tiles::tile_file::SquareTile;

use crate::failure::Failure;
use crate::form::{square_tile, tile_address, whole_number};

/// Which raster, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RasterRequest {
    pub(crate) tile: SquareTile,
    pub(crate) form: RasterForm,
}

impl RasterRequest {
    /// From the path's last three segments and the query.
    pub(super) fn parse([z, x, file]: [&str; 3], query: &str, encoding: Encoding) -> Result<Self, Failure> {
        let (_, ending) = file.split_once('.').unwrap_or((file, ""));
        let format = format(ending)?;
        let asked = query.split('&').find_map(|part| part.strip_prefix("size="));
        let size = match asked {
            Some(text) => size(whole_number(text).unwrap_or(0))?,
            None => SIZES[0],
        };
        let tile = square_tile([z, x, file])?;
        let form = RasterForm { size, encoding, format };
        Ok(Self { tile, form })
    }

    /// Whether an archive has such a tile: beside its data, too, for clients draw with the neighbours of a tile.
    pub(super) fn is_of(&self, metadata: &Metadata) -> bool {
        self.tile.zoom <= self.form.finest_zoom(metadata)
    }

    /// What tells it from other rasters of the same surface.
    pub(super) fn name(&self) -> String {
        let SquareTile { zoom, x, y } = self.tile;
        let RasterForm { size, encoding, format } = self.form;
        format!("{zoom}-{x}-{y}-{}-{size}-{}", encoding.name(), format.name())
    }
}

/// Which raster of normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct GradientsRequest {
    pub(super) address: TileAddress,
    pub(super) format: Format,
}

impl GradientsRequest {
    /// From the path's last three segments.
    pub(super) fn parse([z, x, file]: [&str; 3]) -> Result<Self, Failure> {
        let (_, ending) = file.split_once('.').unwrap_or((file, ""));
        Ok(Self {
            format: format(ending)?,
            address: tile_address([z, x, file])?,
        })
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
