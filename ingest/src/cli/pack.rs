//! The options of packs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use terrain_ingest::pack::{Format, simulator};

use super::run::RunArgs;
use super::values::{bounds, place, positive, posts};

const PACK_EXAMPLES: &str = "\
Examples:
  terrain-ingest pack alps.pmtiles --format folder -o alps                        for CesiumJS, from any web server
  terrain-ingest pack alps.pmtiles --format 3d-tiles --bbox 7,45,8,46 -o valais
  terrain-ingest pack alps.pmtiles --format 3tz --max-zoom 10 -o coarse.3tz
  terrain-ingest pack alps.pmtiles --format mbtiles-qm -o alps.mbtiles
  terrain-ingest pack alps.pmtiles --format sim --bbox 7.6,45.9,7.8,46.1 -o zermatt    for Gazebo, MuJoCo, Isaac Sim, PyBullet
  terrain-ingest pack alps.pmtiles --format sim --bbox 7,45,8,46 --size 2049 --spacing 10 --origin 7.66,45.98 -o valais

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
    /// The finest zoom; all if not given.
    #[arg(long, value_name = "ZOOM")]
    pub(crate) max_zoom: Option<u8>,
    /// For sim: longitude and latitude of the point that metres are counted from; the middle if not given.
    #[arg(long, value_name = "LON,LAT", value_parser = place, allow_hyphen_values = true)]
    pub(crate) origin: Option<[f64; 2]>,
    /// For sim: posts along a side of a heightmap, a power of two and one: 257, 513, 1025 … If not given, the least that makes do
    /// with one heightmap, or several of 1025.
    #[arg(long, value_name = "POSTS", value_parser = posts)]
    pub(crate) size: Option<u32>,
    /// For sim: metres from post to post, at most; about those of the source, twice that a zoom above its finest, if not given.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) spacing: Option<f64>,
    /// Folder, or file for 3tz and mbtiles-qm, to write, which must not be there yet.
    #[arg(short, long, value_name = "FOLDER|FILE")]
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
    /// For simulators, of the finest zoom: collision meshes, heightmaps and worlds in a local frame.
    Sim,
}

impl PackArgs {
    pub(crate) fn format(&self) -> Format {
        match self.format {
            PackFormat::Folder => Format::QuantizedMesh,
            PackFormat::ThreeDTiles => Format::ThreeDTiles,
            PackFormat::ThreeTz => Format::ThreeDTilesArchive,
            PackFormat::MbtilesQm => Format::QuantizedMeshDatabase,
            PackFormat::Sim => Format::Simulator(simulator::Options {
                bbox: self.bbox,
                origin: self.origin,
                size: self.size,
                spacing: self.spacing,
            }),
        }
    }
}
