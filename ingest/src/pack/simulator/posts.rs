//! Heights of a surface at the posts of one heightmap, and how far what is between posts is from the surface.
//!
//! A program may cut the square between four posts along either diagonal, or take it as bilinear. The three are
//! a + t·max(0, u + v − 1), a + t·min(u, v) and a + t·u·v with one plane a and one twist t, and u·v is always between the other two:
//! so to be near both cuts is to be near all three. Surface and cut are flat but along the surface's edges, the grid's lines and
//! the diagonals; the largest difference is where two of these meet.

use glam::{DVec2, DVec3, UVec2};
use robust::{Coord, orient2d};

use super::grid::Grid;
use super::piece::Piece;

/// One heightmap while it is made.
pub(super) struct Posts {
    grid: Grid,
    tile: UVec2,
    /// Metres along the frame's up, row by row from the south; NaN where there is no ground.
    pub(super) heights: Vec<f32>,
}

impl Posts {
    pub(super) fn empty(grid: &Grid, tile: UVec2) -> Self {
        let count = grid.size as usize * grid.size as usize;
        Self {
            grid: grid.clone(),
            tile,
            heights: vec![f32::NAN; count],
        }
    }

    /// Takes the heights of posts below or above triangles. Of several triangles at a post the highest counts, so that the order in
    /// which pieces come does not.
    pub(super) fn add(&mut self, piece: &Piece) {
        for &triangle in &piece.triangles {
            self.add_triangle(piece.corners(triangle));
        }
    }

    fn add_triangle(&mut self, corners: [DVec3; 3]) {
        let plan = corners.map(DVec3::truncate);
        let Some([first, last]) = self.covered(plan) else {
            return;
        };
        for row in first.y..=last.y {
            for column in first.x..=last.x {
                let at = self.grid.post(self.grid.first(self.tile) + UVec2::new(column, row));
                if let Some(height) = height_at(corners, at) {
                    let post = &mut self.heights[(row * self.grid.size + column) as usize];
                    *post = post.max(height as f32);
                }
            }
        }
    }

    /// The first and the last post of the tile, across and up, that may be inside a triangle.
    fn covered(&self, plan: [DVec2; 3]) -> Option<[UVec2; 2]> {
        let [low, high] = plan
            .iter()
            .fold([plan[0]; 2], |[low, high], &at| [low.min(at), high.max(at)]);
        let [low, high] = [low, high].map(|at| self.in_cells(at));
        let most = f64::from(self.grid.size - 1);
        let (first, last) = (
            (low - 1e-6).ceil().max(DVec2::ZERO),
            (high + 1e-6).floor().min(DVec2::splat(most)),
        );
        first.cmple(last).all().then(|| [first.as_uvec2(), last.as_uvec2()])
    }

    /// Cells from the tile's south-west post.
    fn in_cells(&self, plan: DVec2) -> DVec2 {
        (plan - self.grid.post(self.grid.first(self.tile))) / self.grid.spacing()
    }

    /// Largest difference in metres between a piece and what is between posts, cut either way, where all four posts have ground.
    pub(super) fn difference(&self, piece: &Piece) -> f64 {
        let most = f64::from(self.grid.size - 1);
        let of_edge = |[from, to]: [DVec3; 2]| {
            let [start, end] = [from, to].map(|at| self.in_cells(at.truncate()));
            let is_beside = start.max(end).min_element() < 0.0 || start.min(end).max_element() > most;
            if is_beside {
                return 0.0;
            }
            let at = |part: f64| self.difference_at(start.lerp(end, part), from.z + part * (to.z - from.z));
            crossings(start, end, most).map(at).fold(0.0, f64::max)
        };
        let edges = piece.triangles.iter().map(|&triangle| piece.corners(triangle));
        let edges = edges.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        edges.map(of_edge).fold(0.0, f64::max)
    }

    /// Metres up for a metre across of what is between posts, cut either way, at most.
    pub(super) fn steepest(&self) -> f64 {
        let size = self.grid.size as usize;
        let spacing = self.grid.spacing();
        let slope = |cell: usize| {
            let at = |step: usize| f64::from(self.heights[cell + step]);
            let [southwest, southeast, northwest, northeast] = [at(0), at(1), at(size), at(size + 1)];
            let across = (southeast - southwest).abs().max((northeast - northwest).abs());
            let up = (northwest - southwest).abs().max((northeast - southeast).abs());
            (DVec2::new(across, up) / spacing).length()
        };
        let cells = (0..size * (size - 1)).filter(|cell| cell % size + 1 < size);
        cells.map(slope).fold(0.0, f64::max)
    }

    /// The difference at one point, in cells from the tile's south-west post.
    fn difference_at(&self, cells: DVec2, height: f64) -> f64 {
        let most = f64::from(self.grid.size - 1);
        if cells.min_element() < 0.0 || cells.max_element() > most {
            return 0.0;
        }
        let first = cells.floor().min(DVec2::splat(most - 1.0));
        let DVec2 { x: u, y: v } = cells - first;
        let at = |right: u32, up: u32| {
            let index = (first.y as u32 + up) * self.grid.size + first.x as u32 + right;
            f64::from(self.heights[index as usize])
        };
        let [southwest, southeast, northwest, northeast] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let plane = southwest + u * (southeast - southwest) + v * (northwest - southwest);
        let twist = northeast - southeast - northwest + southwest;
        let cuts = [(u + v - 1.0).max(0.0), u.min(v)].map(|share| plane + twist * share);
        // NaN, where a post has no ground, is the greater of no two numbers.
        cuts.iter().map(|cut| (cut - height).abs()).fold(0.0, f64::max)
    }
}

/// Height of a triangle at a place in plan, if that is inside, or on its outline.
fn height_at(corners: [DVec3; 3], at: DVec2) -> Option<f64> {
    let coord = |place: DVec2| Coord { x: place.x, y: place.y };
    let [a, b, c] = corners.map(|corner| coord(corner.truncate()));
    let at = coord(at);
    let shares = [orient2d(b, c, at), orient2d(c, a, at), orient2d(a, b, at)];
    let whole: f64 = shares.iter().sum();
    let is_inside = whole > 0.0 && shares.iter().all(|&share| share >= 0.0);
    let height = || {
        shares
            .iter()
            .zip(corners)
            .map(|(share, corner)| share / whole * corner.z)
            .sum()
    };
    is_inside.then(height)
}

/// Where the line from `start` to `end` meets lines of the grid and diagonals of its cells, and where it begins and ends, in
/// parts of it; of the grid from 0 to `most` alone.
fn crossings(start: DVec2, end: DVec2, most: f64) -> impl Iterator<Item = f64> {
    let lines = [
        (start.x, end.x, 0.0, most),
        (start.y, end.y, 0.0, most),
        (start.x + start.y, end.x + end.y, 0.0, 2.0 * most),
        (start.x - start.y, end.x - end.y, -most, most),
    ];
    let on = |(from, to, least, greatest): (f64, f64, f64, f64)| {
        let first = from.min(to).max(least).ceil() as i64;
        let last = from.max(to).min(greatest).floor() as i64;
        (first..=last)
            .filter(move |_| from != to)
            .map(move |line| ((line as f64 - from) / (to - from)).clamp(0.0, 1.0))
    };
    lines.into_iter().flat_map(on).chain([0.0, 1.0])
}

#[cfg(test)]
#[path = "posts_tests.rs"]
mod tests;
