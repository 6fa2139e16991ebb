//! The jobs that tiles are made by: each a pure function of named inputs.
//!
//! ```text
//! curve(side)               ← samples along it, or the curves of its halves
//! leaf(square)              ← the window of samples under it, the curves of its sides
//! parent(square)            ← its children's coarsest meshes, the samples under it, the curves of its sides
//! ```

use std::ops::Range;
use std::sync::Arc;

use anyhow::{Context, Result};
use glam::{DVec2, DVec3};
use moka::sync::Cache;
use rayon::prelude::*;
use terrain_codec::address::Side;
use terrain_codec::ellipsoid::{MEAN_RADIUS, METRES_IN_A_DEGREE, on_ellipsoid};
use terrain_codec::filled::Filled;
use terrain_codec::tile::Tile;
use terrain_core::height_field::chunks::Chunks;
use terrain_core::height_field::ground::Ground;
use terrain_core::height_field::plan::PlanMap;
use terrain_core::height_field::reference::Reference;
use terrain_core::height_field::simplify::{Allowance, Simplifier};

use super::family::{self, Child};
use super::plan::Plan;
use crate::border::BorderCurve;
use crate::breaklines::Breaklines;
use crate::certify::Certifier;
use crate::chunk_view::ChunkView;
use crate::chunks::ChunkedRaster;
use crate::coarse::CoarseWindow;
use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;
use crate::lattice::{Edge, Lattice, Square};
use crate::leaf::{self, FinestSurface};
use crate::node::{Build, Finest, MODEL_SHARE, kinds};
use crate::raster_outline::BorderSource;
use crate::samples::{Samples, Window};
use crate::stored_raster::StoredRaster;

/// Share of a zoom's error within which its sides are simplified; the parent's within 0.8 of it.
const SIDE_SHARE: f64 = 0.4;
/// Shares of the tolerance to try for a leaf until its certificate is what was asked for.
const LEAF_SHARES: [f64; 4] = [MODEL_SHARE, 0.93, 0.8, 0.6];
/// Stretches of a square's side between places whose columns and rows are asked for.
const STRETCHES: usize = 32;
/// Cells by which a window reaches beyond its square: what a cell at its side needs, and rounding.
const MARGIN: f64 = 4.0;
/// Levels of blocks above a tile's own that are searched: the largest are a quarter as wide as the tile.
const LEVELS_ABOVE: u8 = 5;
/// Curves that are kept at hand.
const CURVES: u64 = 1 << 14;

/// What jobs need to know, and the samples that they read.
pub(crate) struct Jobs<'a> {
    pub(crate) plan: Plan,
    pub(crate) raster: &'a ChunkedRaster,
    /// Of the columns and rows as the raster counts them.
    georeference: &'a GeoReference,
    /// Of the lattice that the raster is a part of: what is asked of it does not change when the raster grows.
    of_lattice: GeoReference,
    breaklines: Breaklines,
    curves: Cache<Edge, Arc<BorderCurve>>,
}

/// A square's plan coordinates over a grid, and the rectangle in which they are needed.
struct PlanOfTile<'a> {
    lattice: Lattice,
    georeference: &'a GeoReference,
    origin: DVec2,
    low: DVec2,
    high: DVec2,
}

impl<'a> PlanOfTile<'a> {
    /// The part of a square over a grid; none where they do not meet.
    fn over(lattice: Lattice, square: Square, georeference: &'a GeoReference) -> Option<Self> {
        Self::within(lattice, square, georeference, georeference.geographic_bounds())
    }

    fn within(
        lattice: Lattice,
        square: Square,
        georeference: &'a GeoReference,
        [west, south, east, north]: [f64; 4],
    ) -> Option<Self> {
        let origin = lattice.origin(square);
        let extent = DVec2::splat(lattice.extent(square.zoom) as f64);
        let low = (lattice.global(DVec2::new(west, south)) - origin).max(DVec2::ZERO);
        let high = (lattice.global(DVec2::new(east, north)) - origin).min(extent);
        (low.x < high.x && low.y < high.y).then_some(Self {
            lattice,
            georeference,
            origin,
            low,
            high,
        })
    }

    fn grid(&self, plan: DVec2) -> DVec2 {
        self.georeference.grid(self.lattice.geographic(plan + self.origin))
    }

    fn plan(&self, grid: DVec2) -> DVec2 {
        self.lattice.global(self.georeference.geographic(grid)) - self.origin
    }

    /// Where a position is on the ellipsoid, metres from the Earth's centre.
    fn place(&self, plan: DVec2) -> DVec3 {
        on_ellipsoid(self.lattice.geographic(plan + self.origin))
    }
}

