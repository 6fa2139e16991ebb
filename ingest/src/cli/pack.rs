//! The options of packs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use terrain_ingest::pack::Format;

use super::run::RunArgs;
use super::values::bounds;

const PACK_EXAMPLES: &str = "\
Examples:
  terrain-ingest pack alps.pmtiles --format folder -o alps                        for CesiumJS, from any web server
  terrain-ingest pack alps.pmtiles --format 3d-tiles --bbox 7,45,8,46 -o valais
  terrain-ingest pack alps.pmtiles --format 3d-tiles --max-zoom 10 -o coarse";

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
}

impl From<PackFormat> for Format {
    fn from(name: PackFormat) -> Self {
        match name {
            PackFormat::Folder => Self::QuantizedMesh,
            PackFormat::ThreeDTiles => Self::ThreeDTiles,
        }
    }
}
