//! The main job: a raster becomes a nested pyramid of certified tiles in one archive.
//!
//! ```text
//! leaf zoom ← where a tile is about 128 samples wide
//! sides of all leaves ← curves of the raster                               in parallel
//! leaves ← finest mesh inside its sides; levels; certificate               in parallel
//! for each zoom above, up to 0, at twice the error of the one below:
//!     sides ← their halves' curves
//!     tiles ← the coarsest meshes of their four children, welded; levels; certificate
//! archive ← all tiles in order
//! ```

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::path::Path;

use anyhow::{Context, Result, bail};
use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;
use terrain_core::Mesh;
use terrain_core::height_field::chunks::ChunksInMemory;
use terrain_core::height_field::plan::PlanMap;
use terrain_core::height_field::reference::{Bound, Reference};
use terrain_core::height_field::simplify::{Allowance, Quality, Simplifier};
use terrain_tiles::address::{Side, TileAddress};
use terrain_tiles::archive::Writer;
use terrain_tiles::metadata::{FORMAT, Metadata, Source, VERSION, Zoom};

use crate::border::{BorderCurve, BorderSource};
use crate::certify::Certifier;
use crate::coarse::{CoarseWindow, samples_under};
use crate::height_grid::HeightGrid;
use crate::lattice::{Edge, Lattice, Square};
use crate::leaf;
use crate::node::{Build, Finest, MODEL_SHARE, Node, kinds};
use crate::progress::Progress;

/// Samples across a leaf tile, roughly: enough triangles that its sides do not weigh much.
const SAMPLES_ACROSS_A_LEAF: f64 = 128.0;
/// The asked error where none is given, in cells: a slope of about 6 % over one cell.
const DEFAULT_ERROR_IN_CELLS: f64 = 1.0 / 16.0;
/// Height steps in the asked error, at least.
const STEPS_IN_AN_ERROR: f64 = 64.0;
/// Share of a zoom's error within which its sides are simplified; the parent's within 0.8 of it.
const SIDE_SHARE: f64 = 0.4;
/// Shares of the tolerance to try for a leaf until its certificate is what was asked for.
const LEAF_SHARES: [f64; 4] = [MODEL_SHARE, 0.93, 0.8, 0.6];
/// Metres in a degree of latitude, roughly.
const METRES_IN_A_DEGREE: f64 = 111_320.0;
/// Mean radius of the Earth, metres.
const EARTH_RADIUS: f64 = 6_371_000.0;

/// What to build.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Largest error of the leaves in metres; derived from the raster's cells where not given.
    pub max_error: Option<f64>,
    /// Where the error is to hold.
    pub bound: Bound,
    /// How much work goes into few triangles.
    pub quality: Quality,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_error: None,
            bound: Bound::Surface,
            quality: Quality::Default,
        }
    }
}

/// What was built.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The archive's own description.
    pub metadata: Metadata,
    /// Bytes of all tiles.
    pub tile_bytes: usize,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "zoom  tiles  triangles  error, finest … coarsest level")?;
        for zoom in self.metadata.zooms.iter().rev() {
            let Zoom {
                zoom,
                tiles,
                triangles,
                finest_error,
                coarsest_error,
                ..
            } = zoom;
            writeln!(
                f,
                "{zoom:>4}  {tiles:>5}  {triangles:>9}  {finest_error:.2} … {coarsest_error:.2} m"
            )?;
        }
        write!(f, "{:.1} MB of tiles", self.tile_bytes as f64 / 1e6)
    }
}

/// The error that suits a raster's cells: a sixteenth of one, rounded to 1, 2 or 5 times a power of ten.
#[must_use]
pub fn default_error(grid: &HeightGrid) -> f64 {
    let wanted = centre_cell(grid).min_element() * DEFAULT_ERROR_IN_CELLS;
    let power = 10.0_f64.powi(wanted.log10().floor() as i32);
    let nearest = [1.0, 2.0, 5.0, 10.0].into_iter().min_by(|a, b| {
        let off = |step: &f64| (step * power / wanted).ln().abs();
        off(a).total_cmp(&off(b))
    });
    nearest.unwrap_or(1.0) * power
}

