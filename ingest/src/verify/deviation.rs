//! Vertical deviation of a mesh from the reference surface: at posts, by the line through each post and the planes of
//! the triangles; between them, along every edge of the mesh.
//!
//! Against a flat triangle a bilinear surface is a bilinear function again, so inside one cell and one triangle its
//! extremes lie at posts, where mesh edges meet grid lines, at mesh vertices, and at one point of each piece of an edge
//! between two grid lines, where the difference is a parabola.
//!
//! ```text
//! for each edge: halve it until a part is nowhere worse than the worst so far, or a chunk of a few cells;
//!     a parabola through three feet is the path of a chunk
//!     for each grid line the path crosses: find where, and correct it once against the true foot
//!     for each piece between two such places: difference at both ends and the middle; at the top of their parabola
//! ```

use std::ops::Range;

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::{above, normal};

use super::source::{Block, Cell, Patch};
use super::space::{Earth, Foot, Space};
use super::surface::{Surface, SurfaceEdge};

/// Posts this near to an edge, in units of the space, lie in the triangles on both sides.
const ON_THE_EDGE: f64 = 1e-6;

/// Cells that a chunk of an edge may span: short enough for a parabola to be its path to a thousandth of a cell.
const CHUNK: f64 = 4.0;

/// Halvings of such a chunk where it is none even so, at most.
const HALVINGS: u32 = 24;

/// The largest figure met, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Worst {
    pub(super) figure: f64,
    /// Grid position.
    pub(super) place: DVec2,
}

impl Worst {
    pub(super) fn meet(&mut self, figure: f64, place: DVec2) {
        // A figure that is no number is worse than any.
        let figure = if figure.is_nan() { f64::INFINITY } else { figure.abs() };
        if figure > self.figure {
            *self = Self { figure, place };
        }
    }

    pub(super) fn max(self, other: Self) -> Self {
        if other.figure > self.figure { other } else { self }
    }
}

/// Calls `visit` for every post of a patch that is looked at, its place among these, and every triangle over it with the deviation
/// there: height of the mesh minus height of the post, along the vertical; `NaN` at voids. `verticals` are those of these posts.
pub(super) fn visit_posts(
    space: &impl Space,
    patch: &Patch,
    verticals: &[DVec3],
    surface: &Surface,
    mut visit: impl FnMut((usize, usize), usize, f64),
) {
    let block = &patch.block;
    for (triangle, footprint) in surface.over(block) {
        let facet = Facet::new(surface.corners(triangle));
        for row in footprint.rows(&block.rows) {
            for (column, index) in patch.posts_of(row, footprint.columns(row, &block.columns)) {
                let (height, up) = (patch.height(column, row), verticals[index]);
                let known = if height.is_finite() { height } else { 0.0 };
                let position = space.position(column, row, up, known);
                let seen_from = space.beside_a_pole(column, row, up, known).unwrap_or((position, up));
                if let Some(meeting) = facet.meeting(seen_from, space.is_round()) {
                    let above = facet.height_above(position, up, &meeting);
                    visit((column, row), index, if height.is_finite() { above } else { f64::NAN });
                }
            }
        }
    }
}

/// Whether some triangle is over a grid position.
pub(super) fn is_covered(earth: &Earth, surface: &Surface, grid: DVec2) -> bool {
    let place = earth.source.georeference.geographic(grid);
    let up = normal(place.x, place.y);
    let near = Block::between(grid, grid, earth.source.size());
    let line = (above(up, 0.0), up);
    let is_met = |triangle| {
        Facet::new(surface.corners(triangle))
            .meeting(line, earth.is_round())
            .is_some()
    };
    surface.over(&near).any(|(triangle, _)| is_met(triangle))
}

/// A triangle with what every post asks of it.
struct Facet {
    corners: [DVec3; 3],
    normal: DVec3,
}

/// How a post lies to a triangle.
enum Meeting {
    Inside,
    /// A hair outside: on this edge, from corner to corner.
    On([usize; 2]),
}

