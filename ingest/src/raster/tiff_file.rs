//! GeoTIFF (OGC 19-008r4) and cloud-optimised GeoTIFF by the `tiff` crate, for whoever does not want GDAL to touch the file. No other
//! file is looked at. What it cannot read is refused by name.

mod geo_keys;

use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{PhotometricInterpretation, PlanarConfiguration, Tag};
use tiff::{ColorType, TiffError};

use super::options::RasterLimits;
use super::reader::{Found, Reader};
use super::{ReadError, ReadOptions};
use geo_keys::GeoKeys;

/// Bytes of a value of the directory, such as the places of all tiles.
const DIRECTORY_VALUE: usize = 1 << 26;
/// Directories that are looked at for masks.
const DIRECTORIES: usize = 64;
/// Bit of `NewSubfileType` that says that a directory is a mask.
const IS_MASK: u64 = 4;
/// GDAL's own tag with scale, offset, unit and other remarks, as XML.
const GDAL_METADATA: Tag = Tag::Unknown(42112);
/// In which GDAL's remarks say what heights are above.
const DATUM: &str = "vertical_datum";

type Open = Decoder<BufReader<File>>;

pub(super) struct TiffFile {
    path: PathBuf,
    limits: RasterLimits,
    /// Those that nobody reads by just now.
    idle: Mutex<Vec<Open>>,
    size: [usize; 2],
    chunk: [usize; 2],
    /// Values of a sample that stand beside each other.
    beside: usize,
    /// Whether a chunk is in the file, by its number: none that is not.
    stored: Vec<bool>,
    nodata: Option<f64>,
}

impl TiffFile {
    pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Found, ReadError> {
        let unreadable = |error: TiffError| ReadError::unreadable(path, error);
        let mut decoder = decoder(path, options.limits).map_err(unreadable)?;
        refuse_strange(path, &mut decoder)?;
        let (width, height) = decoder.dimensions().map_err(unreadable)?;
        let (chunk_width, chunk_height) = decoder.chunk_dimensions();
        let (beside, greatest) = values_of_a_sample(&mut decoder).map_err(unreadable)?;
        let nodata = text(&mut decoder, Tag::GdalNodata).and_then(|text| text.trim().parse().ok());
        let remarks = text(&mut decoder, GDAL_METADATA).unwrap_or_default();
        let remark = |role: &str| remark(&remarks, role);
        let number = |role: &str| remark(role).and_then(|text| text.trim().parse().ok());
        let keys = GeoKeys::read(&mut decoder);
        let stored = stored_chunks(&mut decoder);
        let reference = keys.as_ref().map_or(Ok(None), |keys| keys.reference(path));
        let reference = match options.overrides.crs {
            Some(_) => reference.ok().flatten(),
            None => reference?,
        };
        let size = [width as usize, height as usize];
        let chunk = [chunk_width as usize, chunk_height as usize].map(|side| side.max(1));
        let (scale, offset) = (number("scale").unwrap_or(1.0), number("offset").unwrap_or(0.0));
        let reader = Self {
            path: path.to_owned(),
            limits: options.limits,
            idle: Mutex::new(vec![decoder]),
            size,
            chunk,
            beside,
            stored,
            nodata,
        };
        Ok(Found {
            reader: Box::new(reader),
            size,
            block: [chunk[0].min(size[0]), chunk[1].min(size[1])].map(|side| side.max(1)),
            crs: reference,
            to_crs: keys.as_ref().and_then(GeoKeys::to_crs),
            datum: remark(DATUM),
            remark: None,
            scale,
            offset,
            unit: remark("unittype").or_else(|| keys.as_ref()?.unit()).unwrap_or_default(),
            greatest,
        })
    }

    fn read_chunk(&self, decoder: &mut Open, number: usize) -> Result<Vec<f64>, ReadError> {
        if !self.stored.get(number).copied().unwrap_or(true) {
            let (width, height) = decoder.chunk_data_dimensions(number as u32);
            let values = (width * height) as usize * self.beside;
            return Ok(vec![if self.nodata.is_some() { f64::NAN } else { 0.0 }; values]);
        }
        let chunk = decoder.read_chunk(number as u32);
        let chunk = chunk.map_err(|error| ReadError::unreadable(&self.path, error))?;
        let mut values = numbers(chunk);
        for value in &mut values {
            let is_void = |nodata: f64| *value == nodata || *value as f32 == nodata as f32;
            if self.nodata.is_some_and(is_void) {
                *value = f64::NAN;
            }
        }
        Ok(values)
    }
}

