//! The certified error of a finished surface: measured on the Earth, not in the simplifier's model of it.
//!
//! Triangles are flat in Earth-centred coordinates between vertices of the lattice, as a client draws them; the
//! deviation at a point P of the surface with the ellipsoid's normal n is N·(P − V) / (N·n) for a triangle through V with
//! normal N.
//!
//! ```text
//! worst ← the floor: what is no worse does not matter
//! for each triangle: for each block of samples that may hold something worse than that (branch and bound):
//!     its corners, and each sample of a small one, whose normal line crosses the triangle
//! for each edge: likewise each place where it crosses a grid line, and the summit of the difference in between
//! bound ← the worst + what curvature can add between these places: inside one cell and one triangle
//! ```
//! The difference from a bilinear cell or block is, but for the curvature, a bilinear function without summits of its own.

mod curvature;
mod place;
mod stretch;
mod worst;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::{self, Geodetic};
use terrain_core::Mesh;
use terrain_core::height_field::blocks::{Block, Relief};
use terrain_core::height_field::chunks::Chunks;
use terrain_core::height_field::reference::Bound;

use crate::georeference::GeoReference;
use curvature::Curvature;
use place::Place;
use stretch::Stretch;
use worst::Worst;

/// Metres by which a sample may lie beside a triangle and still be taken as covered by it.
const BESIDE: f64 = 1e-3;
/// Metres below which a triangle is a line as seen from above, as where two corners are at a pole: its edges say all. Beside a pole,
/// and in strips, there are triangles that are turned over; they are measured like others.
const THINNEST: f64 = 1e-6;
/// Cells around a triangle that is straight on the grid where samples may be covered by it.
const AROUND: f64 = 0.02;
/// Cells by which an edge may leave the straight line on the grid before its triangles are searched as rectangles.
const NEARLY_STRAIGHT: f64 = 0.5;
/// Samples around the surface that it may need.
const MARGIN: f64 = 3.0;

/// Measures surfaces against one raster.
pub(crate) struct Certifier<'a> {
    georeference: &'a GeoReference,
    chunks: &'a dyn Chunks,
    bound: Bound,
    /// Where longitude depends on the column alone and latitude on the row alone.
    separable: Option<Separable>,
}

/// Places of samples, by column and by row.
struct Separable {
    /// Column and row of the first.
    first: [usize; 2],
    /// Sine and cosine of the longitude.
    columns: Vec<DVec2>,
    /// Sine and cosine of the latitude, and what is on the ellipsoid there: distance from the axis, and from the equator.
    rows: Vec<[f64; 4]>,
}

impl<'a> Certifier<'a> {
    /// `chunks` count columns and rows as `georeference` does; most of what is measured is over `cells` of them. There may be very many
    /// others, of which nothing is kept.
    pub(crate) fn new(
        georeference: &'a GeoReference,
        chunks: &'a dyn Chunks,
        bound: Bound,
        cells: &[Range<usize>; 2],
    ) -> Self {
        let [columns, rows] = chunks.size();
        let place = |column, row| georeference.geographic(DVec2::new(column as f64, row as f64));
        let last = place(columns - 1, rows - 1);
        let is_upright = place(columns - 1, 0).y == place(0, 0).y && place(columns - 1, 0).x == last.x;
        let sine_and_cosine = |degrees: f64| DVec2::from(degrees.to_radians().sin_cos());
        let separable = (georeference.is_geographic() && is_upright).then(|| {
            let row = |row: usize| {
                let latitude = sine_and_cosine(place(0, row).y);
                let on_ellipsoid = ellipsoid::above(DVec3::new(latitude.y, 0.0, latitude.x), 0.0);
                [latitude.x, latitude.y, on_ellipsoid.x, on_ellipsoid.z]
            };
            let [columns, rows] = cells.clone();
            Separable {
                first: [columns.start, rows.start],
                columns: columns.map(|column| sine_and_cosine(place(column, 0).x)).collect(),
                rows: rows.map(row).collect(),
            }
        });
        Self {
            georeference,
            chunks,
            bound,
            separable,
        }
    }

    /// The ellipsoid's normal at a sample's place, and the point `height` metres above.
    #[inline]
    fn above(&self, at: DVec2, height: f64) -> (DVec3, DVec3) {
        if let Some(separable) = &self.separable
            && let Some(&longitude) = separable.columns.get((at.x as usize).wrapping_sub(separable.first[0]))
            && let Some(&[sine, cosine, from_axis, from_equator]) =
                separable.rows.get((at.y as usize).wrapping_sub(separable.first[1]))
        {
            let from_axis = from_axis + height * cosine;
            let up = DVec3::new(cosine * longitude.y, cosine * longitude.x, sine);
            let point = DVec3::new(
                from_axis * longitude.y,
                from_axis * longitude.x,
                from_equator + height * sine,
            );
            return (up, point);
        }
        let at = self.georeference.geographic(at);
        let up = ellipsoid::normal(at.x, at.y);
        (up, ellipsoid::above(up, height))
    }

