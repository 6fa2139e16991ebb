//! Raster tiles of heights as one PMTiles file.
//!
//! ```text
//! tiles of the archive at the surface's zoom ─▶ tiles of Web Mercator over and beside them ─▶ drawn from those surfaces ─▶ file
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
use terrain_tiles::metadata::Metadata;
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
    let mut description = form.description(metadata, finest, bounds);
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
        bounds: mercator::within(bounds),
        json: description.to_string(),
    };
    let file = file.into_inner().unwrap_or_else(PoisonError::into_inner);
    file.write(header, &mut File::create_new(output)?)?;
    Ok(tiles.len())
}

/// Those of the part that is meant, and beside them where the archive has none: clients draw a tile with its neighbours. Farther out no
/// zoom is filled with nothing.
fn tiles(archive: &Reader, form: RasterForm, choice: &Choice, finest: u8) -> BTreeSet<SquareTile> {
    let metadata = archive.metadata();
    let over = |surfaces: &BTreeSet<TileAddress>| tiles_over(surfaces, metadata, form, finest);
    let all = over(&archive.addresses().collect());
    let mut meant = over(&choice.tiles(archive));
    meant.retain(|&tile| choice.meets(mercator::bounds(tile)));
    let beside: Vec<SquareTile> = meant.iter().flat_map(|&tile| mercator::around(tile)).collect();
    meant.extend(beside.into_iter().filter(|tile| !all.contains(tile)));
    meant
}

/// Of zooms 0 to `finest`, those that show some of the surfaces at these addresses.
fn tiles_over(
    surfaces: &BTreeSet<TileAddress>,
    metadata: &Metadata,
    form: RasterForm,
    finest: u8,
) -> BTreeSet<SquareTile> {
    let is_leaf = &|address: TileAddress| is_leaf(address, |child| surfaces.contains(&child));
    let of_zoom = |zoom| {
        let surface = form.surface_zoom(metadata, zoom);
        let stands =
            move |address: &&TileAddress| address.zoom == surface || (address.zoom < surface && is_leaf(**address));
        let shown = surfaces.iter().filter(stands);
        shown.flat_map(move |&address| mercator::tiles_over(address, zoom))
    };
    let has_data = |&tile: &SquareTile| mercator::meets(tile, metadata.bounds);
    (0..=finest).flat_map(of_zoom).filter(has_data).collect()
}