impl Reader for TiffFile {
    fn stored(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError> {
        let idle = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = idle().pop();
        let mut decoder = match taken {
            Some(decoder) => decoder,
            None => decoder(&self.path, self.limits).map_err(|error| ReadError::unreadable(&self.path, error))?,
        };
        let mut values = vec![f64::NAN; columns.len() * rows.len()];
        let [width, height] = self.chunk;
        let across = self.size[0].div_ceil(width);
        for down in rows.start / height..rows.end.div_ceil(height) {
            for along in columns.start / width..columns.end.div_ceil(width) {
                let chunk = self.read_chunk(&mut decoder, down * across + along)?;
                let stride = width.min(self.size[0] - along * width) * self.beside;
                let left = columns.start.max(along * width);
                let right = columns.end.min((along + 1) * width);
                for row in rows.start.max(down * height)..rows.end.min((down + 1) * height) {
                    let from = (row - down * height) * stride + (left - along * width) * self.beside;
                    let to = (row - rows.start) * columns.len() + left - columns.start;
                    let Some(line) = chunk.get(from..from + (right - left) * self.beside) else {
                        return Err(ReadError::unreadable(&self.path, "a chunk is too short"));
                    };
                    let firsts = line.iter().step_by(self.beside);
                    values[to..to + right - left]
                        .iter_mut()
                        .zip(firsts)
                        .for_each(|(to, &value)| *to = value);
                }
            }
        }
        idle().push(decoder);
        Ok(values)
    }
}

fn decoder(path: &Path, limits: RasterLimits) -> Result<Open, TiffError> {
    let mut of_crate = Limits::default();
    of_crate.decoding_buffer_size = limits.block_bytes;
    of_crate.intermediate_buffer_size = limits.block_bytes;
    of_crate.ifd_value_size = DIRECTORY_VALUE;
    Ok(Decoder::new(BufReader::new(File::open(path)?))?.with_limits(of_crate))
}

/// Refuses what would be read as something else than it is.
fn refuse_strange(path: &Path, decoder: &mut Open) -> Result<(), ReadError> {
    let refuse = |reason: &str| Err(ReadError::unreadable(path, format!("{reason}; GDAL may read it")));
    let number = |decoder: &mut Open, tag: Tag| decoder.find_tag_unsigned::<u64>(tag).ok().flatten();
    let is_grey = number(decoder, Tag::PhotometricInterpretation)
        .is_none_or(|kind| kind == u64::from(PhotometricInterpretation::BlackIsZero.to_u16()));
    if !is_grey {
        return refuse("its values are colours, or white is the least of them");
    }
    let extra = decoder.find_tag_unsigned_vec::<u64>(Tag::ExtraSamples).ok().flatten();
    if extra.is_some_and(|extra| extra.iter().any(|&kind| kind == 1 || kind == 2)) {
        return refuse("it has a band of transparency");
    }
    for _ in 0..DIRECTORIES {
        if !decoder.more_images() || decoder.next_image().is_err() {
            break;
        }
        if number(decoder, Tag::NewSubfileType).is_some_and(|kind| kind & IS_MASK != 0) {
            return refuse("it has a mask");
        }
    }
    decoder
        .seek_to_image(0)
        .map_err(|error| ReadError::unreadable(path, error))
}

/// How many values of a sample stand beside each other, and the greatest that can be stored.
fn values_of_a_sample(decoder: &mut Open) -> Result<(usize, f64), TiffError> {
    let planar = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration)?;
    let is_planar = planar == Some(PlanarConfiguration::Planar.to_u16());
    let samples = decoder.find_tag_unsigned::<u16>(Tag::SamplesPerPixel)?.unwrap_or(1);
    let beside = if is_planar { 1 } else { usize::from(samples.max(1)) };
    let is_float = decoder
        .find_tag_unsigned_vec::<u16>(Tag::SampleFormat)?
        .is_some_and(|formats| formats.first() == Some(&3));
    let bits = match decoder.colortype()? {
        ColorType::Gray(bits) => bits,
        ColorType::Multiband { bit_depth, .. } => bit_depth,
        _ => 8,
    };
    let greatest = if is_float { 1.0 } else { f64::from(bits).exp2() - 1.0 };
    Ok((beside, greatest))
}

/// Sparse files have no bytes where nothing was written.
fn stored_chunks(decoder: &mut Open) -> Vec<bool> {
    let counts = [Tag::TileByteCounts, Tag::StripByteCounts]
        .into_iter()
        .find_map(|tag| decoder.find_tag_unsigned_vec::<u64>(tag).ok().flatten());
    counts.unwrap_or_default().into_iter().map(|bytes| bytes > 0).collect()
}

fn text(decoder: &mut Open, tag: Tag) -> Option<String> {
    decoder.get_tag_ascii_string(tag).ok()
}

/// A remark on band 1, or on the file, by its role or its name.
fn remark(xml: &str, role: &str) -> Option<String> {
    let document = roxmltree::Document::parse(xml.trim_end_matches('\0')).ok()?;
    let is_named = |item: &roxmltree::Node| {
        let called = item.attribute("role").or_else(|| item.attribute("name"));
        let is_of_first = item.attribute("sample").is_none_or(|sample| sample == "0");
        is_of_first && called.is_some_and(|name| name.eq_ignore_ascii_case(role))
    };
    let found = document.descendants().find(is_named)?;
    found.text().map(str::to_owned)
}

fn numbers(chunk: DecodingResult) -> Vec<f64> {
    fn each<T: Copy>(values: &[T], number: impl Fn(T) -> f64) -> Vec<f64> {
        values.iter().map(|&value| number(value)).collect()
    }
    match chunk {
        DecodingResult::U8(values) => each(&values, f64::from),
        DecodingResult::U16(values) => each(&values, f64::from),
        DecodingResult::U32(values) => each(&values, f64::from),
        DecodingResult::U64(values) => each(&values, |value| value as f64),
        DecodingResult::I8(values) => each(&values, f64::from),
        DecodingResult::I16(values) => each(&values, f64::from),
        DecodingResult::I32(values) => each(&values, f64::from),
        DecodingResult::I64(values) => each(&values, |value| value as f64),
        DecodingResult::F16(values) => each(&values, f64::from),
        DecodingResult::F32(values) => each(&values, f64::from),
        DecodingResult::F64(values) => values,
    }
}
