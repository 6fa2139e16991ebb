//! The options of packs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use terrain_ingest::pack::{Format, flightgear, simulator};
use terrain_tiles::formats::three_d_tiles::Packing;
use terrain_tiles::raster_dem::image::Encoding;
use terrain_tiles::raster_dem::{self, RasterForm, SIZES};

use super::run::RunArgs;
use super::values::{bounds, place, positive, posts};

const PACK_EXAMPLES: &str = "\
Examples:
  terrain-ingest pack alps.pmtiles --format folder -o alps                        for CesiumJS, from any web server
  terrain-ingest pack alps.pmtiles --format 3d-tiles --bbox 7,45,8,46 -o valais
  terrain-ingest pack alps.pmtiles --format 3tz --max-zoom 10 -o coarse.3tz
  terrain-ingest pack alps.pmtiles --format 3tz --packing meshopt -o small.3tz
  terrain-ingest pack alps.pmtiles --format mbtiles-qm -o alps.mbtiles
  terrain-ingest pack alps.pmtiles --format pmtiles-qm -o alps-qm.pmtiles
  terrain-ingest pack alps.pmtiles --format terrarium -o alps-terrarium.pmtiles            for MapLibre
  terrain-ingest pack alps.pmtiles --format folder --max-error 20 -o alps-20m
  terrain-ingest pack alps.pmtiles --format folder --polygon park.geojson -o park
  terrain-ingest pack alps.pmtiles --format folder --since monday -o changes && terrain-ingest apply monday changes -o tuesday
  terrain-ingest pack alps.pmtiles --format sim --bbox 7.6,45.9,7.8,46.1 -o zermatt    for Gazebo, MuJoCo, Isaac Sim, PyBullet
  terrain-ingest pack alps.pmtiles --format sim --bbox 7,45,8,46 --size 2049 --spacing 10 --origin 7.66,45.98 -o valais
  terrain-ingest pack alps.pmtiles --format ardupilot --spacing 30 -o APM/TERRAIN      for the card of an autopilot
  terrain-ingest pack alps.pmtiles --format btg -o Scenery/Alps                        for FlightGear
  terrain-ingest pack alps.pmtiles --format gpkg -o alps.gpkg                          for QGIS and whoever has GDAL