impl Facet {
    fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        Self {
            corners,
            normal: (b - a).cross(c - a),
        }
    }

    /// How the line along `up` through `position` meets the triangle, if it does; not where that is seen as a line from above, as where
    /// two corners are at a pole, for its edges say all then. From below on a plane only, not through the Earth.
    fn meeting(&self, (position, up): (DVec3, DVec3), from_above: bool) -> Option<Meeting> {
        let area = self.normal.dot(up);
        let sign = if area < 0.0 { -1.0 } else { 1.0 };
        let corners = self.corners.map(|corner| corner - position);
        let mut meeting = Meeting::Inside;
        let mut widest: f64 = 0.0;
        for edge in [[0, 1], [1, 2], [2, 0]] {
            let [from, to] = edge.map(|corner| corners[corner]);
            // As long as it is seen from above, however steep.
            let tolerance = (to - from).cross(up).length() * ON_THE_EDGE;
            widest = widest.max(tolerance);
            let side = sign * up.dot(from.cross(to));
            if side < -tolerance {
                return None;
            }
            if side < 0.0 {
                meeting = Meeting::On(edge);
            }
        }
        let is_seen = area > widest || !from_above && area < -widest;
        is_seen.then_some(meeting)
    }

    /// How far along `up` from `position` the triangle is. On an edge the edge says so: a plane may be too steep for that.
    fn height_above(&self, position: DVec3, up: DVec3, meeting: &Meeting) -> f64 {
        match *meeting {
            Meeting::Inside => self.normal.dot(self.corners[0] - position) / self.normal.dot(up),
            Meeting::On(edge) => {
                let [from, to] = edge.map(|corner| self.corners[corner] - position);
                let flat = |vector: DVec3| vector - up * vector.dot(up);
                let along = flat(to - from);
                let part = -flat(from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
                up.dot(from + (to - from) * part.clamp(0.0, 1.0))
            }
        }
    }
}

/// The worst deviation along the edges of the mesh, its vertices among them, in the cells of a block, and of `so_far`: what is surely
/// no worse is passed over.
pub(super) fn along_edges(space: &impl Space, patch: &Patch, surface: &Surface, so_far: Worst) -> Worst {
    let mut worst = so_far;
    for foot in &surface.feet {
        patch
            .cells_at(foot.grid)
            .for_each(|cell| worst.meet(foot.height - cell.height(foot.grid), foot.grid));
    }
    // An edge between two vertices at a pole is seen as a point.
    let is_seen = |edge: &&SurfaceEdge| {
        !edge
            .ends
            .iter()
            .all(|&end| space.is_singular(surface.positions[end as usize]))
    };
    for edge in surface.edges_near(&patch.block).filter(is_seen) {
        Edge::new(space, surface, edge).measure(patch, &mut worst);
    }
    worst
}

/// A straight edge of the mesh, by a parameter from 0 to 1.
struct Edge<'a, S: Space> {
    space: &'a S,
    from: DVec3,
    along: DVec3,
    feet: [Foot; 2],
    chunks: usize,
    /// How many cells it may stray from the straight path between its feet.
    margin: f64,
}

impl<'a, S: Space> Edge<'a, S> {
    fn new(space: &'a S, surface: &Surface, edge: &SurfaceEdge) -> Self {
        let (positions, feet) = surface.ends(space, edge.ends);
        let span = (feet[1].grid - feet[0].grid).abs().max_element();
        Self {
            space,
            from: positions[0],
            along: positions[1] - positions[0],
            feet,
            chunks: (span / CHUNK).ceil().clamp(1.0, 1e6) as usize,
            margin: edge.margin,
        }
    }

    fn measure(&self, patch: &Patch, worst: &mut Worst) {
        self.measure_chunks(patch, 0..self.chunks, self.feet, worst);
    }

