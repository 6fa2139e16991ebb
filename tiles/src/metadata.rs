//! What an archive says of itself: the JSON block of the PMTiles file, and what the server lists.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use crate::outside::Outside;
use crate::water::Water;

/// Name of the format in the metadata of an archive.
pub const FORMAT: &str = "surface-partition-tiles";
/// Version of the archive's layout; the tile format has its own.
pub const VERSION: u32 = 3;

/// An archive's description of itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metadata {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// `geographic-tms`: WGS84 longitude and latitude, two roots, rows from the south.
    pub scheme: String,
    /// West, south, east, north of the data in degrees; east may exceed 180 where data crosses the antimeridian.
    pub bounds: [f64; 4],
    /// Lowest and highest height of any surface, metres: coarse ones go beyond the samples.
    pub heights: [f64; 2],
    /// Coarsest zoom, always 0.
    pub min_zoom: u8,
    /// Zoom of the leaves.
    pub max_zoom: u8,
    /// `surface` where the bound holds at every point of the source's bilinear surface, `samples` where at samples only.
    pub bound: String,
    /// The error asked for at the leaves, metres.
    pub max_error: f64,
    /// What was asked for: the same of other rasters is made by asking for it again.
    pub asked: Asked,
    /// A hash of what all tiles share: lattice, errors, quality, and where the samples lie.
    pub plan: String,
    /// What the tiles were made from.
    pub source: Source,
    /// What is where nothing was measured.
    #[serde(default)]
    pub outside: Outside,
    /// Where there is water.
    #[serde(default, skip_serializing_if = "Water::is_empty")]
    pub water: Water,
    /// Name and version of the program that wrote the archive.
    pub generator: String,
    /// One entry a zoom, from `min_zoom` to `max_zoom`.
    pub zooms: Vec<Zoom>,
}

impl Metadata {
    /// Whether a place, in degrees, is within the bounds of the data.
    #[must_use]
    pub fn covers(&self, longitude: f64, latitude: f64) -> bool {
        let [west, south, east, north] = self.bounds;
        // East exceeds 180° where data cross the antimeridian.
        let is_across = [longitude, longitude + 360.0].iter().any(|x| (west..=east).contains(x));
        is_across && (south..=north).contains(&latitude)
    }

    /// The bounds where longitudes end at ±180: data across the antimeridian are given the whole circle.
    #[must_use]
    pub fn bounds_within_180(&self) -> [f64; 4] {
        let [_, south, east, north] = self.bounds;
        if east > 180.0 {
            [-180.0, south, 180.0, north]
        } else {
            self.bounds
        }
    }

    /// Around the data and all ground beside them whose height is not 0; longitudes may go beyond ±180.
    #[must_use]
    pub fn bounds_with_outside(&self) -> [f64; 4] {
        let [west, south, east, north] = self.bounds;
        let other = self.outside.bounds().unwrap_or(self.bounds);
        [
            west.min(other[0]),
            south.min(other[1]),
            east.max(other[2]),
            north.max(other[3]),
        ]
    }

    /// Error that is certified, in metres, of a zoom's finest surfaces and of the leaves above, which stand for what is below them.
    #[must_use]
    pub fn finest_error(&self, zoom: u8) -> f64 {
        let error_of = |entry: &Zoom| match entry.zoom.cmp(&zoom) {
            Ordering::Less => entry.leaf_error,
            Ordering::Equal => entry.finest_error,
            Ordering::Greater => 0.0,
        };
        self.zooms.iter().map(error_of).fold(0.0, f64::max)
    }

    /// Whether some leaves are above the last zoom.
    #[must_use]
    pub fn has_leaves_above(&self) -> bool {
        self.zooms
            .iter()
            .any(|zoom| zoom.zoom < self.max_zoom && zoom.leaves > 0)
    }
}

