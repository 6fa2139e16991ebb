//! How rasters are read.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use terrain_tiles::metadata::{ColourEncoding, HeightsAbove, RasterReader};

use super::values::{Values, bounds, not_negative, number, pixel_size, positive, unit, values};

/// How rasters are read, and for those that do not say where they are, or wrongly.
#[derive(Args)]
pub(crate) struct RasterArgs {
    /// Coordinate reference system to use instead of the raster's own: EPSG:2056, WKT or a PROJ string.
    #[arg(long, value_name = "CRS")]
    pub(crate) crs: Option<String>,
    /// Outer edges of the raster's pixels, in units of the CRS, to use instead of the raster's own position.
    #[arg(long, value_name = "WEST,SOUTH,EAST,NORTH", value_parser = bounds, allow_hyphen_values = true)]
    pub(crate) bounds: Option<[f64; 4]>,
    /// The ground is nowhere on the Earth, as that of a game: x and y are metres on a plane. Tiles show it around 0° N, 0° E, where
    /// the plane touches the ellipsoid, at heights above this.
    #[arg(long, conflicts_with_all = ["crs", "vertical", "geoid", "heights"])]
    pub(crate) local: bool,
    /// Metres from sample to sample of such ground, one number or X,Y, as for height maps, which have no position: x and y are then
    /// counted from the last row's first sample.
    #[arg(long, value_name = "METRES", value_parser = pixel_size, conflicts_with_all = ["crs", "bounds", "vertical", "geoid", "heights"])]
    pub(crate) pixel_size: Option<[f64; 2]>,
    /// What the rasters' heights are above, instead of what they say: egm96, egm2008, egm84, navd88, ellipsoid or an EPSG code. If
    /// not given: their coordinate reference system, their tags, or the product that their names tell.
    #[arg(long, value_name = "DATUM")]
    pub(crate) vertical: Option<String>,
    /// Grid of the geoid's height above the ellipsoid: a file GTX, GeoTIFF or PGM (GeographicLib). If not given, the one that PROJ
    /// keeps for the datum.
    #[arg(long, value_name = "FILE")]
    pub(crate) geoid: Option<PathBuf>,
    /// Unit of the rasters' heights, instead of what they say: metre, decimetre, centimetre, foot, us-foot, or so many metres.
    #[arg(long, value_name = "UNIT", value_parser = unit, allow_negative_numbers = true)]
    pub(crate) unit: Option<f64>,
    /// Value, or values with commas between them, that stand for voids, as they are stored in the rasters, besides those that these
    /// declare; `none` if there are none. If not given, usual ones as -32768 or -9999 are voids where they are far from all other
    /// values, and a note says so.
    #[arg(long, value_name = "VALUE", value_parser = values, allow_negative_numbers = true, allow_hyphen_values = true)]
    pub(crate) nodata: Option<Values>,
    /// How colours of pixels are heights, as in tiles for web maps; if not given, heights are in the first band.
    #[arg(long, value_enum, conflicts_with = "height_range")]
    pub(crate) encoding: Option<EncodingName>,
    /// Heights in metres of the least and the greatest value that a height map can store: 0 and 65535 for 16 bits, 0 and 1 for
    /// numbers with a fraction.
    #[arg(long, value_names = ["MIN", "MAX"], num_args = 2, value_parser = number, allow_negative_numbers = true)]
    pub(crate) height_range: Option<Vec<f64>>,
    /// Which byte comes first in raw height maps (.r16, .raw: 16 bits a sample, as many rows as columns).
    #[arg(long, value_enum, default_value = "little")]
    pub(crate) byte_order: ByteOrder,
    /// Which reader to use, whatever the file's name: GDAL; tiff and exr without GDAL, which look at no other file.
    #[arg(long, value_enum)]
    pub(crate) reader: Option<ReaderName>,
    /// Read virtual rasters (.vrt), and every file and address that they name.
    #[arg(long)]
    pub(crate) allow_vrt: bool,
    /// Raster, or archive that this program made, below and around all others, where these have no height; several are asked in their
    /// order. An archive's surface is taken where its samples were.
    #[arg(long, value_name = "DEM", num_args = 1..)]
    pub(crate) underlay: Vec<PathBuf>,
    /// How far underlays reach beyond the other rasters; if not given, by half of their width and height on each side.
    #[arg(long, value_name = "METRES", requires = "underlay", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) around: Option<f64>,
    /// How far from a joint a raster is bent to meet one that counts before it where both differ, 0 for not at all; if not given,
    /// five of its cells, or a hundred of the finest raster's if that is less.
    #[arg(long, value_name = "METRES", value_parser = not_negative, allow_negative_numbers = true)]
    pub(crate) blend: Option<f64>,
    /// Which raster counts where several have a height.
    #[arg(long, value_enum, default_value = "resolution")]
    pub(crate) priority: Priority,
    /// What becomes of voids that no raster has a height for.
    #[arg(long, value_enum, default_value = "hole")]
    pub(crate) voids: VoidPolicy,
    /// The widest void that --voids fill fills; if not given, forty cells of the finest raster.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) fill_width: Option<f64>,
    /// Polygons of water (GeoJSON, Shapefile, FlatGeobuf, GeoPackage): the surface is level within each, at the median of the samples
    /// inside, and clients are told where it is.
    #[arg(long, value_name = "FILE")]
    pub(crate) water: Option<PathBuf>,
    /// Polygons of the same kinds within which the surface is level, but no water: runways, pitches.
    #[arg(long, value_name = "FILE")]
    pub(crate) flatten: Option<PathBuf>,
    /// What heights are to be above: the ellipsoid, as globes need them, or as they are in the rasters. Tiles are above the
    /// ellipsoid where it is known what the rasters' heights are above; meshes have the rasters' heights; verify does as the archive
    /// says.
    #[arg(long, value_enum)]
    pub(crate) heights: Option<Heights>,
}