    fn measure_chunks(&self, patch: &Patch, chunks: Range<usize>, ends: [Foot; 2], worst: &mut Worst) {
        if !self.is_near(&patch.block, &chunks) || self.is_no_worse(patch, &chunks, ends, worst) {
            return;
        }
        if chunks.len() == 1 {
            let parameters = [chunks.start, chunks.end].map(|chunk| self.parameter(chunk));
            self.measure_stretch(patch, parameters, ends, HALVINGS, worst);
            return;
        }
        let middle = usize::midpoint(chunks.start, chunks.end);
        let foot = self.foot(self.parameter(middle));
        self.measure_chunks(patch, chunks.start..middle, [ends[0], foot], worst);
        self.measure_chunks(patch, middle..chunks.end, [foot, ends[1]], worst);
    }

    /// Whether the deviation on some chunks is surely no worse than the worst so far. It changes from the ends to the middle by no more
    /// than the edge's height and the ground, which is nowhere steeper than known.
    fn is_no_worse(&self, patch: &Patch, chunks: &Range<usize>, ends: [Foot; 2], worst: &Worst) -> bool {
        let at_end = |foot: Foot| patch.cells_at(foot.grid).next().map(|cell| difference(&cell, foot));
        let (Some(steepest), Some(from), Some(to)) = (patch.steepest, at_end(ends[0]), at_end(ends[1])) else {
            return false;
        };
        let part = chunks.len() as f64 / self.chunks as f64;
        // A path strays with the square of its length, and from a line along one axis there and back.
        let stray = 2.0 * self.margin * (2.0 * part).powi(2).min(1.0);
        let cells = (ends[1].grid - ends[0].grid).abs().element_sum() + 2.0 * stray;
        let rise = (ends[1].height - ends[0].height).abs();
        let sag = self.space.sag(self.along.length() * part);
        (from + to).abs() / 2.0 + (rise + steepest * cells) / 2.0 + sag <= worst.figure
    }

    /// Whether some chunks may come into the cells of a block.
    fn is_near(&self, block: &Block, chunks: &Range<usize>) -> bool {
        let at = |chunk: usize| self.feet[0].grid.lerp(self.feet[1].grid, self.parameter(chunk));
        let (a, b) = (at(chunks.start), at(chunks.end));
        block.is_near(a.min(b) - self.margin, a.max(b) + self.margin)
    }

    /// Where a chunk begins.
    fn parameter(&self, chunk: usize) -> f64 {
        chunk as f64 / self.chunks as f64
    }

    fn foot(&self, parameter: f64) -> Foot {
        self.space.foot(self.from + self.along * parameter)
    }

    /// A stretch of the edge, cut in halves as long as no parabola is its path: beside a pole.
    fn measure_stretch(
        &self,
        patch: &Patch,
        [start, end]: [f64; 2],
        ends: [Foot; 2],
        halvings: u32,
        worst: &mut Worst,
    ) {
        let half = (start + end) / 2.0;
        let middle = self.foot(half);
        let paths = [0, 1].map(|axis| Path::through([ends[0], middle, ends[1]].map(|foot| foot.grid[axis])));
        if halvings > 0 && !self.follows([start, end], &paths) {
            self.measure_stretch(patch, [start, half], [ends[0], middle], halvings - 1, worst);
            self.measure_stretch(patch, [half, end], [middle, ends[1]], halvings - 1, worst);
            return;
        }
        let at = |part: f64| start + (end - start) * part;
        let mut points = vec![(start, ends[0]), (end, ends[1])];
        for (axis, path) in paths.iter().enumerate() {
            for (part, line) in path.crossings() {
                let mut parameter = at(part);
                let mut foot = self.foot(parameter);
                if let Some(step) = path.correction(part, line - foot.grid[axis]) {
                    parameter = at((part + step).clamp(0.0, 1.0));
                    foot = self.foot(parameter);
                }
                points.push((parameter, foot));
            }
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        for piece in points.windows(2) {
            self.measure_piece(patch, [piece[0], piece[1]], worst);
        }
    }

    /// Whether a stretch is close to the parabola through its ends and its middle: what is nearly straight is.
    fn follows(&self, [start, end]: [f64; 2], paths: &[Path; 2]) -> bool {
        const NEARLY_STRAIGHT: f64 = 0.05;
        const CLOSE: f64 = 1e-3;
        let is_straight = paths.iter().all(|path| path.bend.abs() / 4.0 <= NEARLY_STRAIGHT);
        is_straight
            || [0.25, 0.75].into_iter().all(|part| {
                let foot = self.foot(start + (end - start) * part);
                (0..2).all(|axis| (paths[axis].value(part) - foot.grid[axis]).abs() <= CLOSE)
            })
    }

    /// The difference on a piece inside one cell: at its ends, its middle, and the top of the parabola through them.
    fn measure_piece(&self, patch: &Patch, ends: [(f64, Foot); 2], worst: &mut Worst) {
        let [(start, first), (end, last)] = ends;
        let middle = self.foot((start + end) / 2.0);
        for cell in patch.cells_at(middle.grid) {
            let differences = [first, middle, last].map(|foot| difference(&cell, foot));
            for (foot, figure) in [first, middle, last].into_iter().zip(differences) {
                worst.meet(figure, foot.grid);
            }
            let path = Path::through(differences);
            // Worth a look only where the parabola comes near to the worst so far.
            let top = path
                .turning_point()
                .filter(|&part| path.value(part).abs() > 0.99 * worst.figure);
            if let Some(part) = top {
                let foot = self.foot(start + (end - start) * part);
                worst.meet(difference(&cell, foot), foot.grid);
            }
        }
    }
}

fn difference(cell: &Cell, foot: Foot) -> f64 {
    foot.height - cell.height(foot.grid)
}

/// The parabola `constant + slope·s + bend·s²` over s from 0 to 1.
#[derive(Clone, Copy, Debug)]
struct Path {
    constant: f64,
    slope: f64,
    bend: f64,
}

impl Path {
    /// Through values at 0, ½ and 1.
    fn through([start, middle, end]: [f64; 3]) -> Self {
        let bend = 2.0 * (start + end) - 4.0 * middle;
        Self {
            constant: start,
            slope: end - start - bend,
            bend,
        }
    }

