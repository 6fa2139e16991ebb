//! Rasters of heights as GeoPackage (OGC 17-066r1, *Extension for Tiled Gridded Coverage Data*), by GDAL: tiles of metres in single
//! precision, places without ground told by a number that is no height.

use std::path::Path;

use gdal::raster::{Buffer, RasterCreationOptions};
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DriverManager, config};
use glam::DVec2;

use super::ReadError;
use super::drivers::prepare_gdal_to_write;

/// Pixels along a side of a tile.
pub(crate) const TILE: usize = 256;
/// What stands for no ground: as high as nothing is.
const NO_GROUND: f64 = -32_768.0;
/// Whatever the day, the same heights are the same bytes.
const DATE: &str = "2000-01-01T00:00:00.000Z";

/// A raster while it is written.
pub(crate) struct GeoPackage {
    dataset: Dataset,
    size: [usize; 2],
}

/// What a raster is.
pub(crate) struct Coverage<'a> {
    /// Longitude and latitude of the north-west corner.
    pub(crate) corner: DVec2,
    /// Degrees that a pixel is wide and high.
    pub(crate) pixel: DVec2,
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    /// Name of its table.
    pub(crate) name: &'a str,
    /// What it is, in words.
    pub(crate) description: &'a str,
}

impl GeoPackage {
    /// A raster at `path`, without ground so far.
    ///
    /// # Errors
    /// Where GDAL cannot write it.
    pub(crate) fn create(path: &Path, coverage: &Coverage) -> Result<Self, ReadError> {
        prepare_gdal_to_write();
        let create = || {
            config::set_config_option("OGR_CURRENT_DATE", DATE)?;
            let options = RasterCreationOptions::from_iter([
                "TILE_FORMAT=TIFF".to_owned(),
                format!("BLOCKSIZE={TILE}"),
                format!("RASTER_TABLE={}", coverage.name),
                format!("RASTER_DESCRIPTION={}", coverage.description),
                "UOM=m".to_owned(),
            ]);
            let [columns, rows] = coverage.size;
            let driver = DriverManager::get_driver_by_name("GPKG")?;
            let mut dataset = driver.create_with_band_type_with_options::<f32, _>(path, columns, rows, 1, &options)?;
            let (corner, pixel) = (coverage.corner, coverage.pixel);
            dataset.set_spatial_ref(&SpatialRef::from_epsg(4326)?)?;
            dataset.set_geo_transform(&[corner.x, pixel.x, 0.0, corner.y, 0.0, -pixel.y])?;
            let mut band = dataset.rasterband(1)?;
            let set = band.set_no_data_value(Some(NO_GROUND));
            // GDAL 3.6 says that it failed where it did not.
            if band.no_data_value() != Some(NO_GROUND) {
                set?;
            }
            Ok(dataset)
        };
        Ok(Self {
            dataset: create().map_err(|error| ReadError::gdal(path, error))?,
            size: coverage.size,
        })
    }

    /// Writes the metres of a tile, by its column and row, row by row from the north; NaN is no ground.
    ///
    /// # Errors
    /// Where GDAL cannot write it.
    pub(crate) fn write(&self, path: &Path, tile: [usize; 2], metres: Vec<f32>) -> Result<(), ReadError> {
        let [[left, columns], [top, rows]] = tile_pixels(self.size, tile);
        let numbers = metres
            .into_iter()
            .map(|metres| if metres.is_nan() { NO_GROUND as f32 } else { metres });
        let mut buffer = Buffer::new((columns, rows), numbers.collect());
        let mut write = || {
            let window = (left as isize, top as isize);
            self.dataset.rasterband(1)?.write(window, (columns, rows), &mut buffer)
        };
        write().map_err(|error| ReadError::gdal(path, error))
    }

    /// Adds coarser pixels, each the mean of four, up to one tile, and finishes the file.
    ///
    /// # Errors
    /// Where GDAL cannot write it.
    pub(crate) fn finish(mut self, path: &Path) -> Result<(), ReadError> {
        let tiles = self
            .size
            .map(|pixels| pixels.div_ceil(TILE))
            .into_iter()
            .max()
            .unwrap_or(1);
        let overviews: Vec<i32> = (1..=tiles.next_power_of_two().ilog2())
            .map(|halvings| 1 << halvings)
            .collect();
        let mut finish = || {
            if !overviews.is_empty() {
                self.dataset.build_overviews("AVERAGE", &overviews, &[])?;
            }
            self.dataset.flush_cache()
        };
        finish().map_err(|error| ReadError::gdal(path, error))?;
        self.dataset.close().map_err(|error| ReadError::gdal(path, error))
    }
}

/// Of a tile of a raster of a size: along each axis its first pixel, and how many there are.
pub(crate) fn tile_pixels(size: [usize; 2], tile: [usize; 2]) -> [[usize; 2]; 2] {
    [0, 1].map(|axis| [tile[axis] * TILE, TILE.min(size[axis] - tile[axis] * TILE)])
}
