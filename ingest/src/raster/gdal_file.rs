//! Rasters that GDAL opens, read window by window.

use std::ops::Range;
use std::path::Path;

use gdal::raster::RasterBand;
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DatasetOptions, GdalOpenFlags, Metadata};

use super::drivers::prepare_gdal;
use super::layout::Layout;
use super::vertical::HeightReference;
use super::{ReadError, ReadOptions, crs, placement, units};

/// Tags in which files say what their heights are above.
const TAGS: [&str; 2] = ["VERTICAL_DATUM", "vertical_datum"];
/// A raster, band 1: what is known of it before any sample is read. Each window is read through a handle of its own, so
/// that several can be read at once.
pub(super) struct GdalFile {
    layout: Layout,
    /// Samples of a block that is stored as one.
    block: [usize; 2],
    /// Metres = stored value × `scale` + `offset`.
    scale: f64,
    offset: f64,
}

impl GdalFile {
    pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Self, ReadError> {
        prepare_gdal();
        let unreadable = |error| ReadError::gdal(path, error);
        let dataset = open(path).map_err(unreadable)?;
        if dataset.raster_count() == 0 {
            return Err(ReadError::unreadable(
                path,
                "it has no raster band, or several variables",
            ));
        }
        let (columns, rows) = dataset.raster_size();
        placement::check_size(path, columns, rows, options.limits.samples)?;
        let band = dataset.rasterband(1).map_err(unreadable)?;
        check_block(path, &band, options)?;
        let reference = reference(path, &dataset, options)?;
        let mut layout = layout(path, &dataset, &reference, options)?;
        let (scale, offset) = (band.scale().unwrap_or(1.0), band.offset().unwrap_or(0.0));
        let of_crs = of_own_too(&reference, &dataset, crs::vertical_unit);
        let (metres, remarks) = units::of_heights(&band.unit(), of_crs, options.overrides.reading.unit, scale);
        layout.remarks.extend(remarks);
        let (width, height) = band.block_size();
        Ok(Self {
            layout,
            block: [width.max(1), height.max(1)],
            scale: scale * metres,
            offset: offset * metres,
        })
    }

    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    pub(super) fn block(&self) -> [usize; 2] {
        self.block
    }

    /// Metres of a rectangle of samples, row by row; NaN where void.
    pub(super) fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError> {
        self.read_metres(columns, rows)
            .map_err(|error| ReadError::gdal(&self.layout.path, error))
    }

    fn read_metres(&self, columns: Range<usize>, rows: Range<usize>) -> gdal::errors::Result<Vec<f64>> {
        let dataset = open(&self.layout.path)?;
        let band = dataset.rasterband(1)?;
        let (first, size) = (
            (columns.start as isize, rows.start as isize),
            (columns.len(), rows.len()),
        );
        let (_, mut metres) = band.read_as::<f64>(first, size, size, None)?.into_shape_and_vec();
        for value in &mut metres {
            *value = *value * self.scale + self.offset;
        }
        if !band.mask_flags()?.is_all_valid() {
            let mask = band.open_mask_band()?.read_as::<u8>(first, size, size, None)?;
            let (_, valid) = mask.into_shape_and_vec();
            for (value, _) in metres.iter_mut().zip(valid).filter(|&(_, valid)| valid == 0) {
                *value = f64::NAN;
            }
        }
        Ok(metres)
    }
}

fn open(path: &Path) -> gdal::errors::Result<Dataset> {
    let flags = DatasetOptions {
        open_flags: GdalOpenFlags::GDAL_OF_READONLY | GdalOpenFlags::GDAL_OF_RASTER,
        ..DatasetOptions::default()
    };
    Dataset::open_ex(path, flags)
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

fn layout(path: &Path, dataset: &Dataset, reference: &SpatialRef, options: &ReadOptions) -> Result<Layout, ReadError> {
    let (columns, rows) = dataset.raster_size();
    let to_crs = match options.overrides.bounds {
        Some(bounds) => placement::from_bounds(bounds, columns, rows)?,
        None => {
            let transform = dataset
                .geo_transform()
                .map_err(|_| ReadError::NoPosition(path.to_owned()))?;
            placement::from_corner_based(transform)
        }
    };
    let heights = HeightReference::of_file(
        path,
        of_own_too(reference, dataset, crs::vertical_datum),
        TAGS.iter().find_map(|tag| dataset.metadata_item(tag, "")),
        &options.overrides.vertical,
    )?;
    Layout::new(path, (columns, rows), to_crs, reference, heights)
}

/// What the reference system that is used says of heights, or else the file's own: what a user says of places need not say anything
/// of heights.
fn of_own_too<T>(used: &SpatialRef, dataset: &Dataset, of: impl Fn(&SpatialRef) -> Option<T>) -> Option<T> {
    of(used).or_else(|| dataset.spatial_ref().ok().as_ref().and_then(of))
}

fn reference(path: &Path, dataset: &Dataset, options: &ReadOptions) -> Result<SpatialRef, ReadError> {
    match &options.overrides.crs {
        Some(definition) => crs::from_user(definition),
        None => dataset.spatial_ref().map_err(|_| ReadError::NoCrs(path.to_owned())),
    }
}
