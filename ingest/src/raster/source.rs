//! A file, opened by the reader for it. Where its samples are and what makes metres of them is settled here, for all readers alike.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use gdal::spatial_ref::SpatialRef;
use terrain_tiles::metadata::{RasterReader, Reading, Vertical};

use super::archive_file::{self, ArchiveFile};
use super::exr_file::ExrFile;
use super::gdal_file::GdalFile;
use super::layout::Layout;
use super::raw_file::RawFile;
use super::reader::{Found, Reader};
use super::tiff_file::TiffFile;
use super::undeclared::{Looked, Values, Voids};
use super::vertical::HeightReference;
use super::{ReadError, ReadOptions, crs, placement, units};
use crate::samples::Overrides;

/// An open file.
pub(super) struct Source {
    layout: Layout,
    block: [usize; 2],
    reader: Box<dyn Reader>,
    voids: Voids,
    /// Metres = stored value × `scale` + `offset`.
    scale: f64,
    offset: f64,
}

impl Source {
    pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Self, ReadError> {
        check_name(path)?;
        let reader = reader_of(path, &options.overrides.reading);
        let overrides = if reader == RasterReader::Archive {
            &of_archives(&options.overrides)
        } else {
            &options.overrides
        };
        let reading = &overrides.reading;
        if reading.encoding.is_some() && reader != RasterReader::Gdal {
            return Err(ReadError::unreadable(path, "heights in colours are read by GDAL alone"));
        }
        let found = match reader {
            RasterReader::Gdal => GdalFile::open(path, options)?,
            RasterReader::Tiff => TiffFile::open(path, options)?,
            RasterReader::Exr => ExrFile::open(path)?,
            RasterReader::Raw => RawFile::open(path, reading.big_endian)?,
            RasterReader::Archive => ArchiveFile::open(path)?,
        };
        let [columns, rows] = found.size;
        placement::check_size(path, columns, rows, options.limits.samples)?;
        let said = overrides.crs.as_deref().map(crs::from_user).transpose()?;
        let reference = said.as_ref().or(found.crs.as_ref());
        let mut layout = layout(path, &found, reference, overrides)?;
        layout.remarks.extend(found.remark.clone());
        let (scale, offset) = to_metres(&mut layout, &found, reference, reading);
        Ok(Self {
            layout,
            block: found.block,
            reader: found.reader,
            voids: Voids::new(reading.nodata.clone(), &options.progress),
            scale,
            offset,
        })
    }

    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Samples of a block that is stored as one, across and down.
    pub(super) fn block(&self) -> [usize; 2] {
        self.block
    }

    /// Metres of a rectangle of samples, row by row; NaN where void.
    pub(super) fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError> {
        let voids = self.voids()?;
        let mut values = self.reader.stored(columns, rows)?;
        for value in &mut values {
            *value = if voids.contain(*value) {
                f64::NAN
            } else {
                *value * self.scale + self.offset
            };
        }
        Ok(values)
    }

    /// The stored values that stand for voids, besides those that the reader knows.
    fn voids(&self) -> Result<Arc<Values>, ReadError> {
        let Layout {
            path, columns, rows, ..
        } = &self.layout;
        let file = Looked {
            path,
            reader: self.reader.as_ref(),
            size: [*columns, *rows],
            block: self.block,
        };
        self.voids.values(&file, self.scale, self.offset)
    }
}

/// An archive says all of itself: what a user says is of the rasters beside it.
fn of_archives(asked: &Overrides) -> Overrides {
    let heights = asked.vertical.heights;
    Overrides {
        vertical: Vertical {
            heights,
            ..Vertical::default()
        },
        ..Overrides::default()
    }
}

/// The reader that a user names, or the one for the file's kind.
fn reader_of(path: &Path, reading: &Reading) -> RasterReader {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if extension == archive_file::ENDING {
        return RasterReader::Archive;
    }
    reading.reader.unwrap_or_else(|| match extension.to_str() {
        Some("exr") => RasterReader::Exr,
        Some("r16" | "raw") => RasterReader::Raw,
        _ => RasterReader::Gdal,
    })
}

/// GDAL takes names for more than files: `/vsicurl/http://…` fetches, `<VRTDataset>…` reads other files. Only names of
/// plain files pass.
fn check_name(path: &Path) -> Result<(), ReadError> {
    let name = path.to_string_lossy();
    if name.contains("/vsi") || name.contains('<') {
        return Err(ReadError::Refused(path.to_owned()));
    }
    let metadata = std::fs::metadata(path).map_err(|error| ReadError::unreadable(path, error))?;
    if metadata.is_file() {
        Ok(())
    } else {
        Err(ReadError::unreadable(path, "it is not a file"))
    }
}

fn layout(
    path: &Path,
    found: &Found,
    reference: Option<&SpatialRef>,
    overrides: &Overrides,
) -> Result<Layout, ReadError> {
    let [columns, rows] = found.size;
    let to_crs = match (overrides.reading.pixel_size, overrides.bounds) {
        (Some(pixel), _) => Some(placement::from_pixel_size(pixel, rows)),
        (None, Some(bounds)) => Some(placement::from_bounds(bounds, columns, rows)?),
        (None, None) => found.to_crs,
    };
    let to_crs = to_crs.ok_or_else(|| ReadError::NoPosition(path.to_owned()));
    if overrides.reading.local {
        let heights = HeightReference::of_file(path, None, None, &overrides.vertical)?;
        return Ok(Layout::local(path, found.size, to_crs?, heights));
    }
    let reference = reference.ok_or_else(|| ReadError::NoCrs(path.to_owned()))?;
    let of_crs = of_either(reference, found, crs::vertical_datum);
    let heights = HeightReference::of_file(path, of_crs, found.datum.clone(), &overrides.vertical)?;
    Layout::new(path, found.size, to_crs?, reference, heights)
}

/// Scale and offset from stored values to metres.
fn to_metres(layout: &mut Layout, found: &Found, reference: Option<&SpatialRef>, reading: &Reading) -> (f64, f64) {
    if let Some([lowest, highest]) = reading.height_range {
        return ((highest - lowest) / found.greatest, lowest);
    }
    let of_crs = reference.and_then(|reference| of_either(reference, found, crs::vertical_unit));
    let (metres, remarks) = units::of_heights(&found.unit, of_crs, reading.unit, found.scale);
    layout.remarks.extend(remarks);
    (found.scale * metres, found.offset * metres)
}

/// What the reference system that is used says of heights, or else the file's own: what a user says of places need not say anything
/// of heights.
fn of_either<T>(used: &SpatialRef, found: &Found, of: impl Fn(&SpatialRef) -> Option<T>) -> Option<T> {
    of(used).or_else(|| found.crs.as_ref().and_then(of))
}