/// Which byte of a number comes first.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ByteOrder {
    /// The least significant one.
    Little,
    /// The most significant one.
    Big,
}

/// How colours are heights.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum EncodingName {
    /// −10,000 m + (65,536 R + 256 G + B) / 10; black is void.
    Mapbox,
    /// 256 R + G + B / 256 − 32,768 m; black is void.
    Terrarium,
}

impl From<EncodingName> for ColourEncoding {
    fn from(name: EncodingName) -> Self {
        match name {
            EncodingName::Mapbox => Self::Mapbox,
            EncodingName::Terrarium => Self::Terrarium,
        }
    }
}

/// Who reads rasters.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ReaderName {
    /// The library GDAL: most formats.
    Gdal,
    /// GeoTIFF alone.
    Tiff,
    /// OpenEXR alone.
    Exr,
}

impl From<ReaderName> for RasterReader {
    fn from(name: ReaderName) -> Self {
        match name {
            ReaderName::Gdal => Self::Gdal,
            ReaderName::Tiff => Self::Tiff,
            ReaderName::Exr => Self::Exr,
        }
    }
}

/// Which raster counts.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Priority {
    /// The one with the finest cells, of equally fine ones the first.
    Resolution,
    /// The first.
    Order,
}

/// What becomes of voids.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum VoidPolicy {
    /// They stay holes.
    Hole,
    /// They are filled, smoothly from their rims; outer rims stay where they are.
    Fill,
}

/// What heights are above.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Heights {
    /// The WGS 84 ellipsoid.
    Ellipsoid,
    /// What those of the rasters are above.
    Source,
}

impl From<Heights> for HeightsAbove {
    fn from(heights: Heights) -> Self {
        match heights {
            Heights::Ellipsoid => Self::Ellipsoid,
            Heights::Source => Self::Source,
        }
    }
}
