//! One tile of the pyramid: from its finest mesh to its levels, certified, and to the coarsest mesh its parent gets.
//!
//! ```text
//! kinds of vertices ← where they lie: side, inner line of the strip, outline, inside
//! for each side:  collapse what the parent's side leaves out          one band each, first in the log
//! for each rung of the ladder from the zoom's error to twice that:    one band each
//!     collapse what the tolerance allows
//! partition ← log;  error of each level ← measured on the Earth
//! ```

use std::collections::{HashMap, HashSet};

use anyhow::{Context, Result, bail};
use glam::{DVec2, DVec3};
use terrain_codec::address::Side;
use terrain_codec::ellipsoid::{Geodetic, on_ellipsoid};
use terrain_codec::filled::Filled;
use terrain_codec::spt;
use terrain_codec::tile::{Detail, Lineage, Tile};
use terrain_core::height_field::ground::distance_on_earth;
use terrain_core::height_field::reference::Reference;
use terrain_core::height_field::refine::Frame;
use terrain_core::height_field::simplify::{Allowance, Quality, Shape, Simplifier, VertexKind};
use terrain_core::mesh::boundary_edges;
use terrain_core::{Mesh, Surface, SurfacePartition};

use crate::border::BorderCurve;
use crate::certify::Certifier;
use crate::georeference::GeoReference;
use crate::lattice::{Lattice, STRIP, Square};
use crate::leaf;

/// Share of a tolerance that the simplifier uses; the rest is for what its model of the Earth leaves out.
pub(crate) const MODEL_SHARE: f64 = 0.985;
/// Share of an error that is added to what was measured: another program, which follows straight edges over the raster by
/// other steps, may find so much more.
const AGREEMENT: f64 = 1e-5;
/// Share of a tolerance that most surfaces come to.
const NEARLY: f64 = 0.9;
/// No triangle is lower than this in plan, lattice units.
const LEAST_ALTITUDE: f64 = 2.0;

/// What all tiles of a build share.
pub(crate) struct Build<'a> {
    pub(crate) georeference: &'a GeoReference,
    pub(crate) lattice: Lattice,
    pub(crate) quality: Quality,
    pub(crate) certifier: &'a Certifier<'a>,
}

/// A finest mesh and what is claimed of it so far.
pub(crate) struct Finest {
    pub(crate) mesh: Mesh,
    /// Edges along breaklines, by their ends in plan.
    pub(crate) breaklines: Vec<[DVec2; 2]>,
    /// Metres by which collapses may have moved the outline from the raster's, and breaklines.
    pub(crate) outline_strayed: f64,
    /// What is claimed of it, metres, where it was measured as the coarsest surface of the tiles below.
    pub(crate) error: Option<f64>,
}