/// What was asked for when an archive was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// Largest error of the leaves in metres; none where it was derived from the raster's cells.
    pub max_error: Option<f64>,
    /// How much work went into few triangles: `fast`, `default` or `best`.
    pub quality: String,
    /// Coordinate reference system that was used instead of the rasters' own.
    pub crs: Option<String>,
    /// West, south, east, north in units of it that were used instead of the rasters' own position.
    pub bounds: Option<[f64; 4]>,
    /// What heights were to be above.
    #[serde(default)]
    pub vertical: Vertical,
    /// How samples were read.
    #[serde(default)]
    pub reading: Reading,
    /// What was to be where nothing was measured.
    #[serde(default)]
    pub outside: OutsidePolicy,
}

/// What is to be where nothing was measured; [`Outside`] has the heights of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutsidePolicy {
    /// The ellipsoid.
    #[default]
    Ellipsoid,
    /// The sea level.
    Geoid,
    /// Ground that goes on from the edge of the data.
    Extend,
}

/// How samples are read, where it is not as rasters say of themselves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Metres in a unit of the rasters' heights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<f64>,
    /// Stored values that stand for voids, besides those that rasters declare; where none are given, they are looked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodata: Option<Vec<f64>>,
    /// How colours of pixels are heights; none where the first band is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoding: Option<ColourEncoding>,
    /// Heights in metres of the least and the greatest value that a height map can store.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_range: Option<[f64; 2]>,
    /// Whether the ground is nowhere on the Earth: x and y are metres on a plane, which is laid on the ellipsoid around 0° N, 0° E.
    #[serde(default, skip_serializing_if = "is_false")]
    pub local: bool,
    /// Metres from sample to sample of such ground, across and down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixel_size: Option<[f64; 2]>,
    /// Which reader is used, whatever the file's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reader: Option<RasterReader>,
    /// Whether raw height maps have the most significant byte first.
    #[serde(default, skip_serializing_if = "is_false")]
    pub big_endian: bool,
    /// Whether virtual rasters are read, and the files that they name.
    #[serde(default, skip_serializing_if = "is_false")]
    pub allow_vrt: bool,
    /// Rasters below and around all others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub underlay: Vec<String>,
    /// Metres that these reach beyond the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub around: Option<f64>,
    /// Metres from a joint within which a raster is bent to meet one that counts before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blend: Option<f64>,
    /// Whether rasters count in their order, whatever their cells.
    #[serde(default, skip_serializing_if = "is_false")]
    pub by_order: bool,
    /// A file of polygons of water, within which the surface is level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub water: Option<String>,
    /// A file of polygons on land within which the surface is level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flatten: Option<String>,
    /// A file of lines that the surface keeps as edges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub breaklines: Option<String>,
    /// Whether voids are filled, and how wide in metres they may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill: Option<Fill>,
}

/// Filling of voids.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fill {
    /// Metres that a void may be wide; none where that follows from the raster's cells.
    pub widest: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_false(flag: &bool) -> bool {
    !flag
}

impl Reading {
    /// The same, and what `other` says where this says nothing.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            unit: self.unit.or(other.unit),
            nodata: self.nodata.or(other.nodata),
            encoding: self.encoding.or(other.encoding),
            height_range: self.height_range.or(other.height_range),
            local: self.local || other.local,
            pixel_size: self.pixel_size.or(other.pixel_size),
            reader: self.reader.or(other.reader),
            big_endian: self.big_endian || other.big_endian,
            allow_vrt: self.allow_vrt || other.allow_vrt,
            underlay: if self.underlay.is_empty() {
                other.underlay
            } else {
                self.underlay
            },
            around: self.around.or(other.around),
            blend: self.blend.or(other.blend),
            by_order: self.by_order || other.by_order,
            water: self.water.or(other.water),
            flatten: self.flatten.or(other.flatten),
            breaklines: self.breaklines.or(other.breaklines),
            fill: self.fill.or(other.fill),
        }
    }
}

