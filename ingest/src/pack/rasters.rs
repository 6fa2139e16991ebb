//! Raster tiles of heights as one PMTiles file.
//!
//! ```text
//! tiles of the archive at the surface's zoom ─▶ tiles of Web Mercator over them ─▶ drawn from those surfaces ─▶ file
//! ```

use std::collections::BTreeSet;
use std::fs::File;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use anyhow::Context;
use rayon::prelude::*;
use serde_json::json;
use terrain_codec::address::{TileAddress, is_leaf};
use terrain_tiles::archive::Reader;
use terrain_tiles::mercator;
use terrain_tiles::raster_dem::RasterForm;
use terrain_tiles::raster_dem::image::Format;
use terrain_tiles::tile_file::{Header, Kind, SquareTile, TileFile};

use super::choice::Choice;
use super::unusable::Unusable;
use crate::archive_tiles::Grounds;

/// Writes the tiles that are meant by `choice`, whose zooms are those of Web Mercator here. Gives how many they are.
pub(super) fn write(archive: &Reader, form: RasterForm, choice: &Choice, output: &Path) -> anyhow::Result<usize> {
    let metadata = archive.metadata();
    let finest = choice.finest_zoom(form.finest_zoom(metadata), |zoom| form.error(metadata, zoom))?;
    let bounds = choice.bounds(metadata.bounds)?;
    let tiles = tiles(archive, form, choice, finest);
    if tiles.is_empty() {
        return Err(Unusable("the archive has no tile there".to_owned()).into());
    }
    let grounds = Grounds::of(archive);
    let file = TileFile::create_in(output.parent().unwrap_or(Path::new(".")))?;
    let file = Mutex::new(file);
    tiles.par_iter().try_for_each(|&tile| {
        let drawn = form.draw(metadata, tile, |address| grounds.at(address));
        let drawn = drawn.with_context(|| format!("raster tile {}/{}/{}", tile.zoom, tile.x, tile.y))?;
        file.lock().unwrap_or_else(PoisonError::into_inner).add(tile, &drawn)?;
        anyhow::Ok(())
    })?;
    let mut description = form.description(metadata, finest);
    description["name"] = json!(metadata.source.files.join(", "));
    description["type"] = json!("baselayer");
    description["version"] = json!(format!("{:032x}", archive.version()));
    description["generator"] = json!(metadata.generator);
    let header = Header {
        kind: match form.format {
            Format::Png => Kind::Png,
            Format::WebP => Kind::WebP,
        },
        is_gzipped: false,
        are_equal_tiles_one: true,
        zooms: [0, finest],
        bounds: within_mercator(bounds),
        json: description.to_string(),
    };
    let file = file.into_inner().unwrap_or_else(PoisonError::into_inner);
    file.write(header, &mut File::create_new(output)?)?;
    Ok(tiles.len())
}

/// Those over tiles of the archive, so that where it has none no zoom is filled with nothing.
fn tiles(archive: &Reader, form: RasterForm, choice: &Choice, finest: u8) -> BTreeSet<SquareTile> {
    let metadata = archive.metadata();
    let there = choice.tiles(archive);
    let is_leaf = &|address: TileAddress| is_leaf(address, |child| there.contains(&child));
    let of_zoom = |zoom| {
        let surface = form.surface_zoom(metadata, zoom);
        let stands =
            move |address: &&TileAddress| address.zoom == surface || (address.zoom < surface && is_leaf(**address));
        let surfaces = there.iter().filter(stands);
        surfaces.flat_map(move |&address| mercator::tiles_over(address, zoom))
    };
    let is_meant = |&tile: &SquareTile| mercator::meets(tile, metadata.bounds) && choice.meets(mercator::bounds(tile));
    (0..=finest).flat_map(of_zoom).filter(is_meant).collect()
}

fn within_mercator([west, south, east, north]: [f64; 4]) -> [f64; 4] {
    let [south, north] = [south, north].map(|latitude| latitude.clamp(-mercator::LATITUDES, mercator::LATITUDES));
    [west, south, east, north]
}