impl Build<'_> {
    pub(crate) fn shape(&self) -> Shape {
        Shape {
            height_step: self.lattice.height_step(),
            least_altitude: LEAST_ALTITUDE,
        }
    }

    /// Makes a tile, still without a name, of its finest mesh; `tolerance` is the zoom's error in metres.
    ///
    /// # Errors
    /// When a mesh is not what [`Build::collapse_sides`] says of all: a mistake of the program's, not of the rasters'.
    pub(crate) fn node(
        &self,
        square: Square,
        reference: &Reference,
        finest: Finest,
        sides: [&BorderCurve; 4],
        tolerance: f64,
    ) -> Result<Tile> {
        let kinds = kinds(&finest.mesh, self.lattice.extent(square.zoom));
        let surface = Surface::new(&finest.mesh, reference).with_breaklines(&finest.breaklines);
        let mut simplifier = Simplifier::new(surface, kinds, self.shape(), self.quality);
        let mut strays = self.collapse_sides(&mut simplifier, square, &finest.mesh, sides, tolerance)?;
        let rungs = self.rungs();
        for rung in 1..=rungs {
            let error = tolerance * (f64::from(rung) / f64::from(rungs)).exp2();
            let outline = (error - finest.outline_strayed).max(0.0);
            simplifier.simplify(Allowance {
                vertical: error * MODEL_SHARE,
                outline,
                breaklines: outline,
            });
            strays.push(strayed(&simplifier));
        }
        let partition = SurfacePartition::from_log(&finest.mesh, simplifier.log(), 0.0)?;
        let outline_errors = strays
            .iter()
            .rev()
            .chain([&0.0])
            .map(|stray| stray + finest.outline_strayed)
            .collect();
        let outline_strayed = finest.outline_strayed + strayed(&simplifier);
        let mut tile = Tile {
            address: square.address(),
            extent_bits: self.lattice.extent_bits(square.zoom),
            height_exponent: self.lattice.height_exponent,
            sampling: self.lattice.sampling(self.georeference, square),
            lineage: Lineage::default(),
            partition,
            outline_errors,
            breaklines: simplifier
                .breaklines()
                .into_iter()
                .map(|edge| edge.map(place))
                .collect(),
            filled: Filled::default(),
        };
        let coarsest_measured = self.certify(square, &mut tile, sides, finest.error, tolerance);
        tile.lineage = Lineage {
            name: 0,
            coarsest_measured: spt::rounded_up(coarsest_measured),
            outline_strayed: spt::rounded_up(outline_strayed),
        };
        Ok(tile)
    }

    /// Bands between a zoom's error and twice that: a surface between the two costs a tenth of a build.
    fn rungs(&self) -> i32 {
        match self.quality {
            Quality::Fast => 1,
            Quality::Default | Quality::Best => 2,
        }
    }

    /// Collapses what the parent's sides leave out, one band a side; tells by how much lines strayed after each.
    ///
    /// No such collapse is impossible. Where the outline meets a side, a run ends, and ends stay; fans that touch in a vertex were
    /// separated; and nothing lies in the strip. So all around a vertex between a run's ends is on two parallel lines, the side and the
    /// inner line, in order: seen from its neighbour on the side, the same triangles are upright, too, and the two have no common
    /// neighbour but the one across from their edge.
    fn collapse_sides(
        &self,
        simplifier: &mut Simplifier,
        square: Square,
        mesh: &Mesh,
        sides: [&BorderCurve; 4],
        tolerance: f64,
    ) -> Result<Vec<f64>> {
        let mut strays = Vec::new();
        let numbers = SideVertices::new(mesh, leaf::frame(self.lattice, square));
        let extent = self.lattice.extent(square.zoom) as f64;
        for (side, curve) in Side::ALL.into_iter().zip(sides).rev() {
            let start = leaf::side_start(self.lattice, square, side);
            for run in leaf::own_runs(curve, side) {
                let [first, _] = run.ends();
                let vertex = |(along, _, is_coarse): (i64, f64, bool)| {
                    let at = leaf::on_side(side, (along - start) as f64, extent);
                    let number = numbers.at(side, at, along == first);
                    number.map(|number| (number, is_coarse))
                };
                let vertices: Option<Vec<(u32, bool)>> = run.vertices().map(vertex).collect();
                let vertices = vertices
                    .with_context(|| format!("tile {}: a vertex of its {side:?} side is missing", square.address()))?;
                collapse_between(simplifier, vertices, tolerance * MODEL_SHARE)
                    .with_context(|| format!("tile {}, {side:?} side", square.address()))?;
            }
            simplifier.close_band(0.0);
            strays.push(strayed(simplifier));
        }
        Ok(strays)
    }

    /// Fills in the error of every level: measured, and never smaller than that of a finer one; `tolerance` is the zoom's. Tells
    /// what was measured of the coarsest one.
    fn certify(
        &self,
        square: Square,
        tile: &mut Tile,
        sides: [&BorderCurve; 4],
        known: Option<f64>,
        tolerance: f64,
    ) -> f64 {
        let interior = tile.interior_levels();
        let mut finer = tile.surface(tile.finest());
        let full = known.unwrap_or_else(|| self.error_of(square, &finer, NEARLY * tolerance));
        let bends = |mesh: &Mesh| self.outline_bends(square, mesh, sides);
        let (mut error, mut measured) = (full, Some(full));
        let count = tile.partition.levels.len();
        let mut outline = tile.outline_errors[count - 1] + bends(&finer);
        tile.partition.levels[count - 1].error = full;
        tile.outline_errors[count - 1] = outline;
        for level in (0..interior).rev() {
            let mesh = tile.surface(Detail {
                interior: level,
                fine_sides: [false; 4],
            });
            let news = without_triangles_of(&mesh, &finer);
            if !news.triangles.is_empty() {
                measured = self.error_beyond(square, &news, error);
                error = measured.unwrap_or(error);
            }
            outline = outline.max(tile.outline_errors[level] + bends(&mesh));
            let last = if level + 1 == interior { count - 1 } else { level + 1 };
            for index in level..last {
                tile.partition.levels[index].error = error;
                tile.outline_errors[index] = outline;
            }
            finer = mesh;
        }
        measured.unwrap_or_else(|| self.error_of(square, &finer, NEARLY * error))
    }

    /// What a mesh is off, whatever it is; found out soonest where that is a little more than `guess`.
    fn error_of(&self, square: Square, mesh: &Mesh, guess: f64) -> f64 {
        let mut guesses = [guess, 0.0].into_iter();
        guesses
            .find_map(|guess| self.error_beyond(square, mesh, guess))
            .unwrap_or(0.0)
    }

    /// What a mesh is off, if it is more than `floor`.
    fn error_beyond(&self, square: Square, mesh: &Mesh, floor: f64) -> Option<f64> {
        let geodetic = |position| self.geodetic(square, position);
        let measured = self
            .certifier
            .vertical_error(mesh, geodetic, floor / (1.0 + AGREEMENT))?;
        Some((measured * (1.0 + AGREEMENT)).max(floor))
    }

    pub(crate) fn geodetic(&self, square: Square, position: DVec3) -> Geodetic {
        let at = self
            .lattice
            .geographic(position.truncate() + self.lattice.origin(square));
        Geodetic {
            longitude: at.x,
            latitude: at.y,
            height: position.z,
        }
    }

    /// How far, in metres, the outline of a mesh is from where plan and chains have it, for edges are straight in space.
    fn outline_bends(&self, square: Square, mesh: &Mesh, sides: [&BorderCurve; 4]) -> f64 {
        let boundary = boundary_edges(&mesh.triangles);
        self.side_bulge(square, mesh, &boundary, sides) + self.outline_fold(square, mesh, &boundary)
    }

    /// How far, in metres, edges that are straight in space bulge from the tile's southern and northern side where that is an
    /// outline.
    fn side_bulge(&self, square: Square, mesh: &Mesh, boundary: &[(u32, u32)], sides: [&BorderCurve; 4]) -> f64 {
        let extent = self.lattice.extent(square.zoom) as f64;
        let mut bulge: f64 = 0.0;
        for side in [Side::South, Side::North] {
            let start = leaf::side_start(self.lattice, square, side);
            let outlines: Vec<[f64; 2]> = leaf::own_runs(sides[side as usize], side)
                .filter(|run| run.has_surface != [true; 2])
                .map(|run| run.ends().map(|end| (end - start) as f64))
                .collect();
            let y = leaf::on_side(side, 0.0, extent).y;
            for &(a, b) in boundary {
                let [a, b] = [a, b].map(|vertex| mesh.positions[vertex as usize].truncate());
                let middle = (a + b) / 2.0;
                let is_outline = || outlines.iter().any(|[first, last]| (first..=last).contains(&&middle.x));
                if a.y == y && b.y == y && is_outline() {
                    let [a, middle, b] = [a, middle, b].map(|at| self.on_ellipsoid(square, at));
                    bulge = bulge.max(distance_on_earth(middle, [a, b]));
                }
            }
        }
        bulge
    }

    /// How far, in metres, triangles at an outline lie over others: between vertices near a pole, edges that are straight in space run
    /// nearer to it than they do in plan.
    fn outline_fold(&self, square: Square, mesh: &Mesh, boundary: &[(u32, u32)]) -> f64 {
        let extent = self.lattice.extent(square.zoom);
        let is_on_side = |vertex: u32| leaf::is_on_side(mesh.positions[vertex as usize], extent);
        let mut is_outline = vec![false; mesh.positions.len()];
        for &(a, b) in boundary.iter().filter(|&&(a, b)| !(is_on_side(a) && is_on_side(b))) {
            is_outline[a as usize] = true;
            is_outline[b as usize] = true;
        }
        let is_at_outline = |corners: &&[u32; 3]| corners.iter().any(|&corner| is_outline[corner as usize]);
        let at_outline = mesh.triangles.iter().filter(is_at_outline);
        let fold = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| self.on_ellipsoid(square, mesh.positions[corner as usize].truncate()));
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            -(b - a).cross(c - a).dot(a.normalize()) / longest.max(f64::MIN_POSITIVE)
        };
        at_outline.map(fold).fold(0.0, f64::max)
    }

    fn on_ellipsoid(&self, square: Square, at: DVec2) -> DVec3 {
        on_ellipsoid(self.lattice.geographic(at + self.lattice.origin(square)))
    }
}