/// How the three bytes of a pixel's colour are a height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColourEncoding {
    /// Tenths of a metre above −10,000 m.
    Mapbox,
    /// 256ths of a metre above −32,768 m.
    Terrarium,
}

impl ColourEncoding {
    /// Metres of one step, and of the colour black.
    #[must_use]
    pub fn scale_and_offset(self) -> [f64; 2] {
        match self {
            Self::Mapbox => [0.1, -10_000.0],
            Self::Terrarium => [1.0 / 256.0, -32_768.0],
        }
    }
}

/// A reader of rasters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RasterReader {
    /// The library GDAL, which knows most formats.
    Gdal,
    /// One for GeoTIFF alone, which looks at no other file.
    Tiff,
    /// One for OpenEXR.
    Exr,
    /// One for samples of 16 bits without a header.
    Raw,
    /// One for archives of tiles.
    Archive,
}

/// What heights are to be above, and what is used instead of what rasters say of theirs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vertical {
    /// What heights of tiles are above.
    pub heights: HeightsAbove,
    /// Vertical datum of the rasters, instead of what they say.
    pub datum: Option<String>,
    /// File with the grid of its height above the ellipsoid, instead of the one that is known.
    pub geoid: Option<String>,
}

/// What heights of tiles are above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeightsAbove {
    /// What those of the rasters are above.
    #[default]
    Source,
    /// The ellipsoid, where it is known what those of the rasters are above.
    Ellipsoid,
}

/// What the tiles were made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// File names without their folders.
    pub files: Vec<String>,
    /// Name or code of the raster's coordinate reference system.
    pub crs: String,
    /// Vertical datum of the rasters' heights, `unspecified` where nothing says it.
    pub vertical_datum: String,
    /// What the heights of tiles are above; empty in archives whose heights are as the rasters have them.
    #[serde(default)]
    pub heights_above: String,
    /// Grid that was added to make them so, if one was.
    #[serde(default)]
    pub geoid: Option<String>,
    /// Samples from west to east and from north to south.
    pub samples: [usize; 2],
    /// The lowest and the highest of them, in metres above what heights of tiles are above; older archives do not tell.
    #[serde(default)]
    pub heights: Option<[f64; 2]>,
}

impl Source {
    /// Names of the files for clients, which show them as HTML.
    #[must_use]
    pub fn attribution(&self) -> String {
        let files = self.files.join(", ");
        files.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
    }

    /// What the heights of tiles are above.
    #[must_use]
    pub fn tiles_above(&self) -> &str {
        if self.heights_above.is_empty() {
            &self.vertical_datum
        } else {
            &self.heights_above
        }
    }

    /// How heights of the rasters became those of tiles, in words.
    #[must_use]
    pub fn vertical_transformation(&self) -> String {
        match &self.geoid {
            Some(grid) => format!("the height of the geoid above the ellipsoid added, bilinear in {grid}"),
            None => "none".to_owned(),
        }
    }
}

/// The tiles of one zoom.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Zoom {
    /// Which.
    pub zoom: u8,
    /// How many tiles there are.
    pub tiles: usize,
    /// Triangles of their finest surfaces.
    pub triangles: usize,
    /// Largest certified error of their finest surfaces, metres.
    pub finest_error: f64,
    /// Largest certified error of their coarsest surfaces, metres.
    pub coarsest_error: f64,
    /// Largest plan distance in metres between the outline of a coarsest surface and the source's.
    pub outline_error: f64,
    /// How many of the tiles are leaves: no tile is below them, and they stand for all below. Where rasters are coarse there are some
    /// above the last zoom.
    #[serde(default)]
    pub leaves: usize,
    /// Largest certified error of the leaves' finest surfaces, metres.
    #[serde(default)]
    pub leaf_error: f64,
    /// Rectangles of tiles that exist: first x, first y, last x, last y, all of them inclusive.
    pub available: Vec<[u32; 4]>,
}
