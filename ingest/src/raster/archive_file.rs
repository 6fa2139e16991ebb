//! An archive as a raster: its finest surface at samples as far apart as those that it was made from.

use std::ops::Range;
use std::path::{Path, PathBuf};

use gdal::spatial_ref::SpatialRef;
use glam::{DAffine2, DVec2};
use terrain_tiles::archive::Reader as Archive;
use terrain_tiles::ground::Place;

use super::reader::{Found, Reader};
use super::{ReadError, UNSPECIFIED};
use crate::archive_tiles::Grounds;

/// How names of archives end.
pub(super) const ENDING: &str = "pmtiles";

/// Samples in longitude and latitude, rows from the north, over the bounds of an archive.
pub(super) struct ArchiveFile {
    path: PathBuf,
    grounds: Grounds<Box<Archive>>,
    zoom: u8,
    to_degrees: DAffine2,
}

impl ArchiveFile {
    pub(super) fn open(path: &Path) -> Result<Found, ReadError> {
        let unreadable = |error: String| ReadError::unreadable(path, error);
        let archive = Archive::open(path).map_err(|error| unreadable(error.to_string()))?;
        let metadata = archive.metadata().clone();
        let [west, south, east, north] = metadata.bounds;
        let size = metadata.source.samples;
        let cell = DVec2::new(east - west, south - north) / DVec2::new(size[0] as f64, size[1] as f64);
        if !cell.is_finite() || cell.x * cell.y == 0.0 {
            return Err(unreadable("its bounds and samples are not those of ground".to_owned()));
        }
        let to_degrees = DAffine2::from_scale_angle_translation(cell, 0.0, DVec2::new(west, north) + cell / 2.0);
        let above = metadata.source.tiles_above();
        let datum = Some(above).filter(|&above| above != UNSPECIFIED).map(str::to_owned);
        let remark = format!(
            "an archive; its surface is within {:.2} m of what it was made from",
            metadata.finest_error(metadata.max_zoom)
        );
        let reader = Self {
            path: path.to_owned(),
            grounds: Grounds::of(Box::new(archive)),
            zoom: metadata.max_zoom,
            to_degrees,
        };
        let degrees = SpatialRef::from_epsg(4326).map_err(|error| ReadError::gdal(path, error))?;
        Ok(Found {
            crs: Some(degrees),
            to_crs: Some(to_degrees),
            datum,
            remark: Some(remark),
            ..Found::bare(reader, size, 1.0)
        })
    }
}

impl Reader for ArchiveFile {
    fn stored(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError> {
        let place = |column: usize, row: usize| {
            let degrees = self.to_degrees.transform_point2(DVec2::new(column as f64, row as f64));
            Place::turned(degrees.x, degrees.y)
        };
        let places: Vec<Place> = rows
            .flat_map(|row| columns.clone().map(move |column| place(column, row)))
            .collect();
        let heights = self
            .grounds
            .heights(self.zoom, &places)
            .map_err(|error| ReadError::unreadable(&self.path, error))?;
        Ok(heights.into_iter().map(|height| height.unwrap_or(f64::NAN)).collect())
    }
}