/// Builds the archive at `output`, all at once or not at all.
///
/// # Errors
/// When the raster has no surface, a tile cannot be made as promised, or the archive cannot be written.
pub fn build(grid: &HeightGrid, options: &Options, output: &Path, progress: &Progress) -> Result<Report> {
    let max_error = options.max_error.unwrap_or_else(|| default_error(grid));
    if !(max_error.is_finite() && max_error > 0.0) {
        bail!("the largest error must be more than 0 m");
    }
    let mut writer = Writer::create(output)?;
    let chunks = ChunksInMemory::new(grid.whole());
    let pyramid = Pyramid::new(grid, &chunks, options, max_error);
    let mut finished = Finished::default();
    let mut sides = pyramid.leaf_sides(progress);
    let mut nodes = pyramid.leaves(&sides, progress)?;
    if nodes.is_empty() {
        bail!("the raster has no cell with four valid samples");
    }
    let leaf_zoom = pyramid.build.lattice.leaf_zoom;
    for zoom in (0..=leaf_zoom).rev() {
        if zoom < leaf_zoom {
            sides = pyramid.parent_sides(zoom, &sides, &nodes);
            nodes = pyramid.parents(zoom, &sides, nodes, progress)?;
        }
        finished.take(zoom, &mut nodes);
    }
    finished.zooms.reverse();
    let tile_bytes = finished.tiles.values().map(Vec::len).sum();
    let metadata = pyramid.metadata(&finished);
    for (address, bytes) in &finished.tiles {
        writer.add(*address, bytes)?;
    }
    writer.finish(&metadata)?;
    Ok(Report { metadata, tile_bytes })
}

#[derive(Default)]
struct Finished {
    tiles: BTreeMap<TileAddress, Vec<u8>>,
    zooms: Vec<Zoom>,
    heights: Option<[f64; 2]>,
}

impl Finished {
    fn take(&mut self, zoom: u8, nodes: &mut [Node]) {
        let largest = |value: fn(&Node) -> f64| nodes.iter().map(value).fold(0.0, f64::max);
        self.zooms.push(Zoom {
            zoom,
            tiles: nodes.len(),
            triangles: nodes.iter().map(|node| node.triangles).sum(),
            finest_error: largest(|node| node.finest_error),
            coarsest_error: largest(|node| node.coarsest_error),
            outline_error: largest(|node| node.outline_error),
            available: rectangles(nodes.iter().map(|node| node.square.address())),
        });
        for node in nodes {
            let [low, high] = self.heights.unwrap_or(node.heights);
            self.heights = Some([low.min(node.heights[0]), high.max(node.heights[1])]);
            self.tiles
                .insert(node.square.address(), std::mem::take(&mut node.bytes));
        }
    }
}

struct Pyramid<'a> {
    build: Build<'a>,
    max_error: f64,
    bounds: [f64; 4],
    curvature: Vec<DVec2>,
    chunks: &'a ChunksInMemory,
}

impl<'a> Pyramid<'a> {
    fn new(grid: &'a HeightGrid, chunks: &'a ChunksInMemory, options: &Options, max_error: f64) -> Self {
        let degrees = centre_cell(grid).min_element() / METRES_IN_A_DEGREE;
        let zoom = (180.0 / (degrees * SAMPLES_ACROSS_A_LEAF))
            .log2()
            .round()
            .clamp(0.0, 24.0);
        let height_exponent = (max_error / STEPS_IN_AN_ERROR).log2().floor().clamp(-20.0, 20.0);
        let lattice = Lattice {
            leaf_zoom: zoom as u8,
            height_exponent: height_exponent as i8,
        };
        let middle = (grid.columns - 1) as f64 / 2.0;
        let row_curvature = |row| {
            let cell = grid.georeference.cell_metres(DVec2::new(middle, row as f64));
            cell * cell / (2.0 * EARTH_RADIUS)
        };
        Self {
            build: Build {
                grid,
                lattice,
                bound: options.bound,
                quality: options.quality,
                certifier: Certifier::new(grid, chunks, options.bound),
            },
            max_error,
            bounds: grid.georeference.geographic_bounds(),
            curvature: (0..grid.rows).map(row_curvature).collect(),
            chunks,
        }
    }

