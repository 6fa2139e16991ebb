//! The options of `terrain-ingest`, and the help that a stranger reads.

mod values;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use terrain_ingest::pack::Format;
use terrain_ingest::pyramid::Job;
use terrain_tiles::metadata::{HeightsAbove, OutsidePolicy, RasterReader};

pub(crate) use values::Values;
use values::{bounds, degrees, not_negative, number, pixel_size, positive, size, unit, values};

const EXAMPLES: &str = "\
Examples:
  terrain-ingest dem.tif                         writes dem.pmtiles here, error derived from the raster
  terrain-ingest N49W124.hgt.zip N49W123.hgt.zip -o vancouver.pmtiles --max-error 5
  terrain-ingest height.exr --crs EPSG:2056 --bounds 2600000,1190000,2610000,1200000
  terrain-ingest old.tif --nodata -9999 --unit foot
  terrain-ingest tin dem.tif --max-error 10 -o dem.ply
  terrain-ingest tin map.r16 --pixel-size 2 --height-range 0 1024 --max-error 0.5 -o map.obj
  terrain-ingest tin dem.tif --max-error 10 --quality best --bound samples -o dem.obj
  terrain-ingest mesh bunny.obj --target-triangles 2000 -o bunny.ply
  terrain-ingest mesh bunny.obj -o bunny.spm     all levels of detail of a polygonal model
  terrain-ingest mesh bunny.spm --lod 3 -o bunny3.ply
  terrain-ingest mesh bunny.obj -o bunny.x3d     a world for X3D browsers that refines while it loads
  terrain-ingest clod bunny.obj -o bunny.clod    curved levels of detail, of Bézier patches
  terrain-ingest verify dem.pmtiles dem.tif      measures every claim again, by brute force
  terrain-ingest info dem.pmtiles
  terrain-ingest update vancouver.pmtiles --changed new/N49W123.hgt.zip
Serve the result with `terrain-server dem.pmtiles`.

Exit codes: 0 success; 1 a verified claim does not hold, or the job could not be finished; 2 unusable input or options.";

const UPDATE_EXAMPLES: &str = "\
Examples:
  terrain-ingest update alps.pmtiles --changed new/N46E007.hgt     a better raster in the place of one of that name
  terrain-ingest update alps.pmtiles --added N46E009.hgt --removed N45E006.hgt --from /data/srtm";

const PLAN_EXAMPLES: &str = "\
Example, on one machine:
  terrain-ingest plan *.tif --work /shared/work
  terrain-ingest build --work /shared/work --job samples/0        and so on, for all jobs of a stage, stage by stage
  terrain-ingest merge --work /shared/work -o all.pmtiles
How to run it by Dask, Slurm or Kubernetes: docs/distributed.md.";

const PACK_EXAMPLES: &str = "\
Examples:
  terrain-ingest pack alps.pmtiles --format folder -o alps                        for CesiumJS, from any web server
  terrain-ingest pack alps.pmtiles --format 3d-tiles --bbox 7,45,8,46 -o valais
  terrain-ingest pack alps.pmtiles --format 3d-tiles --max-zoom 10 -o coarse";

const MESH_EXAMPLES: &str = "\
Examples:
  terrain-ingest mesh bunny.obj -o bunny.spm                        all levels, each with half the triangles of the last
  terrain-ingest mesh bunny.obj --target-triangles 2000 -o small.ply
  terrain-ingest mesh horse.ply --max-error 0.001 -o horse.ply      as few triangles as that distance allows
  terrain-ingest mesh bunny.spm --lod 0 -o whole.ply                the finest level of a file made before
  terrain-ingest info bunny.spm                                     its levels and their errors";

const CLOD_EXAMPLES: &str = "\
Examples:
  terrain-ingest clod bunny.obj -o bunny.clod                       all levels, each with fewer patches than the last
  terrain-ingest clod teapot.bez --max-error 0.01 -o teapot.glb     fewest patches within that, as triangles with normals
  terrain-ingest clod bunny.clod --patches 1000 --tessellate 0.0001 -o bunny1000.obj
  terrain-ingest clod fandisk.obj --crease-angle 30 -o fandisk.json
  terrain-ingest info bunny.clod                                    its levels, their patches and errors";

