//! A pack for simulators: the surface of one zoom in a local frame, as meshes and as heightmaps, with worlds that put them in place
//! and a manifest that says how far each is from the source.
//!
//! ```text
//! tiles of a zoom ─▶ in the frame ─┬─▶ meshes: GLB, OBJ, USD                          one tile at a time
//!                                  └─▶ posts ─▶ heightmaps: PNG, R16, TIFF, EXR, MuJoCo  one heightmap at a time
//! what is known of each ─▶ worlds: SDFormat, MJCF, USD; manifest.json
//! ```

mod frame;
mod grid;
mod heightmaps;
mod images;
mod manifest;
mod piece;
mod pieces;
mod posts;
mod usd;
mod worlds;

use std::collections::BTreeSet;

use glam::DVec2;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::METRES_IN_A_DEGREE;
use terrain_tiles::archive::Reader;
use terrain_tiles::metadata::Metadata;

use self::frame::Frame;
use self::grid::Grid;
use self::manifest::Manifest;
use self::pieces::Pieces;
use super::choice::Choice;
use super::folder::{Folder, sums};

/// What a pack for simulators is to be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Longitude and latitude of the frame's origin; the middle if not given.
    pub origin: Option<[f64; 2]>,
    /// Posts along a side of a heightmap.
    pub size: Option<u32>,
    /// Metres from post to post, at most; about those of the source if not given.
    pub spacing: Option<f64>,
}

/// Writes the tiles `chosen`, of which none is below another one, and heightmaps of all that `choice` and the archive have in common.
pub(super) fn write(
    archive: &Reader,
    chosen: &BTreeSet<TileAddress>,
    choice: &Choice,
    options: Options,
    folder: &Folder,
) -> anyhow::Result<()> {
    let metadata = archive.metadata();
    let zoom = chosen.last().map_or(0, |address| address.zoom);
    let tiles: Vec<TileAddress> = chosen.iter().copied().collect();
    let area = choice.bounds(metadata.bounds)?;
    let middle = DVec2::new(area[0].midpoint(area[2]), area[1].midpoint(area[3]));
    let origin = options.origin.map_or(middle, DVec2::from_array);
    let frame = Frame::new(origin, &tiles, metadata.heights, metadata.asked.reading.local)?;
    let zooms = metadata
        .zooms
        .iter()
        .filter(|entry| chosen.iter().any(|tile| tile.zoom == entry.zoom));
    let outline_error = zooms.map(|zoom| zoom.outline_error).fold(0.0, f64::max);
    let rectangle = grid::inside(&frame, area, metadata.heights, outline_error + frame.step)?;
    let spacing = options.spacing.unwrap_or_else(|| source_spacing(metadata, zoom));
    let grid = Grid::new(rectangle, spacing, options.size)?;
    let pieces = Pieces::write(archive, &tiles, &frame, folder)?;
    let heightmaps = heightmaps::write(folder, &pieces, grid)?;
    folder.stream("meshes.sdf", |out| {
        Ok(worlds::write_sdf_of_meshes(out, &frame, &pieces.records)?)
    })?;
    folder.stream("heightmaps.sdf", |out| {
        Ok(worlds::write_sdf_of_heightmaps(out, &frame, &heightmaps)?)
    })?;
    folder.stream("mujoco.xml", |out| Ok(worlds::write_mjcf(out, &heightmaps)?))?;
    let paths = || pieces.records.iter().map(|record| &*record.path);
    folder.stream("terrain.usda", |out| Ok(usd::write_stage(out, paths())?))?;
    let files = sums(folder.path())?;
    let manifest = Manifest::new(metadata, archive.version(), &frame, &pieces, &heightmaps, files);
    folder.write("manifest.json", &serde_json::to_vec_pretty(&manifest)?)
}

/// Metres from sample to sample of the source, doubled for each zoom above the leaves.
fn source_spacing(metadata: &Metadata, zoom: u8) -> f64 {
    let [west, south, east, north] = metadata.bounds;
    let [columns, rows] = metadata.source.samples.map(|count| count.max(2) as f64 - 1.0);
    let across = (east - west) / columns * south.midpoint(north).to_radians().cos();
    let up = (north - south) / rows;
    let zooms_above = i32::from(metadata.max_zoom.saturating_sub(zoom));
    across.min(up) * METRES_IN_A_DEGREE * 2_f64.powi(zooms_above)
}