    /// Whether the raster's own coordinates go on beyond its last samples as far as a block reaches.
    fn reaches(&self, block: &Block) -> bool {
        let [columns, rows] = self.chunks.size();
        let last = block.first + block.side;
        self.georeference.is_geographic() || last.x < columns as f64 && last.y < rows as f64
    }

    /// An upper bound of the vertical deviation between `surface` and the raster's surface, in metres; none where that is no
    /// more than `floor`, which is found out the sooner, the higher the floor is. `geodetic` gives the longitude (in the range of
    /// the raster's), latitude and height of a vertex.
    pub(crate) fn vertical_error(
        &self,
        surface: &Mesh,
        geodetic: impl Fn(DVec3) -> Geodetic,
        floor: f64,
    ) -> Option<f64> {
        let places: Vec<Place> = surface
            .positions
            .iter()
            .map(|&position| Place::of(geodetic(position), self.georeference))
            .collect();
        let mut measure = Measure::new(self, &surface.triangles, &places, floor);
        for corners in &surface.triangles {
            measure.triangle(*corners);
        }
        if self.bound == Bound::Surface {
            measure.all_edges();
        }
        measure.poles(&surface.triangles);
        let worst = measure.worst.get();
        (worst > floor).then_some(worst)
    }
}

/// An edge of the surface, and what curvature may add beside it.
struct Edge {
    ends: [u32; 2],
    stretches: Vec<Stretch>,
    /// Cells by which it leaves the straight line on the grid.
    bulge: f64,
    /// Metres.
    between: f64,
}

/// A surface being measured.
struct Measure<'a> {
    certifier: &'a Certifier<'a>,
    places: &'a [Place],
    edges: Vec<Edge>,
    relief: Relief<'a>,
    /// Columns and rows that it sees.
    window: [Range<usize>; 2],
    curvature: Curvature,
    worst: Worst,
}

