//! Rasters that GDAL opens, read window by window.

use std::ops::Range;
use std::path::{Path, PathBuf};

use gdal::raster::{ColorInterpretation, GdalDataType, RasterBand};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags, Metadata};

use super::drivers::{DRIVERS, VIRTUAL, prepare_gdal};
use super::reader::{Found, Reader};
use super::zip::in_zip;
use super::{ReadError, ReadOptions, placement};

/// Tags in which files say what their heights are above.
const TAGS: [&str; 2] = ["VERTICAL_DATUM", "vertical_datum"];

/// Rows in the middle of a picture that tell whether it is coloured.
const LOOKED_AT: usize = 64;

/// A raster, band 1 or the colours of three. Each window is read through a handle of its own, so that several can be read at once.
pub(super) struct GdalFile {
    path: PathBuf,
    /// What GDAL opens: the same, or what is in it if it is an archive.
    opened: PathBuf,
    allow_virtual: bool,
    has_heights_in_colours: bool,
}

impl GdalFile {
    pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Found, ReadError> {
        let (allow_virtual, encoding) = (options.overrides.reading.allow_vrt, options.overrides.reading.encoding);
        prepare_gdal(allow_virtual);
        let is_virtual = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("vrt"));
        if is_virtual && !allow_virtual {
            let reason = "virtual rasters name other files, which are read only if --allow-vrt is given";
            return Err(ReadError::unreadable(path, reason));
        }
        let unreadable = |error| ReadError::gdal(path, error);
        let reader = Self {
            path: path.to_owned(),
            opened: in_zip(path)?,
            allow_virtual,
            has_heights_in_colours: encoding.is_some(),
        };
        let dataset = reader.dataset().map_err(unreadable)?;
        if dataset.raster_count() == 0 {
            return Err(ReadError::unreadable(
                path,
                "it has no raster band, or several variables",
            ));
        }
        let (columns, rows) = dataset.raster_size();
        let band = dataset.rasterband(1).map_err(unreadable)?;
        check_block(path, &band, options)?;
        let (width, height) = band.block_size();
        match encoding {
            Some(_) if !has_colours(&dataset).map_err(unreadable)? => {
                return Err(ReadError::unreadable(
                    path,
                    "it has no red, green and blue bytes, which --encoding is of",
                ));
            }
            None if is_coloured(&dataset).map_err(unreadable)? => {
                let reason =
                    "its pixels are coloured; if the colours are heights, say how by --encoding mapbox or terrarium";
                return Err(ReadError::unreadable(path, reason));
            }
            _ => {}
        }
        let [scale, offset] = match encoding {
            Some(encoding) => encoding.scale_and_offset(),
            None => [band.scale().unwrap_or(1.0), band.offset().unwrap_or(0.0)],
        };
        let greatest = greatest(band.band_type());
        Ok(Found {
            size: [columns, rows],
            block: [width.max(1), height.max(1)],
            crs: dataset.spatial_ref().ok(),
            to_crs: dataset.geo_transform().ok().map(placement::from_corner_based),
            remark: None,
            datum: TAGS.iter().find_map(|tag| dataset.metadata_item(tag, "")),
            scale,
            offset,
            unit: band.unit(),
            greatest,
            reader: Box::new(reader),
        })
    }

    fn dataset(&self) -> gdal::errors::Result<Dataset> {
        let drivers: Vec<&str> = DRIVERS
            .into_iter()
            .chain(self.allow_virtual.then_some(VIRTUAL))
            .collect();
        let flags = DatasetOptions {
            open_flags: GdalOpenFlags::GDAL_OF_READONLY | GdalOpenFlags::GDAL_OF_RASTER,
            allowed_drivers: Some(&drivers),
            ..DatasetOptions::default()
        };
        Dataset::open_ex(&self.opened, flags)
    }

    fn values(&self, columns: &Range<usize>, rows: &Range<usize>) -> gdal::errors::Result<Vec<f64>> {
        let dataset = self.dataset()?;
        let band = dataset.rasterband(1)?;
        let (first, size) = (
            (columns.start as isize, rows.start as isize),
            (columns.len(), rows.len()),
        );
        let mut values = if self.has_heights_in_colours {
            let [red, green, blue] = colours(&dataset, first, size)?;
            let value = |((red, green), blue): ((u8, u8), u8)| f64::from(u32::from_be_bytes([0, red, green, blue]));
            let values = red.into_iter().zip(green).zip(blue).map(value);
            values
                .map(|value| if value == 0.0 { f64::NAN } else { value })
                .collect()
        } else {
            band.read_as::<f64>(first, size, size, None)?.into_shape_and_vec().1
        };
        if !band.mask_flags()?.is_all_valid() {
            let mask = band.open_mask_band()?.read_as::<u8>(first, size, size, None)?;
            let (_, valid) = mask.into_shape_and_vec();
            for (value, _) in values.iter_mut().zip(valid).filter(|&(_, valid)| valid == 0) {
                *value = f64::NAN;
            }
        }
        Ok(values)
    }
}

impl Reader for GdalFile {
    fn stored(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError> {
        let values = self.values(&columns, &rows);
        values.map_err(|error| ReadError::gdal(&self.path, error))
    }
}

/// Whether the first three bands are red, green and blue, in bytes.
fn has_colours(dataset: &Dataset) -> gdal::errors::Result<bool> {
    let colours = [
        ColorInterpretation::RedBand,
        ColorInterpretation::GreenBand,
        ColorInterpretation::BlueBand,
    ];
    if dataset.raster_count() < colours.len() {
        return Ok(false);
    }
    for (index, colour) in colours.into_iter().enumerate() {
        let band = dataset.rasterband(index + 1)?;
        if band.band_type() != GdalDataType::UInt8 || band.color_interpretation() != colour {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether red, green and blue differ: a picture, or heights in colours, but no grey height map.
fn is_coloured(dataset: &Dataset) -> gdal::errors::Result<bool> {
    if !has_colours(dataset)? {
        return Ok(false);
    }
    let (columns, rows) = dataset.raster_size();
    let count = rows.min(LOOKED_AT);
    let first = (0, ((rows - count) / 2) as isize);
    let [red, green, blue] = colours(dataset, first, (columns, count))?;
    Ok(red != green || green != blue)
}

/// Red, green and blue of a rectangle.
fn colours(dataset: &Dataset, first: (isize, isize), size: (usize, usize)) -> gdal::errors::Result<[Vec<u8>; 3]> {
    let mut colours = [const { Vec::new() }; 3];
    for (index, values) in colours.iter_mut().enumerate() {
        let band = dataset.rasterband(index + 1)?;
        *values = band.read_as::<u8>(first, size, size, None)?.into_shape_and_vec().1;
    }
    Ok(colours)
}

/// The greatest value of a type, 1 for numbers with a fraction.
fn greatest(kind: GdalDataType) -> f64 {
    match f64::from(kind.bits()) {
        _ if kind.is_floating() => 1.0,
        bits if kind.is_signed() => (bits - 1.0).exp2() - 1.0,
        bits => bits.exp2() - 1.0,
    }
}

fn check_block(path: &Path, band: &RasterBand, options: &ReadOptions) -> Result<(), ReadError> {
    let (width, height) = band.block_size();
    let bytes = width
        .saturating_mul(height)
        .saturating_mul(usize::from(band.band_type().bits()) / 8);
    if bytes > options.limits.block_bytes {
        return Err(ReadError::TooLarge {
            path: path.to_owned(),
            what: format!("blocks of {width} × {height} samples, {bytes} bytes"),
            limit: options.limits.block_bytes,
        });
    }
    Ok(())
}