    fn error_at(&self, zoom: u8) -> f64 {
        self.max_error * f64::from(self.build.lattice.leaf_zoom - zoom).exp2()
    }

    /// What is under a square of the raster, handed to `then`; none where their rectangles do not meet.
    fn with_reference<T>(&self, square: Square, then: impl FnOnce(&Reference) -> T) -> Option<T> {
        let Build { grid, lattice, .. } = self.build;
        let origin = lattice.origin(square);
        let extent = DVec2::splat(lattice.extent(square.zoom) as f64);
        let [west, south, east, north] = self.bounds;
        let low = (lattice.global(DVec2::new(west, south)) - origin).max(DVec2::ZERO);
        let high = (lattice.global(DVec2::new(east, north)) - origin).min(extent);
        let to_grid = |plan: DVec2| grid.georeference.grid(lattice.geographic(plan + origin));
        let to_plan = |at: DVec2| lattice.global(grid.georeference.geographic(at)) - origin;
        if low.x >= high.x || low.y >= high.y {
            return None;
        }
        let ground = grid.georeference.cell_metres(to_grid((low + high) / 2.0));
        let bound = self.build.bound;
        let steps = lattice.leaf_zoom - square.zoom;
        if steps == 0 {
            let reference = Reference {
                heights: grid.whole(),
                plan: PlanMap::fit(low, high, to_grid, to_plan),
                curvature: &self.curvature,
                ground,
                bound,
                finer: None,
            };
            return Some(then(&reference));
        }
        let samples = samples_under(low, high, [grid.columns, grid.rows], to_grid);
        let window = CoarseWindow::new(self.chunks, steps, samples, |row| self.curvature[row]);
        Some(then(&window.reference([low, high], to_grid, to_plan, ground, bound)))
    }

    fn leaf_squares(&self) -> Vec<Square> {
        let lattice = self.build.lattice;
        let extent = lattice.extent(lattice.leaf_zoom) as f64;
        let [west, south, east, north] = self.bounds;
        let low = (lattice.global(DVec2::new(west, south)) / extent).floor();
        let high = (lattice.global(DVec2::new(east, north)) / extent).ceil();
        let last_row = (1_i64 << lattice.leaf_zoom) - 1;
        let rows = (low.y as i64).max(0)..=(high.y as i64 - 1).min(last_row);
        let columns = low.x as i64..high.x as i64;
        let square = |x, y| Square {
            zoom: lattice.leaf_zoom,
            x,
            y,
        };
        rows.flat_map(|y| columns.clone().map(move |x| square(x, y))).collect()
    }