impl<'a> Measure<'a> {
    fn new(certifier: &'a Certifier<'a>, triangles: &[[u32; 3]], places: &'a [Place], floor: f64) -> Self {
        let mut ends: Vec<[u32; 2]> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [ordered(a, b), ordered(b, c), ordered(c, a)])
            .collect();
        ends.sort_unstable();
        ends.dedup();
        let edge = |ends: [u32; 2]| {
            let [a, b] = ends.map(|end| places[end as usize]);
            let stretches = Stretch::all(certifier.georeference, a, b);
            Edge {
                ends,
                bulge: stretch::bulge(&stretches),
                stretches,
                between: 0.0,
            }
        };
        let edges: Vec<Edge> = ends.into_iter().map(edge).collect();
        let (low, high) = edges
            .iter()
            .flat_map(|edge| &edge.stretches)
            .flat_map(|stretch| [0.0, 0.5, 1.0].map(|t| stretch.at(t).truncate()))
            .chain(places.iter().map(|place| place.grid))
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
        let [columns, rows] = certifier.chunks.size();
        let range = |low: f64, high: f64, count: usize| {
            let first = ((low - MARGIN).max(0.0) as usize).min(count - 1);
            first..((high + MARGIN).max(0.0) as usize + 1).clamp(first + 1, count)
        };
        let window = [range(low.x, high.x, columns), range(low.y, high.y, rows)];
        Self {
            certifier,
            places,
            edges,
            curvature: Curvature::under(certifier.georeference, certifier.chunks.size(), &window),
            relief: Relief::new(certifier.chunks, window[0].clone(), window[1].clone()),
            window,
            worst: Worst::new(floor),
        }
    }

    fn edges_of(&self, [a, b, c]: [u32; 3]) -> [usize; 3] {
        [ordered(a, b), ordered(b, c), ordered(c, a)].map(|ends| {
            let place = self.edges.binary_search_by(|edge| edge.ends.cmp(&ends));
            place.expect("each side of each triangle was made an edge")
        })
    }

    /// Takes the samples under a triangle into account.
    fn triangle(&mut self, corners: [u32; 3]) {
        let [a, mut b, mut c] = corners.map(|corner| self.places[corner as usize]);
        let mut normal = (b.space - a.space).cross(c.space - a.space);
        let longest = (b.space - a.space).length().max((c.space - a.space).length());
        if normal.dot(a.up).abs() <= THINNEST * longest {
            return;
        }
        if normal.dot(a.up) < 0.0 {
            (b, c, normal) = (c, b, -normal);
        }
        let edges = self.edges_of(corners);
        let plane = Plane {
            certifier: self.certifier,
            corners: [a, b, c].map(|place| place.space),
            normal,
        };
        let (low, high) = (a.grid.min(b.grid).min(c.grid), a.grid.max(b.grid).max(c.grid));
        let between = match self.certifier.bound {
            Bound::Samples => 0.0,
            Bound::Surface => {
                let heights = [a, b, c].map(|place| place.height);
                let rise = heights
                    .iter()
                    .fold(0.0_f64, |rise, height| rise.max((height - heights[0]).abs()));
                self.curvature.in_triangle(high - low, plane.steepness(), 2.0 * rise)
            }
        };
        for edge in edges {
            let edge = &mut self.edges[edge];
            edge.between = edge.between.max(between);
        }
        let bulge = edges.iter().map(|&edge| self.edges[edge].bulge).fold(0.0, f64::max);
        // From a pole a triangle reaches down between the meridians of its other corners, whatever longitude the pole has.
        let is_at_pole = [a, b, c].iter().any(|place| place.is_pole);
        let worst = self.worst.less(between);
        if bulge <= NEARLY_STRAIGHT && !is_at_pole {
            let grid = [a, b, c].map(|place| place.grid);
            plane.meet(&self.relief, &self.curvature, grid, AROUND + bulge, &worst, false);
        } else {
            for half in self.rectangle(&edges) {
                plane.meet(&self.relief, &self.curvature, half, AROUND, &worst, true);
            }
        }
        self.worst.grow(&worst, between);
    }

    /// All samples of a row at a pole are at one place, where every corner at the pole is, too.
    fn poles(&mut self, triangles: &[[u32; 3]]) {
        if !self.certifier.georeference.is_geographic() || !self.places.iter().any(|place| place.is_pole) {
            return;
        }
        let corners: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
        let mut by_row: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for place in corners.into_iter().map(|corner| self.places[corner as usize]) {
            let row = place.grid.y.round();
            let has_samples = (place.grid.y - row).abs() < AROUND && self.window[1].contains(&(row.max(0.0) as usize));
            if place.is_pole && has_samples {
                by_row.entry(row as usize).or_default().push(place.height);
            }
        }
        for (row, corners) in by_row {
            for sample in self.relief.samples(0, self.window[0].clone(), row..row + 1) {
                let differences = corners.iter().map(|corner| (f64::from(sample) - corner).abs());
                differences.for_each(|difference| self.worst.meet(difference));
            }
        }
    }

    /// The rectangle on the grid around edges that are bent there, as two triangles.
    fn rectangle(&self, edges: &[usize; 3]) -> [[DVec2; 3]; 2] {
        let stretches = edges.iter().flat_map(|&edge| &self.edges[edge].stretches);
        let places = stretches.flat_map(|stretch| [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| stretch.at(t).truncate()));
        let (low, high) = places.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        let (beside, below) = (DVec2::new(high.x, low.y), DVec2::new(low.x, high.y));
        [[low, beside, below], [beside, high, below]]
    }

    fn all_edges(&mut self) {
        for edge in &self.edges {
            let worst = self.worst.less(edge.between);
            for stretch in &edge.stretches {
                stretch.meet(&self.relief, &worst);
            }
            self.worst.grow(&worst, edge.between);
        }
    }
}

fn ordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// How far a point is from the nearest one of an edge, as seen from above, and how high above that.
fn beside_edge(point: DVec3, up: DVec3, [p, q]: [DVec3; 2]) -> [f64; 2] {
    let level = |way: DVec3| way - up * up.dot(way);
    let along = level(q - p);
    let share = level(point - p).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    let from_edge = point - p.lerp(q, share.clamp(0.0, 1.0));
    [level(from_edge).length(), up.dot(from_edge)]
}

/// A triangle in space.
struct Plane<'a> {
    certifier: &'a Certifier<'a>,
    corners: [DVec3; 3],
    /// Twice its area long.
    normal: DVec3,
}

