//! Rasters that GDAL opens, read window by window.

use std::path::Path;
use std::sync::Once;

use gdal::raster::RasterBand;
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DatasetOptions, DriverManager, GdalOpenFlags};

use super::layout::{self, Layout};
use super::mosaic::{Mosaic, Window};
use super::{ReadError, ReadOptions, crs, units};
use crate::progress::Progress;

/// Formats of elevation data whose drivers read the named file and its plain side files, nothing else. VRT and its
/// like are left out on purpose: they name other files and addresses.
const DRIVERS: [&str; 19] = [
    "AAIGrid",
    "AIG",
    "BAG",
    "BT",
    "DTED",
    "EHdr",
    "ENVI",
    "GRIB",
    "GSAG",
    "GSBG",
    "GTiff",
    "GXF",
    "HFA",
    "JP2OpenJPEG",
    "netCDF",
    "PNG",
    "SRTMHGT",
    "USGSDEM",
    "XYZ",
];
/// Samples read at a time: 32 MiB of f64.
const WINDOW_SAMPLES: usize = 1 << 22;

/// An open raster, band 1.
pub(super) struct GdalFile {
    dataset: Dataset,
    layout: Layout,
    /// Metres = stored value × `scale` + `offset`.
    scale: f64,
    offset: f64,
}

impl GdalFile {
    pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Self, ReadError> {
        prepare_gdal();
        let unreadable = |error| ReadError::gdal(path, error);
        let flags = DatasetOptions {
            open_flags: GdalOpenFlags::GDAL_OF_READONLY | GdalOpenFlags::GDAL_OF_RASTER,
            ..DatasetOptions::default()
        };
        let dataset = Dataset::open_ex(path, flags).map_err(unreadable)?;
        if dataset.raster_count() == 0 {
            return Err(ReadError::unreadable(
                path,
                "it has no raster band, or several variables",
            ));
        }
        let (columns, rows) = dataset.raster_size();
        layout::check_size(path, columns, rows, options.limits)?;
        let band = dataset.rasterband(1).map_err(unreadable)?;
        check_block(path, &band, options)?;
        let (scale, offset) = to_metres(path, &band, &options.progress);
        let layout = layout(path, &dataset, options)?;
        Ok(Self {
            dataset,
            layout,
            scale,
            offset,
        })
    }

    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Copies the file into `mosaic` as its file `index`; returns how many samples were no heights.
    pub(super) fn read_into(&self, mosaic: &mut Mosaic, index: usize, progress: &Progress) -> Result<usize, ReadError> {
        self.read_windows(mosaic, index, progress)
            .map_err(|error| ReadError::gdal(&self.layout.path, error))
    }

    fn read_windows(&self, mosaic: &mut Mosaic, index: usize, progress: &Progress) -> gdal::errors::Result<usize> {
        let band = self.dataset.rasterband(1)?;
        let mask = (!band.mask_flags()?.is_all_valid())
            .then(|| band.open_mask_band())
            .transpose()?;
        let (width, height) = window_size(band.block_size(), band.size());
        let mut wild = 0;
        for top in (0..self.layout.rows).step_by(height) {
            for left in (0..self.layout.columns).step_by(width) {
                let size = (
                    width.min(self.layout.columns - left),
                    height.min(self.layout.rows - top),
                );
                let metres = self.read_metres(&band, mask.as_ref(), (left, top), size)?;
                let window = Window {
                    first: [left, top],
                    columns: size.0,
                    metres: &metres,
                };
                wild += mosaic.write(index, &window);
                progress.advance(metres.len() as u64);
            }
        }
        Ok(wild)
    }

    fn read_metres(
        &self,
        band: &RasterBand,
        mask: Option<&RasterBand>,
        (left, top): (usize, usize),
        size: (usize, usize),
    ) -> gdal::errors::Result<Vec<f64>> {
        let first = (left as isize, top as isize);
        let (_, mut metres) = band.read_as::<f64>(first, size, size, None)?.into_shape_and_vec();
        for value in &mut metres {
            *value = *value * self.scale + self.offset;
        }
        if let Some(mask) = mask {
            let (_, valid) = mask.read_as::<u8>(first, size, size, None)?.into_shape_and_vec();
            for (value, _) in metres.iter_mut().zip(valid).filter(|&(_, valid)| valid == 0) {
                *value = f64::NAN;
            }
        }
        Ok(metres)
    }
}

/// Once a process: GDAL keeps its messages to itself (they come back as errors), and forgets all drivers but ours.
pub(super) fn prepare_gdal() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        gdal::config::set_error_handler(|_, _, _| {});
        DriverManager::prevent_auto_registration();
        DriverManager::register_all();
        let unwanted: Vec<_> = DriverManager::all()
            .filter(|driver| !DRIVERS.contains(&driver.short_name().as_str()))
            .collect();
        unwanted.iter().for_each(DriverManager::deregister_driver);
    });
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

/// Scale and offset from stored values to metres: the band's own, then its unit.
fn to_metres(path: &Path, band: &RasterBand, progress: &Progress) -> (f64, f64) {
    let unit = band.unit();
    let metres = units::metres_in(&unit).unwrap_or_else(|| {
        progress.note(&format!(
            "{}: unit `{unit}` is not known, heights are taken for metres",
            path.display()
        ));
        1.0
    });
    (
        band.scale().unwrap_or(1.0) * metres,
        band.offset().unwrap_or(0.0) * metres,
    )
}

fn layout(path: &Path, dataset: &Dataset, options: &ReadOptions) -> Result<Layout, ReadError> {
    let (columns, rows) = dataset.raster_size();
    let reference = reference(path, dataset, options)?;
    let to_crs = match options.bounds {
        Some(bounds) => layout::from_bounds(bounds, columns, rows)?,
        None => {
            let transform = dataset
                .geo_transform()
                .map_err(|_| ReadError::NoPosition(path.to_owned()))?;
            layout::from_corner_based(transform)
        }
    };
    Layout::new(path, (columns, rows), to_crs, &reference)
}

fn reference(path: &Path, dataset: &Dataset, options: &ReadOptions) -> Result<SpatialRef, ReadError> {
    match &options.crs {
        Some(definition) => crs::from_user(definition),
        None => dataset.spatial_ref().map_err(|_| ReadError::NoCrs(path.to_owned())),
    }
}

/// The largest run of whole blocks that stays within [`WINDOW_SAMPLES`], in whole rows of blocks where these fit.
fn window_size(block: (usize, usize), raster: (usize, usize)) -> (usize, usize) {
    let (block_width, block_height) = (block.0.max(1), block.1.max(1));
    let blocks_across = (WINDOW_SAMPLES / (block_width * block_height)).max(1);
    let width = (blocks_across * block_width).min(raster.0);
    let blocks_down = (WINDOW_SAMPLES / (width * block_height)).max(1);
    (width, (blocks_down * block_height).min(raster.1))
}
