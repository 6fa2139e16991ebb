//! Heightmaps of a pack: heights at posts first, of one heightmap after the other; when the lowest and the highest of all are known,
//! each as files of one scale.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use glam::UVec2;
use rayon::prelude::*;
use tempfile::TempDir;

use super::super::folder::Folder;
use super::super::unusable::Unusable;
use super::grid::Grid;
use super::images::{self, Scale};
use super::pieces::{Pieces, Record};
use super::posts::Posts;

/// One heightmap.
#[derive(Clone, Debug)]
pub(super) struct Heightmap {
    pub(super) tile: UVec2,
    /// Path of its files, without their extensions.
    pub(super) path: String,
    /// Metres of its lowest and highest post with ground, in single precision; none where no post has any.
    pub(super) heights: Option<[f32; 2]>,
    pub(super) posts_without_ground: usize,
    /// Of what is between posts from the surface, metres.
    difference: f64,
    /// Metres up for a metre across, at most.
    steepest: f64,
}

/// All of a pack.
pub(super) struct Heightmaps {
    pub(super) grid: Grid,
    pub(super) scale: Scale,
    pub(super) maps: Vec<Heightmap>,
    /// Metres along the frame's up from the surface to what is between posts, at most, where there is ground.
    pub(super) sampling_error: f64,
    /// Metres up for a metre across between posts that have ground, at most.
    pub(super) steepest: f64,
}

/// Writes all heightmaps of `grid`.
pub(super) fn write(folder: &Folder, pieces: &Pieces, grid: Grid) -> anyhow::Result<Heightmaps> {
    let kept = Kept(TempDir::new_in(folder.path())?);
    let maps: Vec<Heightmap> = grid
        .all()
        .map(|tile| sample(pieces, &grid, tile, &kept))
        .collect::<Result<_, _>>()?;
    let heights = maps.iter().filter_map(|map| map.heights);
    let [low, high] = heights
        .reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])
        .ok_or_else(|| Unusable("there is no ground in that box".to_owned()))?;
    let scale = Scale::new(low.into(), high.into());
    maps.par_iter()
        .try_for_each(|map| encode(folder, map, &grid, scale, &kept))?;
    // A post's height was rounded, too, by half of the last bit.
    let rounding = f64::from(low.abs().max(high.abs())) * f64::from(f32::EPSILON) / 2.0;
    let difference = maps.iter().map(|map| map.difference).fold(0.0, f64::max);
    Ok(Heightmaps {
        grid,
        scale,
        sampling_error: difference.max(rounding),
        steepest: maps.iter().map(|map| map.steepest).fold(0.0, f64::max),
        maps,
    })
}

/// Heights at posts, between being made and being encoded.
struct Kept(TempDir);

impl Kept {
    fn path(&self, tile: UVec2) -> PathBuf {
        self.0.path().join(format!("{}_{}", tile.x, tile.y))
    }

    fn put(&self, tile: UVec2, heights: &[f32]) -> anyhow::Result<()> {
        let path = self.path(tile);
        let bytes: Vec<u8> = heights.iter().flat_map(|height| height.to_ne_bytes()).collect();
        fs::write(&path, bytes).with_context(|| path.display().to_string())
    }

    fn take(&self, tile: UVec2) -> anyhow::Result<Vec<f32>> {
        let path = self.path(tile);
        let bytes = fs::read(&path).with_context(|| path.display().to_string())?;
        fs::remove_file(&path)?;
        Ok(bytes
            .as_chunks()
            .0
            .iter()
            .map(|&bytes| f32::from_ne_bytes(bytes))
            .collect())
    }
}

/// Finds and keeps the heights of one heightmap; holds as many pieces at a time as there are threads.
fn sample(pieces: &Pieces, grid: &Grid, tile: UVec2, kept: &Kept) -> anyhow::Result<Heightmap> {
    let rectangle = grid.rectangle(tile);
    let below: Vec<&Record> = pieces
        .records
        .iter()
        .filter(|record| record.bounds.meets(rectangle))
        .collect();
    let mut posts = Posts::empty(grid, tile);
    for some in below.chunks(rayon::current_num_threads()) {
        let read: Vec<_> = some
            .par_iter()
            .map(|record| pieces.read(record.address))
            .collect::<Result<_, _>>()?;
        read.iter().for_each(|piece| posts.add(piece));
    }
    let differences = below
        .par_iter()
        .map(|record| Ok(posts.difference(&pieces.read(record.address)?)));
    let difference = differences.try_reduce(|| 0.0, |one: f64, other| Ok::<_, anyhow::Error>(one.max(other)))?;
    kept.put(tile, &posts.heights)?;
    let ground = posts.heights.iter().copied().filter(|height| !height.is_nan());
    Ok(Heightmap {
        tile,
        path: format!("heightmaps/{}_{}", tile.x, tile.y),
        heights: ground
            .clone()
            .map(|height| [height; 2])
            .reduce(|[low, high], [a, b]| [low.min(a), high.max(b)]),
        posts_without_ground: posts.heights.len() - ground.count(),
        difference,
        steepest: posts.steepest(),
    })
}

fn encode(folder: &Folder, map: &Heightmap, grid: &Grid, scale: Scale, kept: &Kept) -> anyhow::Result<()> {
    let mut heights = kept.take(map.tile)?;
    let size = grid.size;
    let path = |extension: &str| format!("{}.{extension}", map.path);
    let numbered = images::from_north(&heights, size);
    folder.stream(&path("png"), |out| images::write_png(out, &numbered, size, scale))?;
    folder.stream(&path("r16"), |out| images::write_r16(out, &numbered, scale))?;
    let zero = scale.zero as f32;
    heights
        .iter_mut()
        .filter(|height| height.is_nan())
        .for_each(|height| *height = zero);
    folder.stream(&path("bin"), |out| images::write_mujoco(out, &heights, size))?;
    let filled = images::from_north(&heights, size);
    folder.stream(&path("tif"), |out| images::write_tiff(out, &filled, size))?;
    folder.stream(&path("exr"), |out| images::write_exr(out, &filled, size))
}
