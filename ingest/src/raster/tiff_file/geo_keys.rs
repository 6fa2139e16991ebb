//! What a GeoTIFF says of places: its keys (OGC 19-008r4, annex B) and the tags that tie samples to coordinates.

use std::io::{Read, Seek};
use std::path::Path;

use gdal::spatial_ref::SpatialRef;
use glam::{DAffine2, DMat2, DVec2};
use tiff::decoder::Decoder;
use tiff::tags::Tag;

use super::super::{ReadError, crs};

const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC_CRS: u16 = 2048;
const PROJECTED_CRS: u16 = 3072;
const LINEAR_UNIT: u16 = 3076;
const VERTICAL_CRS: u16 = 4096;
const VERTICAL_UNIT: u16 = 4099;
/// Value of [`RASTER_TYPE`] for samples that are at the points that are tied.
const PIXEL_IS_POINT: u16 = 2;
/// Values of keys from here on are made up by the file, in other keys.
const USER_DEFINED: u16 = 32_767;

pub(super) struct GeoKeys {
    /// Keys and their values, of those that have one short number.
    numbers: Vec<(u16, u16)>,
    scale: Option<Vec<f64>>,
    ties: Option<Vec<f64>>,
    matrix: Option<Vec<f64>>,
}

impl GeoKeys {
    /// None where the file has no such keys.
    pub(super) fn read(decoder: &mut Decoder<impl Read + Seek>) -> Option<Self> {
        let directory = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).ok();
        let mut floats = |tag: Tag| decoder.get_tag_f64_vec(tag).ok();
        let (scale, ties) = (floats(Tag::ModelPixelScaleTag), floats(Tag::ModelTiepointTag));
        let matrix = floats(Tag::ModelTransformationTag);
        let keys = directory.as_deref().unwrap_or_default().chunks_exact(4).skip(1);
        let numbers = keys.filter(|key| key[1] == 0).map(|key| (key[0], key[3])).collect();
        (directory.is_some() || scale.is_some() || matrix.is_some()).then_some(Self {
            numbers,
            scale,
            ties,
            matrix,
        })
    }

    fn number(&self, wanted: u16) -> Option<u16> {
        self.numbers
            .iter()
            .find(|&&(key, _)| key == wanted)
            .map(|&(_, value)| value)
    }

    /// The reference system by its code; none where there is none.
    ///
    /// # Errors
    /// Where the file makes one up.
    pub(super) fn reference(&self, path: &Path) -> Result<Option<SpatialRef>, ReadError> {
        let Some(code) = self.number(PROJECTED_CRS).or_else(|| self.number(GEOGRAPHIC_CRS)) else {
            return Ok(None);
        };
        if code >= USER_DEFINED {
            let reason =
                "its coordinate reference system has no EPSG code; name it by --crs, or let GDAL read the file";
            return Err(ReadError::unreadable(path, reason));
        }
        let reference = crs::from_user(&format!("EPSG:{code}"))?;
        let unit = self.number(LINEAR_UNIT).filter(|_| reference.is_projected());
        let is_same =
            |unit: u16| metres(unit).is_some_and(|metres| (reference.linear_units() / metres - 1.0).abs() < 1e-9);
        if unit.is_some_and(|unit| !is_same(unit)) {
            let reason =
                "its unit is not that of its coordinate reference system; name one by --crs, or let GDAL read the file";
            return Err(ReadError::unreadable(path, reason));
        }
        let vertical = self
            .number(VERTICAL_CRS)
            .filter(|&code| 0 < code && code < USER_DEFINED);
        let vertical = vertical.map(|code| format!("+{code}")).unwrap_or_default();
        crs::from_user(&format!("EPSG:{code}{vertical}")).map(Some)
    }

    /// From columns and rows, integers at samples.
    pub(super) fn to_crs(&self) -> Option<DAffine2> {
        let is_point = self.number(RASTER_TYPE) == Some(PIXEL_IS_POINT);
        let to_centre = DAffine2::from_translation(DVec2::splat(if is_point { 0.0 } else { 0.5 }));
        let of_corner = match (self.matrix.as_deref(), self.scale.as_deref(), self.ties.as_deref()) {
            (Some(&[a, b, _, x, c, d, _, y, ..]), ..) => {
                DAffine2::from_mat2_translation(DMat2::from_cols(DVec2::new(a, c), DVec2::new(b, d)), DVec2::new(x, y))
            }
            (None, Some(&[across, down, ..]), Some(&[column, row, _, x, y, ..])) => {
                let matrix = DMat2::from_diagonal(DVec2::new(across, -down));
                let first = DVec2::new(x, y) - matrix * DVec2::new(column, row);
                DAffine2::from_mat2_translation(matrix, first)
            }
            _ => return None,
        };
        Some(of_corner * to_centre)
    }

    /// Unit of heights by its code.
    pub(super) fn unit(&self) -> Option<String> {
        let name = match self.number(VERTICAL_UNIT)? {
            9001 => "metre",
            9002 => "foot",
            9003 => "us survey foot",
            _ => return None,
        };
        Some(name.to_owned())
    }
}

/// Metres in a unit of length by its code.
fn metres(code: u16) -> Option<f64> {
    match code {
        9001 => Some(1.0),
        9002 => Some(0.3048),
        9003 => Some(1200.0 / 3937.0),
        _ => None,
    }
}