impl<'a> Jobs<'a> {
    /// `breaklines` are in coordinates of the raster's reference system.
    pub(crate) fn new(plan: Plan, raster: &'a StoredRaster, breaklines: &[Vec<[f64; 2]>]) -> Self {
        let StoredRaster {
            chunks: raster,
            georeference,
            ..
        } = raster;
        Self {
            plan,
            raster,
            georeference,
            of_lattice: georeference.of_lattice(),
            breaklines: Breaklines::new(breaklines, georeference),
            curves: Cache::new(CURVES),
        }
    }

    /// Columns and rows of the samples that a square may touch; none where it is beside the raster.
    fn cells(&self, square: Square) -> Option<[Range<usize>; 2]> {
        let lattice = self.plan.lattice;
        let low = lattice.geographic(lattice.origin(square));
        let high = lattice.geographic(lattice.origin(square) + lattice.extent(square.zoom) as f64);
        self.cells_between(low, high)
    }

    /// Columns and rows of the samples under a square, if it has any.
    pub(crate) fn cells_with_samples(&self, square: Square) -> Option<[Range<usize>; 2]> {
        let cells = self.cells(square)?;
        let level = self.plan.height(square).min(self.raster.top());
        let has_samples = !self.raster.chunks_over(level, &cells[0], &cells[1]).is_empty();
        has_samples.then_some(cells)
    }

