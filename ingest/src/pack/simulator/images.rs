//! Heightmaps as files. Images have their north row first; MuJoCo's file has the south row first.

use std::io::{Cursor, Write};

use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
use tiff::encoder::colortype::Gray32Float;
use tiff::encoder::{Compression, TiffEncoder};

/// How whole numbers of 16 bits stand for heights, the same in all heightmaps of a pack: 0 is no ground, the others are ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// Metres that 0 stands for, below all ground.
    pub(super) zero: f64,
    /// Metres from one number to the next.
    pub(super) quantum: f64,
}

/// The greatest number.
const MOST: f64 = u16::MAX as f64;
/// Metres of the smallest range that a scale is made for.
const LEAST_RANGE: f64 = 1.0;

impl Scale {
    /// The finest for ground from `low` to `high`.
    pub(super) fn new(low: f64, high: f64) -> Self {
        let quantum = (high - low).max(LEAST_RANGE) / (MOST - 1.0);
        Self {
            zero: low - quantum,
            quantum,
        }
    }

    pub(super) fn number(self, height: f32) -> u16 {
        if height.is_nan() {
            0
        } else {
            ((f64::from(height) - self.zero) / self.quantum)
                .round()
                .clamp(1.0, MOST) as u16
        }
    }

    fn numbers(self, heights: &[f32]) -> impl Iterator<Item = u16> {
        heights.iter().map(move |&height| self.number(height))
    }
}

/// Rows in the order of images, from rows from the south.
pub(super) fn from_north(heights: &[f32], size: u32) -> Vec<f32> {
    heights.rchunks_exact(size as usize).flatten().copied().collect()
}

/// PNG (W3C, third edition) of 16 bits of grey.
pub(super) fn write_png(out: &mut dyn Write, from_north: &[f32], size: u32, scale: Scale) -> anyhow::Result<()> {
    let samples: Vec<u8> = scale.numbers(from_north).flat_map(u16::to_be_bytes).collect();
    let mut encoder = png::Encoder::new(out, size, size);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.write_header()?.write_image_data(&samples)?;
    Ok(())
}

/// Numbers of 16 bits, the least significant byte first, and nothing else.
pub(super) fn write_r16(out: &mut dyn Write, from_north: &[f32], scale: Scale) -> anyhow::Result<()> {
    let samples: Vec<u8> = scale.numbers(from_north).flat_map(u16::to_le_bytes).collect();
    Ok(out.write_all(&samples)?)
}

/// TIFF 6.0 of metres in single precision.
pub(super) fn write_tiff(out: &mut dyn Write, from_north: &[f32], size: u32) -> anyhow::Result<()> {
    let mut file = Cursor::new(Vec::new());
    TiffEncoder::new(&mut file)?
        .with_compression(Compression::Deflate(Default::default()))
        .write_image::<Gray32Float>(size, size, from_north)?;
    Ok(out.write_all(file.get_ref())?)
}

/// OpenEXR of metres in single precision, in the channel of luminance.
pub(super) fn write_exr(out: &mut dyn Write, from_north: &[f32], size: u32) -> anyhow::Result<()> {
    let channel = AnyChannel::new("Y", FlatSamples::F32(from_north.to_vec()));
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let mut file = Cursor::new(Vec::new());
    Image::from_channels((size as usize, size as usize), channels)
        .write()
        .non_parallel()
        .to_buffered(&mut file)?;
    Ok(out.write_all(file.get_ref())?)
}

/// A height field of MuJoCo (*XML Reference*, `asset/hfield`): rows, columns, and metres in single precision.
pub(super) fn write_mujoco(out: &mut dyn Write, from_south: &[f32], size: u32) -> anyhow::Result<()> {
    let side = i32::try_from(size)?.to_le_bytes();
    out.write_all(&side)?;
    out.write_all(&side)?;
    let samples: Vec<u8> = from_south.iter().flat_map(|height| height.to_le_bytes()).collect();
    Ok(out.write_all(&samples)?)
}

#[cfg(test)]
#[path = "images_tests.rs"]
mod tests;
