//! Heights as colours, and colours as files.

use std::io;

use png::{BitDepth, ColorType, Encoder};

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

/// What file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Its colours are compressed without loss.
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

/// A file of a square of colours. It has no colour profile: a client would change the numbers by it.
///
/// # Errors
/// Where `colours` are not three numbers for each of `size` times `size` pixels.
pub fn write(format: Format, colours: &[u8], size: u32) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    match format {
        Format::Png => {
            let mut encoder = Encoder::new(&mut file, size, size);
            encoder.set_color(ColorType::Rgb);
            encoder.set_depth(BitDepth::Eight);
            encoder.write_header()?.write_image_data(colours)?;
        }
        Format::WebP => {
            let encoder = image_webp::WebPEncoder::new(&mut file);
            let encoded = encoder.encode(colours, size, size, image_webp::ColorType::Rgb8);
            encoded.map_err(io::Error::other)?;
        }
    }
    Ok(file)
}