/// Metres by which the outline or a breakline has strayed in plan.
fn strayed(simplifier: &Simplifier) -> f64 {
    simplifier.outline_strayed().max(simplifier.breaklines_strayed())
}

/// The whole-numbered place of a plan position.
fn place(at: DVec2) -> [i64; 2] {
    at.as_i64vec2().to_array()
}

/// Those triangles of a level that are not what they are in the next finer one, of which it has the first.
fn without_triangles_of(mesh: &Mesh, finer: &Mesh) -> Mesh {
    let places = |mesh: &Mesh, corners: [u32; 3]| corners.map(|corner| mesh.positions[corner as usize]);
    let both = mesh.triangles.iter().zip(&finer.triangles);
    let news = both.filter(|&(&here, &there)| places(mesh, here) != places(finer, there));
    Mesh {
        triangles: news.map(|(&corners, _)| corners).collect(),
        positions: mesh.positions.clone(),
    }
}

/// The vertices on a tile's sides. Where the outline touches itself there are several at one place, so that they are known
/// by the edge along the side that they end.
struct SideVertices {
    /// For whether it is the edge's first one, seen along the side, and whether the side is a meridian: by place.
    numbers: HashMap<(bool, bool, [i64; 2]), u32>,
}

impl SideVertices {
    fn new(mesh: &Mesh, frame: Frame) -> Self {
        let mut numbers = HashMap::new();
        for (a, b) in boundary_edges(&mesh.triangles) {
            let [from, to] = [a, b].map(|vertex| mesh.positions[vertex as usize].truncate());
            if !frame.along_side(from, to) {
                continue;
            }
            let is_meridian = from.x == to.x;
            let is_forwards = (to - from).element_sum() > 0.0;
            numbers.insert((is_forwards, is_meridian, place(from)), a);
            numbers.insert((!is_forwards, is_meridian, place(to)), b);
        }
        Self { numbers }
    }