impl Plane<'_> {
    /// Metres by which it falls over a metre along the ground, at its first corner.
    fn steepness(&self) -> f64 {
        let up = self.corners[0].normalize();
        (self.normal.cross(up).length() / self.normal.dot(up)).abs()
    }

    /// Height of a point of the surface above the triangle, and the point.
    #[inline(always)]
    fn difference(&self, at: DVec2, height: f64) -> (f64, DVec3, DVec3) {
        let (up, point) = self.certifier.above(at, height);
        (
            self.normal.dot(point - self.corners[0]) / self.normal.dot(up),
            up,
            point,
        )
    }

    /// Its sides, and how far, times the side's length, a place is beyond each at least that is not beside it.
    fn sides(&self) -> [(DVec3, DVec3, f64); 3] {
        let [a, b, c] = self.corners;
        let level = a.normalize();
        [(a, b), (b, c), (c, a)].map(|(p, q)| (p, q, -BESIDE * (q - p).cross(level).length()))
    }

    /// Whether all of a block is beside one of the triangle's `sides`.
    fn is_beside(&self, sides: &[(DVec3, DVec3, f64); 3], curvature: &Curvature, block: &Block) -> bool {
        let [bend, share] = curvature.beside_block(block.side);
        let corners = block.corners().map(|at| self.certifier.above(at, 0.0));
        self.certifier.reaches(block)
            && sides.iter().any(|&(p, q, least)| {
                let beyond = corners.map(|(up, point)| up.dot((p - point).cross(q - point)));
                let [nearest, farthest] = [
                    beyond.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                    beyond.iter().copied().fold(f64::INFINITY, f64::min),
                ];
                nearest + bend * p.distance(q) + share * farthest.abs() < least
            })
    }

    /// Takes the differences at samples under the triangle into account; `grid` is where it may be, and what is beside it,
    /// too, if it `is_wide`.
    fn meet(
        &self,
        relief: &Relief,
        curvature: &Curvature,
        grid: [DVec2; 3],
        margin: f64,
        worst: &Worst,
        is_wide: bool,
    ) {
        let steepness = self.steepness();
        let per_squared_side = curvature.in_block(1.0, steepness);
        // A sample beside the triangle is compared with the nearest place of its sides, which the plane may be this far above or below.
        let beside = steepness * BESIDE;
        let sides = self.sides();
        // At a sample, if it is under the triangle.
        let look = |difference: f64, up: DVec3, point: DVec3| {
            if difference.abs() + beside <= worst.get() {
                return;
            }
            // A plane may be so steep that it says nothing of what is beside the triangle, however near.
            let mut nearest: Option<[f64; 2]> = None;
            for &(p, q, least) in &sides {
                let beyond = up.dot((p - point).cross(q - point));
                if beyond < least {
                    return;
                }
                if beyond < 0.0 {
                    let beside = beside_edge(point, up, [p, q]);
                    nearest = Some(nearest.filter(|nearest| nearest[0] <= beside[0]).unwrap_or(beside));
                }
            }
            match nearest {
                None => worst.meet(difference.abs()),
                // Beyond the tip of a thin triangle places are beside none of its sides.
                Some([apart, above]) if apart <= BESIDE => worst.meet(above.abs()),
                Some(_) => {}
            }
        };
        let may_matter = |block: &Block| {
            if !self.certifier.reaches(block) {
                return true;
            }
            let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
            for (at, height) in block.corners().into_iter().zip(block.patch) {
                let (difference, up, point) = self.difference(at, height);
                least = least.min(difference);
                greatest = greatest.max(difference);
                // What is found early on spares a look at what is no worse.
                if block.is_sampled {
                    look(difference, up, point);
                }
            }
            let between = per_squared_side * block.side * block.side + beside;
            let size = (greatest + block.residual[1]).max(-(least + block.residual[0]));
            worst.may_grow(size + between)
                && !(is_wide && self.is_beside(&sides, curvature, block))
                && worst.is_worth_a_look(size + between)
        };
        let nearly = self.nearly(curvature, grid, margin);
        relief.visit_samples(grid, margin, may_matter, |at, height| {
            if !worst.may_grow(nearly.largest_difference(at, height) + beside) {
                return;
            }
            let (difference, up, point) = self.difference(at, height);
            look(difference, up, point);
        });
    }

    /// The plane's heights over a square around a triangle on the grid, bilinear between its corners.
    fn nearly(&self, curvature: &Curvature, grid: [DVec2; 3], margin: f64) -> Nearly {
        let [a, b, c] = grid;
        // Places of whole columns and rows are known.
        let low = (a.min(b).min(c) - margin).floor().max(DVec2::ZERO);
        let high = (a.max(b).max(c) + margin).ceil();
        let mut square = Block {
            first: low,
            side: (high - low).max_element().max(1.0),
            patch: [0.0; 4],
            residual: [0.0; 2],
            is_sampled: false,
        };
        square.patch = square.corners().map(|at| -self.difference(at, 0.0).0);
        let is_known = self.certifier.reaches(&square);
        Nearly {
            between: if is_known {
                curvature.in_block(square.side, self.steepness())
            } else {
                f64::INFINITY
            },
            square,
        }
    }
}

/// Heights of a triangle's plane above the ellipsoid, but for what curvature adds.
struct Nearly {
    square: Block,
    /// Metres that curvature may add.
    between: f64,
}

impl Nearly {
    /// What the height of the surface at a place may be off, at most.
    #[inline(always)]
    fn largest_difference(&self, at: DVec2, height: f64) -> f64 {
        (height - self.square.height(at)).abs() + self.between
    }
}

#[cfg(test)]
#[path = "certify_tests.rs"]
mod tests;