    fn border_source(&self) -> BorderSource<'_> {
        BorderSource {
            lattice: self.build.lattice,
            georeference: &self.build.grid.georeference,
            heights: self.build.grid.whole(),
        }
    }

    fn leaf_sides(&self, progress: &Progress) -> BTreeMap<Edge, BorderCurve> {
        let edges = edges_of(&self.leaf_squares());
        let source = self.border_source();
        let tolerance = SIDE_SHARE * self.max_error;
        progress.stage("sides of tiles", edges.len() as u64);
        let curve = |edge: Edge| {
            let curve = BorderCurve::of_leaf(&source, edge, tolerance);
            progress.advance(1);
            (edge, curve)
        };
        let curves = edges.into_par_iter().map(curve).collect();
        progress.done();
        curves
    }

    fn parent_sides(
        &self,
        zoom: u8,
        sides: &BTreeMap<Edge, BorderCurve>,
        children: &[Node],
    ) -> BTreeMap<Edge, BorderCurve> {
        let squares: BTreeSet<Square> = children.iter().map(|node| node.square.parent()).collect();
        let source = self.border_source();
        let tolerance = SIDE_SHARE * self.error_at(zoom);
        let curve = |edge: Edge| {
            let halves = edge.halves().map(|half| sides.get(&half));
            (edge, BorderCurve::of_halves(&source, edge, halves, tolerance))
        };
        edges_of(&squares.into_iter().collect::<Vec<_>>())
            .into_par_iter()
            .map(curve)
            .collect()
    }

    fn leaves(&self, sides: &BTreeMap<Edge, BorderCurve>, progress: &Progress) -> Result<Vec<Node>> {
        let squares = self.leaf_squares();
        progress.stage(
            &format!("tiles of zoom {}", self.build.lattice.leaf_zoom),
            squares.len() as u64,
        );
        let leaf = |square: Square| {
            let node = self.leaf(square, sides_of(square, sides)?);
            progress.advance(1);
            node.transpose()
        };
        let nodes = squares.into_par_iter().filter_map(leaf).collect();
        progress.done();
        nodes
    }

    fn leaf(&self, square: Square, sides: [&BorderCurve; 4]) -> Result<Option<Node>> {
        let leaf = self.with_reference(square, |reference| self.leaf_over(square, reference, sides));
        leaf.unwrap_or(Ok(None))
    }

    fn leaf_over(&self, square: Square, reference: &Reference, sides: [&BorderCurve; 4]) -> Result<Option<Node>> {
        for share in LEAF_SHARES {
            let Some(finest) = self.leaf_mesh(square, reference, sides, share * self.max_error)? else {
                return Ok(None);
            };
            let node = self.build.node(square, reference, finest, sides, self.max_error)?;
            if node.finest_error <= self.max_error * (1.0 + 1e-6) {
                return Ok(Some(node));
            }
        }
        bail!(
            "tile {}: the error of {} m cannot be held; the raster is finer than its lattice",
            square.address(),
            self.max_error
        )
    }

    fn leaf_mesh(
        &self,
        square: Square,
        reference: &Reference,
        sides: [&BorderCurve; 4],
        tolerance: f64,
    ) -> Result<Option<Finest>> {
        let Build { grid, lattice, .. } = self.build;
        let surface = leaf::finest_surface(lattice, &grid.georeference, reference, square, sides, tolerance)?;
        let surface = surface.in_memory_order();
        let (mesh, _) = surface.mesh();
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        let rounding = lattice.degrees_per_unit() * METRES_IN_A_DEGREE;
        let kinds = kinds(&mesh, lattice.extent(square.zoom));
        let mut simplifier = Simplifier::new(surface, kinds, self.build.shape(), self.build.quality);
        simplifier.thin(Allowance {
            vertical: tolerance,
            outline: (self.max_error - rounding).max(0.0),
        });
        let outline_strayed = rounding + simplifier.outline_strayed();
        let mesh = simplifier.into_surface().in_memory_order().mesh().0;
        Ok(Some(Finest {
            mesh,
            outline_strayed,
            error: None,
        }))
    }

    fn parents(
        &self,
        zoom: u8,
        sides: &BTreeMap<Edge, BorderCurve>,
        children: Vec<Node>,
        progress: &Progress,
    ) -> Result<Vec<Node>> {
        let mut families: BTreeMap<Square, Vec<Node>> = BTreeMap::new();
        for child in children {
            families.entry(child.square.parent()).or_default().push(child);
        }
        progress.stage(&format!("tiles of zoom {zoom}"), families.len() as u64);
        let parent = |(square, family): (Square, Vec<Node>)| {
            let sides = sides_of(square, sides).context("a side is missing")?;
            let outline_strayed = family.iter().map(|child| child.outline_strayed).fold(0.0, f64::max);
            let finest = Finest {
                mesh: self.welded(&family)?,
                outline_strayed,
                error: Some(family.iter().map(|child| child.coarsest_measured).fold(0.0, f64::max)),
            };
            let error = self.error_at(zoom);
            let node = self.with_reference(square, |reference| {
                self.build.node(square, reference, finest, sides, error)
            });
            progress.advance(1);
            node.context("a tile is outside the raster")?
        };
        let nodes = families.into_par_iter().map(parent).collect();
        progress.done();
        nodes
    }

    /// The coarsest meshes of a family as one, in the parent's coordinates.
    fn welded(&self, family: &[Node]) -> Result<Mesh> {
        let mut mesh = Mesh::default();
        let mut numbers: HashMap<[i64; 2], u32> = HashMap::new();
        for child in family {
            let extent = self.build.lattice.extent(child.square.zoom);
            let mut number = Vec::with_capacity(child.coarsest.positions.len());
            for &position in &child.coarsest.positions {
                let at = self.build.lattice.in_parent(child.square, position);
                let own = mesh.positions.len() as u32;
                let is_shared = leaf::is_on_side(position, extent);
                let found = if is_shared {
                    *numbers.entry([at.x as i64, at.y as i64]).or_insert(own)
                } else {
                    own
                };
                if found == own {
                    mesh.positions.push(at);
                } else if mesh.positions[found as usize] != at {
                    bail!(
                        "tile {}: its side does not meet its neighbour's",
                        child.square.address()
                    );
                }
                number.push(found);
            }
            let triangles = child.coarsest.triangles.iter();
            mesh.triangles
                .extend(triangles.map(|corners| corners.map(|corner| number[corner as usize])));
        }
        Ok(mesh)
    }

    fn metadata(&self, finished: &Finished) -> Metadata {
        let grid = self.build.grid;
        Metadata {
            format: FORMAT.into(),
            version: VERSION,
            scheme: "geographic-tms".into(),
            bounds: self.bounds,
            heights: finished.heights.unwrap_or_default(),
            min_zoom: 0,
            max_zoom: self.build.lattice.leaf_zoom,
            bound: match self.build.bound {
                Bound::Surface => "surface".into(),
                Bound::Samples => "samples".into(),
            },
            max_error: self.max_error,
            source: Source {
                files: grid.files.clone(),
                crs: grid.georeference.crs_name().into(),
                vertical_datum: grid.vertical_datum.clone(),
                samples: [grid.columns, grid.rows],
            },
            generator: concat!("terrain-ingest ", env!("CARGO_PKG_VERSION")).into(),
            zooms: finished.zooms.clone(),
        }
    }
}