/// Turns elevation rasters into progressive terrain whose every level of detail carries a certified error in metres.
///
/// Reads GeoTIFF, SRTM .hgt and .hgt.zip, Esri and USGS grids, DTED, netCDF, OpenEXR and more, in any coordinate
/// reference system that PROJ knows; a folder is the rasters in it, a .zip the raster in it. Nodata is void, never a height. Heights
/// become those above the ellipsoid where it is known what they are above.
#[derive(Parser)]
#[command(
    version,
    after_help = EXAMPLES,
    max_term_width = 110,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) build: BuildArgs,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Take changed rasters into an archive: only tiles whose samples changed are made anew.
    Update(UpdateArgs),
    /// Write down, in a store that many machines share, which jobs a build is made of.
    Plan(PlanArgs),
    /// Run one job of a planned build.
    Build(JobArgs),
    /// Write the archive of a planned build when all its jobs are done.
    Merge(MergeArgs),
    /// Triangulate a whole raster into one mesh, in the raster's own coordinates.
    Tin(TinArgs),
    /// Make levels of detail of a polygonal model (PLY, OBJ, STL, OFF, glTF), each with a certified distance from it; or extract
    /// one.
    Mesh(MeshArgs),
    /// Make curved levels of detail, of Bézier patches, of a polygonal model or a spline surface; or draw one as triangles.
    Clod(ClodArgs),
    /// Measure again, from the tiles or the mesh and the raster alone, every error that was claimed.
    Verify(VerifyArgs),
    /// Write an archive's tiles as files that other programs read without a server.
    Pack(PackArgs),
    /// Print what an archive, or a .spm, .lod or .clod file, says of itself.
    Info(InfoArgs),
}

/// The main job: an archive of tiles.
#[derive(Args)]
pub(crate) struct BuildArgs {
    /// Elevation rasters; several become one surface, whatever their cells and coordinate reference systems.
    #[arg(value_name = "DEM", required = true)]
    pub(crate) dems: Vec<PathBuf>,
    /// Archive to write; the first DEM's name with .pmtiles, in the current folder, if not given.
    #[arg(short, long, value_name = "OUT.pmtiles")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) tiles: TileArgs,
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    #[command(flatten)]
    pub(crate) raster: RasterArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// What tiles are to be.
#[derive(Args)]
pub(crate) struct TileArgs {
    /// Largest error of the finest tiles, in metres, doubled a zoom upwards. If not given, an eighth of the shorter side of a
    /// cell, rounded to 1, 2 or 5 times a power of ten: 0.1 m for cells of 1 m, 5 m for 30 m, 10 m for 90 m, and 200 m at
    /// most, or what cells of a degree and more bend away from the Earth.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) max_error: Option<f64>,
    /// What CesiumJS and its kin see where nothing was measured, around the data and in their holes.
    #[arg(long, value_enum, default_value = "extend")]
    pub(crate) outside: OutsideName,
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
}

/// What surface is made within the error.
#[derive(Args)]
pub(crate) struct SurfaceArgs {
    /// Where the error is bounded.
    #[arg(long, value_enum, default_value = "surface")]
    pub(crate) bound: Bound,
    /// How much work goes into few triangles; the error is the same for all.
    #[arg(long, value_enum, default_value = "default")]
    pub(crate) quality: Quality,
}

/// Where work is kept.
#[derive(Args)]
pub(crate) struct WorkArgs {
    /// Where finished work is kept until the archive is whole, so that a build that was stopped can go on: a folder, or a bucket
    /// as s3://bucket/path, gs://… or az://…; OUT.pmtiles.work if not given.
    #[arg(long, value_name = "DIR")]
    pub(crate) work: Option<String>,
    /// Leave the work where it is when the archive is whole: later builds and updates take from it what has not changed.
    #[arg(long)]
    pub(crate) keep_work: bool,
}

/// An archive of which rasters changed.
///
/// Takes every tile from the archive whose samples, and whose neighbours', are as they were, makes the others, and writes what a
/// build of all the rasters would write, byte for byte. Options are those that the archive was made with. Rasters that did not
/// change are read, too: they are looked for where the archive was made (if its work was kept), beside the archive, beside the
/// changed and added rasters, and in the current folder.
#[derive(Args)]
#[command(after_help = UPDATE_EXAMPLES)]
pub(crate) struct UpdateArgs {
    /// The archive, which is replaced when the new one is whole.
    #[arg(value_name = "OUT.pmtiles")]
    pub(crate) archive: PathBuf,
    /// Rasters in the place of those of the same names.
    #[arg(long, value_name = "DEM", num_args = 1..)]
    pub(crate) changed: Vec<PathBuf>,
    /// Rasters that come in, after all others: where rasters overlap, earlier ones win.
    #[arg(long, value_name = "DEM", num_args = 1..)]
    pub(crate) added: Vec<PathBuf>,
    /// Names of rasters that go.
    #[arg(long, value_name = "DEM", num_args = 1..)]
    pub(crate) removed: Vec<PathBuf>,
    /// Folders to look for rasters in that did not change, before all others.
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    pub(crate) from: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// A build for many machines.
///
/// Writes a recipe into the store and prints the stages, which run one after the other, and how many jobs each has, which may
/// all run at the same time: `terrain-ingest build --work DIR --job STAGE/NUMBER`, numbers from 0 on. The stage `samples` reads
/// the rasters, by the paths given here; all others need the store only. When all are done, `terrain-ingest merge`.
#[derive(Args)]
#[command(after_help = PLAN_EXAMPLES)]
pub(crate) struct PlanArgs {
    /// Elevation rasters; several become one surface, whatever their cells and coordinate reference systems.
    #[arg(value_name = "DEM", required = true)]
    pub(crate) dems: Vec<PathBuf>,
    /// The store that all machines share: a folder, or a bucket as s3://bucket/path, gs://… or az://….
    #[arg(long, value_name = "DIR")]
    pub(crate) work: String,
    /// Leaves of a job of the stage `tiles`, roughly: a job of 256 takes about a minute.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    pub(crate) leaves: u32,
    #[command(flatten)]
    pub(crate) tiles: TileArgs,
    #[command(flatten)]
    pub(crate) raster: RasterArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args)]
pub(crate) struct JobArgs {
    /// The store with the recipe.
    #[arg(long, value_name = "DIR")]
    pub(crate) work: String,
    /// Which job: its stage (samples, relief, survey, tiles or top) and its number.
    #[arg(long, value_name = "STAGE/NUMBER")]
    pub(crate) job: Job,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args)]