    fn value(self, s: f64) -> f64 {
        self.constant + s * (self.slope + s * self.bend)
    }

    /// Where it turns, if between the ends.
    fn turning_point(self) -> Option<f64> {
        let turn = -self.slope / (2.0 * self.bend);
        (turn > 0.0 && turn < 1.0).then_some(turn)
    }

    /// Where it passes whole numbers, and which.
    fn crossings(self) -> Vec<(f64, f64)> {
        let turn = self.turning_point().unwrap_or(1.0);
        // No path of a chunk crosses more; a wild one comes from points that are nowhere near the raster.
        const MOST: usize = 64;
        let mut crossings = Vec::new();
        for (start, end) in [(0.0, turn), (turn, 1.0)] {
            let (low, high) = (
                self.value(start).min(self.value(end)),
                self.value(start).max(self.value(end)),
            );
            let lines = low.ceil() as i64..=high.floor() as i64;
            crossings.extend(
                lines
                    .take(MOST)
                    .map(|line| (self.solve(line as f64, start, end), line as f64)),
            );
        }
        crossings
    }

    /// Where it is `value` between `start` and `end`, on which it is monotone.
    fn solve(self, value: f64, start: f64, end: f64) -> f64 {
        let constant = self.constant - value;
        let root = (self.slope * self.slope - 4.0 * self.bend * constant).max(0.0).sqrt();
        // The larger one of the roots times the bend: nothing cancels out.
        let sum = -(self.slope + root.copysign(self.slope)) / 2.0;
        let nearly = start - 1e-9..=end + 1e-9;
        let between = [constant / sum, sum / self.bend]
            .into_iter()
            .find(|s| nearly.contains(s));
        between.unwrap_or((start + end) / 2.0).clamp(start, end)
    }

    /// How far to go on from `s` to make up for `missing`: one step of Newton, none where it is flat or near enough.
    fn correction(self, s: f64, missing: f64) -> Option<f64> {
        const NEAR_ENOUGH: f64 = 1e-8;
        let step = missing / (self.slope + 2.0 * self.bend * s);
        (missing.abs() > NEAR_ENOUGH && step.abs() < 0.1).then_some(step)
    }
}

#[cfg(test)]
#[path = "deviation_tests.rs"]
mod tests;