With --format sim, everything is in metres east, north and up of the origin, and the Earth curves away below:
  meshes/*.glb, *.obj, *.usda        triangles to collide with, tile by tile, without a gap between tiles
  heightmaps/*.png, *.r16            16 bits, one scale for all; *.tif, *.exr metres; *.bin for MuJoCo
  meshes.sdf, heightmaps.sdf, mujoco.xml, terrain.usda    worlds that have them in place
  manifest.json                      origin, datum, scale, how far each product is from the source, checksums
All of it: docs/formats/packs.md.";

/// A pack.
///
/// A tile is in it as terrain-server would send it, its normals made with all tiles around it; whatever part is packed, it is the
/// same. Any web server can serve the folder.
#[derive(Args)]
#[command(after_help = PACK_EXAMPLES)]
pub(crate) struct PackArgs {
    /// The archive.
    #[arg(value_name = "OUT.pmtiles")]
    pub(crate) archive: PathBuf,
    /// Which files.
    #[arg(long, value_enum)]
    pub(crate) format: PackFormat,
    /// Tiles that meet this box in degrees, and those above them; all if not given. East exceeds 180 across the antimeridian.
    #[arg(long, value_name = "WEST,SOUTH,EAST,NORTH", value_parser = bounds, allow_hyphen_values = true)]
    pub(crate) bbox: Option<[f64; 4]>,
    /// Tiles that touch a polygon of this file: GeoJSON, Shapefile, FlatGeobuf or GeoPackage, in any coordinate reference system.
    #[arg(long, value_name = "FILE")]
    pub(crate) polygon: Option<PathBuf>,
    /// Write only what changed since this older pack, for folder, 3d-tiles, sim, ardupilot and btg: a folder with those files and a list of all;
    /// `terrain-ingest apply` makes the pack of it.
    #[arg(long, value_name = "OLD")]
    pub(crate) since: Option<PathBuf>,
    /// The finest zoom, for terrarium and mapbox of Web Mercator; all if not given.
    #[arg(long, value_name = "ZOOM")]
    pub(crate) max_zoom: Option<u8>,
    /// Stop at the first zoom whose certified error is within so many metres; for terrarium and mapbox rounding included.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) max_error: Option<f64>,
    /// For terrarium and mapbox: pixels along a side of a tile.
    #[arg(long, value_name = "PIXELS", value_enum, default_value = "512")]
    pub(crate) tile_size: TileSize,
    /// For terrarium and mapbox: what tiles are.
    #[arg(long, value_enum, default_value = "png")]
    pub(crate) image: Image,
    /// For 3d-tiles and 3tz: how numbers are kept; meshopt takes a quarter of the bytes and errs by a little more.
    #[arg(long, value_enum, default_value = "plain")]
    pub(crate) packing: PackingChoice,
    /// For sim: longitude and latitude of the point that metres are counted from; the middle if not given.
    #[arg(long, value_name = "LON,LAT", value_parser = place, allow_hyphen_values = true)]
    pub(crate) origin: Option<[f64; 2]>,
    /// For sim: posts along a side of a heightmap, a power of two and one: 257, 513, 1025 … If not given, the least that makes do
    /// with one heightmap, or several of 1025.
    #[arg(long, value_name = "POSTS", value_parser = posts)]
    pub(crate) size: Option<u32>,
    /// For sim: metres from post to post, at most; about those of the source, twice that a zoom above its finest, if not given. For
    /// ardupilot: metres from post to post, those of the autopilot's TERRAIN_SPACING, 100 if not given. For gpkg: metres
    /// from pixel to pixel; those of the source, as for sim, if not given.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) spacing: Option<f64>,
    /// For btg: what ground is made of, by a name of FlightGear's materials. Where the archive has water it is Lake.
    #[arg(long, value_name = "NAME", default_value = flightgear::USUAL_MATERIAL)]
    pub(crate) material: String,
    /// For ardupilot and btg: grid of the geoid above which heights are to be, where the archive's are above the ellipsoid; that of EGM96 if not
    /// given.
    #[arg(long, value_name = "GRID")]
    pub(crate) geoid: Option<String>,
    /// Folder to write, or file where the format is one, which must not be there yet.
    #[arg(short, long, value_name = "FOLDER|FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// A newer pack of an older one.
///
/// Every file is compared with the list in the difference; nothing is written where the older pack is another than that which the
/// difference was made from.
#[derive(Args)]
pub(crate) struct ApplyArgs {
    /// The older pack.
    #[arg(value_name = "OLD")]
    pub(crate) old: PathBuf,
    /// What `terrain-ingest pack --since OLD` wrote.
    #[arg(value_name = "DIFFERENCE")]
    pub(crate) difference: PathBuf,
    /// Folder to write, which must not be there yet.
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// What files a pack is made of.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum PackFormat {
    /// Quantized-mesh with normals: layer.json and z/x/y.terrain.
    Folder,
    /// 3D Tiles 1.1 with certified errors: tileset.json, z/x/y.json and z/x/y.glb.
    #[value(name = "3d-tiles")]
    ThreeDTiles,
    /// The files of 3d-tiles in one, a 3D Tiles archive.
    #[value(name = "3tz")]
    ThreeTz,
    /// The files of folder in one database, MBTiles; tiles compressed by gzip.
    MbtilesQm,
    /// The same in one PMTiles file.
    PmtilesQm,
    /// Raster tiles of heights for MapLibre and its kin, as terrarium, in Web Mercator: one PMTiles file.
    Terrarium,
    /// The same as mapbox, in steps of 0.1 m.
    Mapbox,
    /// For simulators, of the finest zoom: collision meshes, heightmaps and worlds in a local frame.
    Sim,
    /// For ArduPilot's card: a .DAT file for each degree, of heights above the sea in whole metres.
    Ardupilot,
    /// For FlightGear, of the finest zoom: triangles above the sea, a .btg.gz for each of its buckets.
    Btg,
    /// A raster of metres in one GeoPackage, as the extension for tiled gridded coverages has it.
    Gpkg,
}

/// Pixels along a side of a raster tile.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum TileSize {
    #[value(name = "256")]
    Small,
    #[value(name = "512")]
    Large,
}

/// Files of raster tiles.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Image {
    Png,
    /// Lossless.
    Webp,
}

/// How numbers are kept in files of 3D Tiles.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum PackingChoice {
    /// As they are, for any reader of glTF.
    Plain,
    /// In few bits and compressed: KHR_mesh_quantization and EXT_meshopt_compression.
    Meshopt,
}

impl PackArgs {
    pub(crate) fn format(&self) -> Format {
        match self.format {
            PackFormat::Folder => Format::QuantizedMesh,
            PackFormat::ThreeDTiles => Format::ThreeDTiles(self.packing()),
            PackFormat::ThreeTz => Format::ThreeDTilesArchive(self.packing()),
            PackFormat::MbtilesQm => Format::QuantizedMeshDatabase,
            PackFormat::PmtilesQm => Format::QuantizedMeshFile,
            PackFormat::Terrarium => Format::Rasters(self.raster(Encoding::Terrarium)),
            PackFormat::Mapbox => Format::Rasters(self.raster(Encoding::Mapbox)),
            PackFormat::Sim => Format::Simulator(simulator::Options {
                origin: self.origin,
                size: self.size,
                spacing: self.spacing,
            }),
            PackFormat::Ardupilot => Format::ArduPilot {
                spacing: self.spacing,
                geoid: self.geoid.clone(),
            },
            PackFormat::Btg => Format::FlightGear {
                material: self.material.clone(),
                geoid: self.geoid.clone(),
            },
            PackFormat::Gpkg => Format::GeoPackage { spacing: self.spacing },
        }
    }

    fn packing(&self) -> Packing {
        match self.packing {
            PackingChoice::Plain => Packing::Plain,
            PackingChoice::Meshopt => Packing::Meshopt,
        }
    }

    fn raster(&self, encoding: Encoding) -> RasterForm {
        RasterForm {
            size: match self.tile_size {
                TileSize::Small => SIZES[0],
                TileSize::Large => SIZES[1],
            },
            encoding,
            format: match self.image {
                Image::Png => raster_dem::image::Format::Png,
                Image::Webp => raster_dem::image::Format::WebP,
            },
        }
    }
}