pub(crate) struct MergeArgs {
    /// The store with the finished work.
    #[arg(long, value_name = "DIR")]
    pub(crate) work: String,
    /// Archive to write.
    #[arg(short, long, value_name = "OUT.pmtiles")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// One mesh of a whole raster.
#[derive(Args)]
pub(crate) struct TinArgs {
    /// Elevation rasters.
    #[arg(value_name = "DEM", required = true)]
    pub(crate) dems: Vec<PathBuf>,
    /// Mesh to write; x and y in units of the raster's CRS, z in metres.
    #[arg(short, long, value_name = "OUT.ply|OUT.obj")]
    pub(crate) output: PathBuf,
    /// Largest error in metres.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) max_error: f64,
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
    #[command(flatten)]
    pub(crate) local: LocalArgs,
    #[command(flatten)]
    pub(crate) raster: RasterArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Levels of detail of a polygonal model.
///
/// Every level says how far it is from the model at most, in the model's units, both ways: each point of the model from the
/// level and each point of the level from the model. A model that is an oriented 2-manifold, closed or with boundaries, is
/// simplified by edge collapses, which keep its topology. Any other goes through vertex clustering, whose levels may pinch.
/// Polygons become triangles; vertices at one position become one; surfaces that touch in vertices or along edges are parted
/// there. Normals, colours and texture coordinates of vertices are carried along into .ply files, unless triangles that meet in
/// a vertex disagree about them.
#[derive(Args)]
#[command(after_help = MESH_EXAMPLES)]
pub(crate) struct MeshArgs {
    /// A model (.ply, .obj, .stl, .off, .gltf, .glb), or levels made before (.spm, .lod) to extract one from.
    #[arg(value_name = "IN.ply|IN.obj|IN.stl|IN.off|IN.glb|IN.spm|IN.lod")]
    pub(crate) input: PathBuf,
    /// What to write.
    ///
    /// .spm: all levels and their errors, compressed; manifolds only. Positions are rounded to 1/65,536 of the longest side, or
    /// finer where --max-error asks for it; the errors include that. .lod: all levels as text, the ASCII file of progressive
    /// multilevel meshes, errors as comments. .x3d, .wrl: the same and a world beside it that streams it in X3D browsers (z is
    /// up). .ply: one level.
    #[arg(short, long, value_name = "OUT.spm|OUT.lod|OUT.x3d|OUT.wrl|OUT.ply")]
    pub(crate) output: PathBuf,
    /// Stop at so many triangles.
    #[arg(long, value_name = "N", conflicts_with = "max_error", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) target_triangles: Option<u32>,
    /// Stop at the fewest triangles that are within this distance, in units of the model. With neither, the coarsest level is
    /// the coarsest that topology allows.
    #[arg(long, value_name = "E", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) max_error: Option<f64>,
    /// The level to write to a .ply file, 0 being the finest; the coarsest if not given.
    #[arg(long, value_name = "K")]
    pub(crate) lod: Option<usize>,
    /// Leave every vertex where it is in the model: more triangles for the same error. Implied by .lod files and worlds, which
    /// have one position a vertex.
    #[arg(long)]
    pub(crate) keep_vertices: bool,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Curved levels of detail.
///
/// A surface becomes cubic triangular Bézier patches: one for each triangle of a polygonal model, which bends as its normals say
/// and keeps its creases, or two for each patch of a spline surface. Patches are then merged, level by level. Every level says how
/// far it is from level 0 at most, in the model's units, both ways. A model must be an oriented 2-manifold, closed or with
/// boundaries; surfaces that touch are parted.
#[derive(Args)]
#[command(after_help = CLOD_EXAMPLES)]
pub(crate) struct ClodArgs {
    /// A polygonal model (.ply, .obj, .stl, .off, .gltf, .glb), Bézier patches in one of the layouts of the Utah teapot (.bez,
    /// .bpt, .txt), levels made before (.clod), or an elevation raster: of that, one curved surface within --max-error metres of
    /// every sample.
    #[arg(value_name = "MODEL|DEM")]
    pub(crate) input: PathBuf,
    /// What to write.
    ///
    /// .clod: all levels and their errors, control points rounded to a 2^20th of the longest side, or finer where --max-error asks
    /// for it; the errors include that. .json: all levels, as text. .obj, .ply, .glb: one level as triangles with normals.
    #[arg(short, long, value_name = "OUT.clod|OUT.json|OUT.obj|OUT.ply|OUT.glb")]
    pub(crate) output: PathBuf,
    /// Merge no farther than to this distance, in units of the model; of levels made before, the coarsest that is within it.
    #[arg(long, value_name = "E", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) max_error: Option<f64>,
    /// Stop at so many patches; of levels made before, the first that has no more.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) patches: Option<u32>,
    /// The level to draw as triangles, 0 being the finest; the coarsest if neither this nor the options above say otherwise.
    #[arg(long, value_name = "K", conflicts_with = "patches")]
    pub(crate) level: Option<usize>,
    /// How far triangles may be from the patches, in units of the model; if not given, a thousandth of its longest side, for a raster a
    /// quarter of its error.
    #[arg(long, value_name = "TOLERANCE", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) tessellate: Option<f64>,
    /// Compute normals from the triangles, with creases along edges that turn by more than so many degrees, from 0 to 180. If not
    /// given, the file's own normals are used, or where it has none, 60.
    #[arg(long, value_name = "DEGREES", value_parser = degrees, allow_negative_numbers = true)]
    pub(crate) crease_angle: Option<f64>,
    #[command(flatten)]
    pub(crate) raster: RasterArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Brute force over an archive or a mesh.
#[derive(Args)]
pub(crate) struct VerifyArgs {
    /// What to verify: an archive or a mesh.
    #[arg(value_name = "OUT.pmtiles|MESH.ply|MESH.obj")]
    pub(crate) subject: PathBuf,
    /// The rasters that it was made from.
    #[arg(value_name = "DEM", required = true)]
    pub(crate) dems: Vec<PathBuf>,
    /// The error to hold a mesh to that claims none itself, in metres.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) max_error: Option<f64>,
    /// Where such a mesh's error is bounded.
    #[arg(long, value_enum, default_value = "surface")]
    pub(crate) bound: Bound,
    #[command(flatten)]
    pub(crate) local: LocalArgs,
    #[command(flatten)]
    pub(crate) raster: RasterArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

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

#[derive(Args)]
pub(crate) struct InfoArgs {
    /// The archive, or levels of a model.
    #[arg(value_name = "OUT.pmtiles|OUT.spm|OUT.lod|OUT.clod")]
    pub(crate) archive: PathBuf,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// For rasters that do not say where they are, or wrongly.
#[derive(Args)]
pub(crate) struct RasterArgs {
    /// Coordinate reference system to use instead of the raster's own: EPSG:2056, WKT or a PROJ string.
    #[arg(long, value_name = "CRS")]
    pub(crate) crs: Option<String>,
    /// Outer edges of the raster's pixels, in units of the CRS, to use instead of the raster's own position.
    #[arg(long, value_name = "WEST,SOUTH,EAST,NORTH", value_parser = bounds, allow_hyphen_values = true)]
    pub(crate) bounds: Option<[f64; 4]>,
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
    /// Raster below and around all others, where these have no height; several are asked in their order.
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
    /// The widest void that --voids fill fills; if not given, forty cells.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) fill_width: Option<f64>,
    /// Polygons (GeoJSON, Shapefile, FlatGeobuf) within which the surface is level, at the median of the samples inside: lakes, runways.
    #[arg(long, value_name = "FILE")]
    pub(crate) water: Option<PathBuf>,
    /// What heights are to be above: the ellipsoid, as globes need them, or as they are in the rasters. Tiles are above the
    /// ellipsoid where it is known what the rasters' heights are above; meshes have the rasters' heights; verify does as the archive
    /// says.
    #[arg(long, value_enum)]
    pub(crate) heights: Option<Heights>,
}

/// For ground that is nowhere on the Earth.
#[derive(Args)]
pub(crate) struct LocalArgs {
    /// Metres from sample to sample, one number or X,Y, of a raster that is nowhere on the Earth, such as a height map of a game: x
    /// and y are then metres from its last row's first sample.
    #[arg(long, value_name = "METRES", value_parser = pixel_size, conflicts_with_all = ["crs", "bounds", "vertical", "geoid", "heights"])]
    pub(crate) pixel_size: Option<[f64; 2]>,
}

/// Which byte of a number comes first.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ByteOrder {
    /// The least significant one.
    Little,
    /// The most significant one.
    Big,
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

/// What is where nothing was measured.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum OutsideName {
    /// The ellipsoid, with walls up to the data.
    Ellipsoid,
    /// The sea level, with walls up to the data.
    Geoid,
    /// Ground that goes on from the edge of the data without a wall, and comes down to the ellipsoid as far away as the data are
    /// wide.
    Extend,
}

impl From<OutsideName> for OutsidePolicy {
    fn from(name: OutsideName) -> Self {
        match name {
            OutsideName::Ellipsoid => Self::Ellipsoid,
            OutsideName::Geoid => Self::Geoid,
            OutsideName::Extend => Self::Extend,
        }
    }
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

#[derive(Args)]
pub(crate) struct RunArgs {
    /// Threads to use; all cores if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Memory to stay below, roughly, as 800M or 2G; a quarter of the machine's if not given.
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub(crate) memory: Option<u64>,
    /// Show no progress.
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// Report as JSON on standard output; progress, unless it is quiet, as an event a line on standard error.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Where an error is bounded.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Bound {
    /// At every point of the surface that is bilinear between samples.
    Surface,
    /// At samples only, as other programs do it: fewer triangles, a weaker promise.
    Samples,
}

/// How much work goes into few triangles.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Quality {
    /// Least time: vertices stay where they are when others collapse into them, and a tile has no level made for an error between its
    /// finest and its coarsest one.
    Fast,
    /// Vertices may go to the middle of an edge that collapses.
    Default,
    /// Fewest triangles: more places, and edges swapped and vertices moved to make room for further collapses.
    Best,
}