    fn at(&self, side: Side, at: DVec2, is_first: bool) -> Option<u32> {
        let is_meridian = matches!(side, Side::West | Side::East);
        self.numbers.get(&(is_first, is_meridian, place(at))).copied()
    }
}

/// Collapses the vertices that are not coarse into their neighbours along the side: first those that keep within the
/// tolerance, again and again, then the rest.
fn collapse_between(simplifier: &mut Simplifier, mut vertices: Vec<(u32, bool)>, tolerance: f64) -> Result<()> {
    for allowed in [tolerance, f64::INFINITY] {
        let mut before = usize::MAX;
        while vertices.len() < before {
            before = vertices.len();
            let mut index = 1;
            while index + 1 < vertices.len() {
                let (vertex, is_kept) = vertices[index];
                let beside = [vertices[index - 1].0, vertices[index + 1].0];
                if !is_kept
                    && beside
                        .into_iter()
                        .any(|red| simplifier.collapse_border(vertex, red, allowed))
                {
                    vertices.remove(index);
                } else {
                    index += 1;
                }
            }
        }
    }
    match vertices
        .iter()
        .rev()
        .skip(1)
        .rev()
        .skip(1)
        .find(|(_, is_kept)| !is_kept)
    {
        Some(&(vertex, _)) => {
            let at = simplifier.position(vertex);
            bail!("the vertex at lattice position {}, {} cannot be collapsed", at.x, at.y)
        }
        None => Ok(()),
    }
}

/// What each vertex of a tile may do, by where it lies. Outlines inside the square are the simplifier's to find.
pub(crate) fn kinds(mesh: &Mesh, extent: i64) -> Vec<VertexKind> {
    let (extent, width) = (extent as f64, STRIP as f64);
    let outline: HashSet<u32> = boundary_edges(&mesh.triangles)
        .into_iter()
        .flat_map(|(a, b)| [a, b])
        .collect();
    let kind = |(number, position): (u32, &DVec3)| {
        let from_side = [position.x, position.y].map(|coordinate| coordinate.min(extent - coordinate));
        let [on_column, on_row] = from_side.map(|distance| distance == width);
        let nearest = from_side[0].min(from_side[1]);
        match (on_column, on_row) {
            _ if nearest == 0.0 => VertexKind::Border,
            _ if nearest <= width && outline.contains(&number) => VertexKind::Fixed,
            (true, true) => VertexKind::Fixed,
            (true, false) => VertexKind::OnColumn,
            (false, true) => VertexKind::OnRow,
            (false, false) => VertexKind::Free,
        }
    };
    (0..).zip(&mesh.positions).map(kind).collect()
}