    /// Columns and rows of the samples in a rectangle of longitudes and latitudes.
    fn cells_between(&self, low: DVec2, high: DVec2) -> Option<[Range<usize>; 2]> {
        let [west, south, east, north] = self.plan.bounds;
        let (low, high) = (low.max(DVec2::new(west, south)), high.min(DVec2::new(east, north)));
        if !low.cmple(high).all() {
            return None;
        }
        let at = |across: usize, up: usize| {
            let share = DVec2::new(across as f64, up as f64) / STRETCHES as f64;
            self.of_lattice.grid(low + (high - low) * share)
        };
        let sides =
            (0..=STRETCHES).flat_map(|step| [at(step, 0), at(step, STRETCHES), at(0, step), at(STRETCHES, step)]);
        let (first, last) = sides.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(first, last), place| {
            (first.min(place), last.max(place))
        });
        // Between the places a side may bulge by a small part of what it spans.
        let margin = MARGIN + (last - first).max_element() / (STRETCHES * STRETCHES) as f64;
        let (size, origin) = (Samples::size(self.raster), self.georeference.origin());
        let range = |first: f64, last: f64, axis: usize| {
            let of_raster = |at: f64| (at as i64 - origin[axis]).max(0) as usize;
            of_raster((first - margin).floor())..(of_raster((last + margin).ceil()) + 1).min(size[axis])
        };
        let cells = [range(first.x, last.x, 0), range(first.y, last.y, 1)];
        cells.iter().all(|range| !range.is_empty()).then_some(cells)
    }

    /// The curve of a side, from the samples along it or from its halves.
    ///
    /// # Errors
    /// When samples cannot be read.
    pub(crate) fn curve(&self, edge: Edge) -> Result<Arc<BorderCurve>> {
        let edge = if self.georeference.is_around() {
            edge.wrapped()
        } else {
            edge
        };
        if let Some(curve) = self.curves.get(&edge) {
            return Ok(curve);
        }
        let tolerance = SIDE_SHARE * self.plan.error_at(edge.zoom);
        let Some([columns, rows]) = self.cells_along(edge) else {
            return Ok(Arc::default());
        };
        let curve = if edge.zoom == self.plan.lattice.leaf_zoom {
            let window = self.grid_of(self.raster.window(columns, rows)?, self.facing(edge));
            BorderCurve::of_leaf(&self.border_source(&window), edge, tolerance)
        } else {
            let [first, second] = edge.halves();
            let halves = [self.curve(first)?, self.curve(second)?];
            BorderCurve::of_halves(self.plan.lattice, edge, [&halves[0], &halves[1]], tolerance)
        };
        let curve = Arc::new(curve);
        self.curves.insert(edge, Arc::clone(&curve));
        Ok(curve)
    }

    fn curves_around(&self, square: Square) -> Result<[Arc<BorderCurve>; 4]> {
        let [west, south, east, north] = Side::ALL.map(|side| self.curve(square.edge(side)));
        Ok([west?, south?, east?, north?])
    }

    fn border_source<'b>(&'b self, window: &'b HeightGrid) -> BorderSource<'b> {
        BorderSource {
            lattice: self.plan.lattice,
            georeference: &window.georeference,
            heights: window.whole(),
            breaklines: &self.breaklines,
        }
    }

    /// All that a square has of breaklines depends on these bytes; none where it has none.
    pub(crate) fn bytes_of_breaklines(&self, [columns, rows]: &[Range<usize>; 2]) -> Vec<u8> {
        let origin = DVec2::from(self.georeference.origin().map(|first| first as f64));
        let corner = |column: usize, row: usize| DVec2::new(column as f64, row as f64) + origin;
        let corners = [corner(columns.start, rows.start), corner(columns.end, rows.end)];
        self.breaklines.bytes_near(corners)
    }

    /// Columns and rows of the samples along a side; none where nothing has a height.
    fn cells_along(&self, edge: Edge) -> Option<[Range<usize>; 2]> {
        let lattice = self.plan.lattice;
        let extent = lattice.extent(edge.zoom) as f64;
        let (line, along) = (edge.line as f64, edge.along as f64);
        let (low, high) = if edge.is_meridian {
            (DVec2::new(line, along), DVec2::new(line, along + 1.0))
        } else {
            (DVec2::new(along, line), DVec2::new(along + 1.0, line))
        };
        // Cells just beside the side count, even where the raster begins at it.
        let beside = DVec2::splat(1.0);
        let [low, high] = [low * extent - beside, high * extent + beside].map(|place| lattice.geographic(place));
        let level = (lattice.leaf_zoom - edge.zoom).min(self.raster.top());
        self.cells_between(low, high)
            .filter(|[columns, rows]| !self.raster.chunks_over(level, columns, rows).is_empty())
    }

    /// Longitude in the middle of a side.
    fn facing(&self, edge: Edge) -> f64 {
        let [start, end] = edge.ends().map(|[x, y]| DVec2::new(x as f64, y as f64));
        let middle = (start + end) / 2.0 * self.plan.lattice.extent(edge.zoom) as f64;
        self.plan.lattice.geographic(middle).x
    }

    /// Samples with longitudes as they are seen from one.
    fn grid_of(&self, window: Window, facing: f64) -> HeightGrid {
        let Window {
            first,
            columns,
            rows,
            heights,
        } = window;
        HeightGrid {
            columns,
            rows,
            heights,
            georeference: self
                .georeference
                .window(first.map(|first| first as i64), columns, rows)
                .facing(facing),
        }
    }

    /// The samples under a square, cut to those that are not void; none where all are.
    fn window(&self, square: Square, cells: [Range<usize>; 2]) -> Result<Option<HeightGrid>> {
        let [columns, rows] = cells;
        let window = self.raster.window(columns, rows)?.without_void_edges();
        let window = window.filter(|window| window.columns > 1 && window.rows > 1);
        Ok(window.map(|window| self.grid_of(window, self.plan.lattice.middle(square).x)))
    }

    fn build<'b>(&'b self, certifier: &'b Certifier<'b>) -> Build<'b> {
        Build {
            georeference: &self.of_lattice,
            lattice: self.plan.lattice,
            quality: self.plan.quality,
            certifier,
        }
    }

    /// The blocks of samples under a square, and where they are.
    fn view(&self, square: Square, cells: &[Range<usize>; 2]) -> (ChunkView<'a>, GeoReference) {
        let level = self.plan.height(square) + LEVELS_ABOVE;
        let view = ChunkView::new(self.raster, cells, level);
        let [columns, rows] = view.size();
        let georeference = self.of_lattice.window(view.origin(), columns, rows);
        (view, georeference.facing(self.plan.lattice.middle(square).x))
    }

    /// The leaf of a square, if the raster has a surface there.
    ///
    /// Above the deepest zoom it is made of some of its samples, and measured against all. Where the surface ends in it or has a breakline, it is
    /// made of smaller leaves, as parents are, and nobody else sees those: the outline is that of all samples.
    ///
    /// # Errors
    /// When samples cannot be read.
    pub(crate) fn leaf(&self, square: Square, cells: [Range<usize>; 2]) -> Result<Option<Tile>> {
        let is_of_samples = self.plan.height(square) == 0;
        if is_of_samples || self.is_whole(&cells)? {
            let filled = self.filled(square, &cells)?;
            let made = if is_of_samples {
                self.leaf_of_samples(square, cells)
            } else {
                self.leaf_of_blocks(square, cells)
            };
            return Ok(made?.map(|tile| Tile { filled, ..tile }));
        }
        let child = |child: Square| {
            let Some(cells) = self.cells_with_samples(child) else {
                return Ok(None);
            };
            let tile = self.leaf(child, cells)?;
            Ok(tile.map(|tile| Child::of(child, &tile)))
        };
        let children: Result<Vec<Option<Child>>> = square.children().into_par_iter().map(child).collect();
        let children: Vec<Child> = children?.into_iter().flatten().collect();
        if children.is_empty() {
            return Ok(None);
        }
        self.parent(square, cells, &children).map(Some)
    }

    /// Whether all samples of a rectangle have heights, so that no outline is there, nor a breakline.
    fn is_whole(&self, [columns, rows]: &[Range<usize>; 2]) -> Result<bool> {
        if !self.bytes_of_breaklines(&[columns.clone(), rows.clone()]).is_empty() {
            return Ok(false);
        }
        let size = self.raster.size();
        let reaches_an_end = |range: &Range<usize>, size: usize| range.start == 0 || range.end == size;
        if reaches_an_end(columns, size[0]) || reaches_an_end(rows, size[1]) {
            return Ok(false);
        }
        self.raster.is_whole(columns, rows)
    }

    fn leaf_of_samples(&self, square: Square, cells: [Range<usize>; 2]) -> Result<Option<Tile>> {
        let (view, of_view) = self.view(square, &cells);
        let certifier = Certifier::new(&of_view, &view, self.plan.bound, &view.cells(&cells));
        let Some(grid) = self.window(square, cells)? else {
            return Ok(None);
        };
        let Some(plan) = PlanOfTile::over(self.plan.lattice, square, &grid.georeference) else {
            return Ok(None);
        };
        let curvature: Vec<DVec2> = (0..grid.rows)
            .map(|row| curvature(&grid.georeference, grid.columns, row))
            .collect();
        let place = |at| plan.place(at);
        let reference = Reference {
            heights: grid.whole(),
            plan: PlanMap::fit(plan.low, plan.high, |at| plan.grid(at), |at| plan.plan(at)),
            curvature: &curvature,
            ground: Ground::Earth(&place),
            bound: self.plan.bound,
            finer: None,
        };
        let curves = self.curves_around(square)?;
        let sides = curves.each_ref().map(|curve| curve.as_ref());
        let outline = self.border_source(&grid);
        self.leaf_over(square, Some(&outline), &reference, sides, &certifier)
    }

    fn leaf_of_blocks(&self, square: Square, cells: [Range<usize>; 2]) -> Result<Option<Tile>> {
        let curves = self.curves_around(square)?;
        let sides = curves.each_ref().map(|curve| curve.as_ref());
        self.over_blocks(square, cells, |reference, certifier| {
            self.leaf_over(square, None, reference, sides, certifier)
        })
    }

    fn leaf_over(
        &self,
        square: Square,
        outline: Option<&BorderSource>,
        reference: &Reference,
        sides: [&BorderCurve; 4],
        certifier: &Certifier,
    ) -> Result<Option<Tile>> {
        let max_error = self.plan.error_at(square.zoom);
        let build = self.build(certifier);
        let mut best: Option<Tile> = None;
        for share in LEAF_SHARES {
            let made = self.leaf_mesh(&build, outline, square, reference, sides, share * max_error)?;
            let Some((finest, is_full)) = made else {
                return Ok(None);
            };
            let tile = build.node(square, reference, finest, sides, max_error)?;
            let error = tile.finest_error();
            if best.as_ref().is_none_or(|best| error < best.finest_error()) {
                best = Some(tile);
            }
            if is_full || self.plan.keeps_the_error(square.zoom, error) {
                break;
            }
        }
        Ok(best)
    }

    /// The finest mesh of a leaf, and whether it has as many vertices as a leaf may have.
    fn leaf_mesh(
        &self,
        build: &Build,
        outline: Option<&BorderSource>,
        square: Square,
        reference: &Reference,
        sides: [&BorderCurve; 4],
        tolerance: f64,
    ) -> Result<Option<(Finest, bool)>> {
        let lattice = self.plan.lattice;
        let FinestSurface {
            surface,
            strayed,
            is_full,
        } = leaf::finest_surface(lattice, outline, reference, square, sides, tolerance)?;
        let surface = surface.in_memory_order();
        let (mesh, _) = surface.mesh();
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        // Where a step is cut at a line, the cut is rounded.
        let strayed = strayed + lattice.degrees_per_unit() * METRES_IN_A_DEGREE;
        let kinds = kinds(&mesh, lattice.extent(square.zoom));
        let mut simplifier = Simplifier::new(surface, kinds, build.shape(), self.plan.quality);
        let in_plan = (self.plan.error_at(square.zoom) - strayed).max(0.0);
        simplifier.thin(Allowance {
            vertical: tolerance,
            outline: in_plan,
            breaklines: in_plan,
        });
        let outline_strayed = strayed + simplifier.outline_strayed().max(simplifier.breaklines_strayed());
        let surface = simplifier.into_surface().in_memory_order();
        let finest = Finest {
            breaklines: surface.breaklines(),
            mesh: surface.mesh().0,
            outline_strayed,
            error: None,
        };
        Ok(Some((finest, is_full)))
    }

    /// The tile above its children.
    ///
    /// # Errors
    /// When samples cannot be read, or the children do not meet.
    pub(crate) fn parent(&self, square: Square, cells: [Range<usize>; 2], children: &[Child]) -> Result<Tile> {
        self.over_blocks(square, cells, |reference, certifier| {
            let finest = family::finest(self.plan.lattice, children)?;
            let curves = self.curves_around(square)?;
            let sides = curves.each_ref().map(|curve| curve.as_ref());
            let tolerance = self.plan.error_at(square.zoom);
            let tile = self
                .build(certifier)
                .node(square, reference, finest, sides, tolerance)?;
            Ok(Tile {
                filled: family::filled(children),
                ..tile
            })
        })
    }

    /// Where the ground of a square was not measured: in all cells around a sample that was filled.
    fn filled(&self, square: Square, [columns, rows]: &[Range<usize>; 2]) -> Result<Filled> {
        let mut filled = Filled::default();
        let samples = self.raster.filled_in(columns.clone(), rows.clone())?;
        if samples.is_empty() {
            return Ok(filled);
        }
        let lattice = self.plan.lattice;
        let (origin, extent) = (lattice.origin(square), lattice.extent(square.zoom) as f64);
        let georeference = self.georeference.clone().facing(lattice.middle(square).x);
        let size = Samples::size(self.raster);
        let last = DVec2::new((size[0] - 1) as f64, (size[1] - 1) as f64);
        for sample in samples {
            let sample = DVec2::new(sample[0] as f64, sample[1] as f64);
            let around = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|aside| {
                let corner = (sample + DVec2::from(aside)).clamp(DVec2::ZERO, last);
                (lattice.global(georeference.geographic(corner)) - origin) / extent
            });
            let low = around.into_iter().reduce(DVec2::min).unwrap_or(DVec2::NAN);
            let high = around.into_iter().reduce(DVec2::max).unwrap_or(DVec2::NAN);
            filled.fill(low, high);
        }
        Ok(filled)
    }

    /// All that a leaf has of filled ground depends on these bytes; none where it has none.
    pub(crate) fn bytes_of_filled(&self, [columns, rows]: &[Range<usize>; 2]) -> Result<Vec<u8>> {
        let samples = self.raster.filled_in(columns.clone(), rows.clone())?;
        let in_window = |[column, row]: [usize; 2]| [column - columns.start, row - rows.start];
        let numbers = samples.into_iter().flat_map(in_window);
        Ok(numbers.flat_map(|number| (number as u64).to_le_bytes()).collect())
    }

    /// What is made of a square of some height, over each 2^height-th of its samples and the relief between them.
    fn over_blocks<T>(
        &self,
        square: Square,
        cells: [Range<usize>; 2],
        make: impl FnOnce(&Reference, &Certifier) -> Result<T>,
    ) -> Result<T> {
        let (view, georeference) = self.view(square, &cells);
        let certifier = Certifier::new(&georeference, &view, self.plan.bound, &view.cells(&cells));
        let outside = || format!("tile {} is outside the raster", square.address());
        let [columns, rows] = view.cells(&cells);
        let first = [columns.start as i64, rows.start as i64];
        let bounds = georeference
            .window(first, columns.len(), rows.len())
            .geographic_bounds();
        let plan = PlanOfTile::within(self.plan.lattice, square, &georeference, bounds).with_context(outside)?;
        let middle = (columns.start + columns.end) / 2;
        let window = CoarseWindow::new(&view, self.plan.height(square), [columns, rows], |row| {
            curvature(&georeference, 2 * middle, row)
        });
        let place = |at| plan.place(at);
        let reference = window.reference(
            [plan.low, plan.high],
            |at| plan.grid(at),
            |at| plan.plan(at),
            Ground::Earth(&place),
            self.plan.bound,
        );
        make(&reference, &certifier)
    }
}

/// Squared metres of a step over twice the Earth's radius, in the middle of a row.
fn curvature(georeference: &GeoReference, columns: usize, row: usize) -> DVec2 {
    let cell = georeference.cell_metres(DVec2::new((columns - 1) as f64 / 2.0, row as f64));
    cell * cell / (2.0 * MEAN_RADIUS)
}