fn centre_cell(grid: &HeightGrid) -> DVec2 {
    let centre = DVec2::new((grid.columns - 1) as f64, (grid.rows - 1) as f64) / 2.0;
    grid.georeference.cell_metres(centre)
}

fn edges_of(squares: &[Square]) -> BTreeSet<Edge> {
    squares
        .iter()
        .flat_map(|square| Side::ALL.map(|side| square.edge(side)))
        .collect()
}

fn sides_of(square: Square, sides: &BTreeMap<Edge, BorderCurve>) -> Option<[&BorderCurve; 4]> {
    let [west, south, east, north] = Side::ALL.map(|side| sides.get(&square.edge(side)));
    Some([west?, south?, east?, north?])
}

/// Rectangles (first x, first y, last x, last y) that the addresses of one zoom fill exactly.
fn rectangles(addresses: impl Iterator<Item = TileAddress>) -> Vec<[u32; 4]> {
    let mut rows: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for address in addresses {
        rows.entry(address.y).or_default().insert(address.x);
    }
    let mut found: Vec<[u32; 4]> = Vec::new();
    for (y, columns) in rows {
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for x in columns {
            match runs.last_mut() {
                Some(run) if run[1] + 1 == x => run[1] = x,
                _ => runs.push([x, x]),
            }
        }
        for [first, last] in runs {
            let above = found
                .iter_mut()
                .find(|r| r[0] == first && r[2] == last && r[3] + 1 == y);
            match above {
                Some(rectangle) => rectangle[3] = y,
                None => found.push([first, y, last, y]),
            }
        }
    }
    found
}
