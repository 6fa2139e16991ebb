//! A raster with more samples over the same place, by cubic splines: terrain of any size, to see how costs grow.
//!
//! ```sh
//! cargo run --release -p terrain-tests --example upsample -- S33W071.tif 10801 upsampled.tif
//! ```
//! Float32 heights, strips, WGS84; the outermost samples stay where they are.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Parser;
use glam::DVec2;
use rayon::prelude::*;
use terrain_ingest::{HeightGrid, ReadOptions, raster};
use tiff::encoder::{TiffEncoder, TiffKindBig, colortype};
use tiff::tags::Tag;

/// Rows of a strip.
const STRIP: usize = 16;

#[derive(Parser)]
struct Arguments {
    /// A raster in WGS84 degrees, rows along parallels, without voids.
    dem: PathBuf,
    /// Columns and rows of the new one.
    size: usize,
    /// The GeoTIFF to write.
    output: PathBuf,
}

fn main() -> Result<()> {
    let Arguments { dem, size, output } = Arguments::parse();
    let grid = raster::read(&[dem], &ReadOptions::default())?;
    ensure!(size > 1, "a surface needs 2 × 2 samples");
    ensure!(
        grid.heights.iter().all(|height| !height.is_nan()),
        "the raster has voids"
    );
    write(&grid, size, &output).with_context(|| output.display().to_string())
}

fn write(grid: &HeightGrid, size: usize, output: &Path) -> Result<()> {
    let file = BufWriter::new(File::create(output)?);
    let mut tiff = TiffEncoder::new_big(file)?;
    let mut image = tiff.new_image::<colortype::Gray32Float>(size as u32, size as u32)?;
    image.rows_per_strip(STRIP as u32)?;
    write_place(image.encoder(), grid, size)?;
    for first in (0..size).step_by(STRIP) {
        let rows = first..(first + STRIP).min(size);
        let strip: Vec<f32> = rows
            .into_par_iter()
            .flat_map_iter(|row| upsampled_row(grid, size, row))
            .collect();
        image.write_strip(&strip)?;
    }
    image.finish()?;
    Ok(())
}

/// GeoTIFF 1.1: a scale, a tie point and the keys of WGS84; pixels are points.
fn write_place<W: std::io::Write + std::io::Seek>(
    image: &mut tiff::encoder::DirectoryEncoder<'_, W, TiffKindBig>,
    grid: &HeightGrid,
    size: usize,
) -> Result<()> {
    let at = |column: usize, row: usize| grid.georeference.geographic(DVec2::new(column as f64, row as f64));
    let [first, last] = [at(0, 0), at(grid.columns - 1, grid.rows - 1)];
    let cell = (last - first) / (size - 1) as f64;
    image.write_tag(Tag::Unknown(33550), &[cell.x, -cell.y, 0.0][..])?;
    image.write_tag(Tag::Unknown(33922), &[0.0, 0.0, 0.0, first.x, first.y, 0.0][..])?;
    let keys: [[u16; 4]; 4] = [[1, 1, 0, 3], [1024, 0, 1, 2], [1025, 0, 1, 2], [2048, 0, 1, 4326]];
    image.write_tag(Tag::Unknown(34735), keys.as_flattened())?;
    Ok(())
}

fn upsampled_row(grid: &HeightGrid, size: usize, row: usize) -> Vec<f32> {
    let (rows, weights) = taps(row, size, grid.rows);
    let blended: Vec<f64> = (0..grid.columns)
        .map(|column| {
            let heights = rows.iter().map(|&row| f64::from(grid.height(column, row)));
            heights.zip(weights).map(|(height, weight)| height * weight).sum()
        })
        .collect();
    let height = |column: usize| {
        let (columns, weights) = taps(column, size, grid.columns);
        let sum: f64 = columns
            .iter()
            .zip(weights)
            .map(|(&column, weight)| blended[column] * weight)
            .sum();
        sum as f32
    };
    (0..size).map(height).collect()
}

/// The four samples that a new one is made of, and their weights: those of the uniform cubic B-spline.
fn taps(index: usize, size: usize, samples: usize) -> ([usize; 4], [f64; 4]) {
    let at = index as f64 * (samples - 1) as f64 / (size - 1) as f64;
    let (cell, t) = (at.floor(), at.fract());
    let tap = |step: f64| (cell + step).clamp(0.0, (samples - 1) as f64) as usize;
    let (s, t2, t3) = (1.0 - t, t * t, t * t * t);
    let weights = [
        s * s * s,
        3.0 * t3 - 6.0 * t2 + 4.0,
        -3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0,
        t3,
    ];
    ([-1.0, 0.0, 1.0, 2.0].map(tap), weights.map(|weight| weight / 6.0))
}
