//! Heights as colours, and pixels as files.

use std::io;

use png::{BitDepth, ColorType, Encoder};

use super::webp;

/// Numbers of 24 bits, the most significant in red.
const LARGEST: f64 = 16_777_215.0;

/// How a colour stands for a height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Metres and 256ths of them.
    Terrarium,
    /// Decimetres.
    Mapbox,
}

/// What a pixel is, in one byte for each of its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pixels {
    /// Red, green and blue.
    Colour,
    /// One number.
    Grey,
}

/// What file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Its pixels are compressed without loss.
    Png,
    /// So are those of this one.
    WebP,
}

impl Encoding {
    /// What clients call it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Terrarium => "terrarium",
            Self::Mapbox => "mapbox",
        }
    }

    /// Metres from one number to the next.
    pub(super) fn step(self) -> f64 {
        match self {
            Self::Terrarium => 1.0 / 256.0,
            Self::Mapbox => 0.1,
        }
    }

    /// How many numbers below that of height 0 the least is.
    fn zero(self) -> f64 {
        match self {
            Self::Terrarium => 32_768.0 * 256.0,
            Self::Mapbox => 100_000.0,
        }
    }

    /// The colour of a height that is rounded to a multiple of `quantum`, here and nowhere else.
    pub(super) fn colour(self, metres: f64, quantum: f64) -> [u8; 3] {
        let steps = (quantum / self.step()).round();
        let number = ((metres / quantum).round() * steps + self.zero()).clamp(0.0, LARGEST);
        let [_, red, green, blue] = (number as u32).to_be_bytes();
        [red, green, blue]
    }
}

impl Format {
    /// The format that files with this ending have.
    #[must_use]
    pub fn named(ending: &str) -> Option<Self> {
        match ending {
            "png" => Some(Self::Png),
            "webp" => Some(Self::WebP),
            _ => None,
        }
    }

    /// What its files end in.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::WebP => "webp",
        }
    }

    /// As HTTP calls it.
    #[must_use]
    pub fn content_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::WebP => "image/webp",
        }
    }
}

/// A file of a rectangle of pixels. It has no colour profile: a client would change the numbers by it.
///
/// # Errors
/// Where there are not as many `numbers` as so many pixels have.
pub fn write(format: Format, pixels: Pixels, numbers: &[u8], [width, height]: [u32; 2]) -> io::Result<Vec<u8>> {
    match (format, pixels) {
        (Format::Png, _) => {
            let mut file = Vec::new();
            let mut encoder = Encoder::new(&mut file, width, height);
            encoder.set_color(match pixels {
                Pixels::Colour => ColorType::Rgb,
                Pixels::Grey => ColorType::Grayscale,
            });
            encoder.set_depth(BitDepth::Eight);
            encoder.write_header()?.write_image_data(numbers)?;
            Ok(file)
        }
        (Format::WebP, Pixels::Colour) => webp::write(numbers, [width, height]),
        (Format::WebP, Pixels::Grey) => {
            let colours: Vec<u8> = numbers.iter().flat_map(|&number| [number; 3]).collect();
            webp::write(&colours, [width, height])
        }
    }
}
