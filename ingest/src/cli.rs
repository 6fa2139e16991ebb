//! The options of `terrain-ingest`, and the help that a stranger reads.

mod pack;
mod raster;
mod run;
mod tiles;
mod values;

use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Parser, Subcommand};
use terrain_ingest::pyramid::Job;

pub(crate) use self::pack::{ApplyArgs, PackArgs};
pub(crate) use self::raster::{ByteOrder, Priority, RasterArgs, VoidPolicy};
pub(crate) use self::run::RunArgs;
pub(crate) use self::tiles::{Bound, Quality, SurfaceArgs, TileArgs};
pub(crate) use self::values::Values;
use self::values::{degrees, positive};

const EXAMPLES: &str = "\
Examples:
  terrain-ingest dem.tif                         writes dem.pmtiles here, error derived from the raster
  terrain-ingest N49W124.hgt.zip N49W123.hgt.zip -o vancouver.pmtiles --max-error 5
  terrain-ingest height.exr --crs EPSG:2056 --bounds 2600000,1190000,2610000,1200000
  terrain-ingest old.tif --nodata -9999 --unit foot
  terrain-ingest island.png --pixel-size 2 --height-range 0 1024       a game's ground, shown around 0° N, 0° E
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

impl Cli {
    /// The arguments that the program was called with. Where they mean nothing, this says so and ends the program with exit code 2.
    pub(crate) fn of_arguments() -> Self {
        let mut program = Self::command();
        let arguments = std::env::args_os().skip(1);
        if let Some(late) = late_command(&program, arguments.filter_map(|argument| argument.into_string().ok())) {
            let message = format!("“{late}” is a command: it comes before all options, “terrain-ingest {late} …”");
            program.error(ErrorKind::ArgumentConflict, message).exit();
        }
        Self::parse()
    }
}

/// A command's name that comes after options, where a raster would be, and is none.
fn late_command(program: &clap::Command, arguments: impl Iterator<Item = String>) -> Option<String> {
    let mut arguments = arguments.peekable();
    arguments.next_if(|first| first.starts_with('-'))?;
    let first = arguments.find(|argument| !argument.starts_with('-'))?;
    let is_command = program.find_subcommand(&first).is_some();
    (is_command && !Path::new(&first).exists()).then_some(first)
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
    /// Make the newer pack of an older one and the difference that `pack --since` wrote.
    Apply(ApplyArgs),
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
    /// The lines that it keeps as edges; if not given, those that an archive says.
    #[arg(long, value_name = "FILE")]
    pub(crate) breaklines: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) raster: RasterArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
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
