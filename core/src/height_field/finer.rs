//! The surface between samples that are only some of all: each 2^level-th column and row. What these allow is held against all
//! of the relief, by branch and bound.

use std::cell::Cell as Worst;

use glam::DVec2;

use crate::height_field::bilinear::{Cell, Piece};
use crate::height_field::blocks::{Block, Relief};
use crate::height_field::flat::{Flat, GridPoint};

/// Share of a tolerance that rounding may add to it.
const ROUNDING: f64 = 1e-6;

/// The relief under a window of samples, of which the window has each 2^level-th column and row.
#[derive(Clone, Copy)]
pub struct Finer<'a> {
    /// All of it, in columns and rows of all samples.
    pub relief: &'a Relief<'a>,
    /// 2^this columns and rows to one of the window's.
    pub level: u8,
    /// Column and row of the window's first sample, in the window's steps.
    pub origin: [usize; 2],
}

/// A place of the surface, and its height in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    pub(crate) at: DVec2,
    pub(crate) height: f64,
}

/// Triangles from a centre to the points of a ring, in the window.
pub(crate) struct FinerFan<'a> {
    pub(crate) centre: GridPoint,
    pub(crate) ring: &'a [GridPoint],
    /// Whether the last point is next to the first.
    pub(crate) is_closed: bool,
    pub(crate) curvature: DVec2,
}

impl std::fmt::Debug for Finer<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Finer")
            .field("level", &self.level)
            .field("origin", &self.origin)
            .finish_non_exhaustive()
    }
}

impl Finer<'_> {
    fn scale(&self) -> f64 {
        f64::from(1_u32 << self.level)
    }

    /// A place of the window among all samples.
    fn whole(&self, at: DVec2) -> DVec2 {
        (at + DVec2::new(self.origin[0] as f64, self.origin[1] as f64)) * self.scale()
    }

    fn in_window(&self, at: DVec2) -> DVec2 {
        at / self.scale() - DVec2::new(self.origin[0] as f64, self.origin[1] as f64)
    }

    /// The place of the sample that is next to one of the window.
    pub(crate) fn nearest_sample(&self, at: DVec2) -> DVec2 {
        self.in_window(self.whole(at).round())
    }

    /// The sample under a triangle that is furthest from it, if that is by more than the tolerance: by how much, and where.
    pub(crate) fn worst_under(
        &self,
        corners: [GridPoint; 3],
        curvature: DVec2,
        tolerance: f64,
    ) -> Option<(f64, DVec2)> {
        let corners = corners.map(|corner| self.whole_point(corner));
        let (size, point) =
            self.beyond_triangle(corners, self.curvature_of(curvature), tolerance * (1.0 + ROUNDING))?;
        Some((size, self.in_window(point.at)))
    }

    /// The place along an edge that is furthest from the surface, if that is by more than the tolerance.
    pub(crate) fn worst_along(&self, ends: [GridPoint; 2], curvature: DVec2, tolerance: f64) -> Option<(f64, DVec2)> {
        let [from, to] = ends.map(|end| self.whole_point(end));
        let (size, point) = self.beyond_edge(from, to, self.curvature_of(curvature), tolerance * (1.0 + ROUNDING))?;
        Some((size, self.in_window(point.at)))
    }

    /// Height of the surface at a place of the window; none in a void.
    pub(crate) fn height(&self, at: DVec2) -> Option<f64> {
        let whole = self.whole(at);
        let (first, corners) = self.relief.cell(whole)?;
        Some(Cell::new(first, corners).height(whole))
    }

    fn whole_point(&self, point: GridPoint) -> GridPoint {
        GridPoint {
            grid: self.whole(point.grid),
            ..point
        }
    }

    /// Of a step among all samples.
    fn curvature_of(&self, curvature: DVec2) -> DVec2 {
        curvature / (self.scale() * self.scale())
    }

    fn place_in_window(&self, point: SurfacePoint) -> SurfacePoint {
        SurfacePoint {
            at: self.in_window(point.at),
            ..point
        }
    }

    /// A sample under a fan that is further from it than the tolerance, if there is one: the worst under one of the triangles.
    pub(crate) fn beyond_under(&self, fan: &FinerFan, tolerance: f64) -> Option<SurfacePoint> {
        let (curvature, limit) = (self.curvature_of(fan.curvature), tolerance * (1.0 + ROUNDING));
        let centre = self.whole_point(fan.centre);
        let around = fan.ring.iter().chain(fan.ring.first().filter(|_| fan.is_closed));
        let found = fan.ring.iter().zip(around.skip(1)).find_map(|(&from, &to)| {
            let corners = [centre, self.whole_point(from), self.whole_point(to)];
            self.beyond_triangle(corners, curvature, limit)
        });
        found.map(|(_, point)| self.place_in_window(point))
    }

    /// The same along one of the edges from the fan's centre.
    pub(crate) fn beyond_along(&self, fan: &FinerFan, tolerance: f64) -> Option<SurfacePoint> {
        let (curvature, limit) = (self.curvature_of(fan.curvature), tolerance * (1.0 + ROUNDING));
        let centre = self.whole_point(fan.centre);
        let mut ends = fan.ring.iter();
        let found = ends.find_map(|&end| self.beyond_edge(centre, self.whole_point(end), curvature, limit));
        found.map(|(_, point)| self.place_in_window(point))
    }

    /// The sample under a triangle that is furthest from it, after by how much.
    fn beyond_triangle(&self, corners: [GridPoint; 3], curvature: DVec2, limit: f64) -> Option<(f64, SurfacePoint)> {
        let flat = Flat::through(corners, curvature)?;
        let worst = Worst::new(limit);
        let mut found = None;
        let may_matter = |block: &Block| {
            let hang = curvature.element_sum() * block.side * block.side / 4.0;
            let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
            for (at, height) in block.corners().into_iter().zip(block.patch) {
                let difference = height - flat.height(at);
                least = least.min(difference);
                greatest = greatest.max(difference);
            }
            greatest + block.residual[1] + hang > worst.get() || least + block.residual[0] < -worst.get()
        };
        self.relief
            .visit_samples(corners.map(|corner| corner.grid), 0.0, may_matter, |at, height| {
                let size = (height - flat.height(at)).abs();
                if size > worst.get() {
                    worst.set(size);
                    found = Some(SurfacePoint { at, height });
                }
            });
        found.map(|point| (worst.get(), point))
    }

    /// The place along an edge that is furthest from the surface, after by how much.
    fn beyond_edge(&self, a: GridPoint, b: GridPoint, curvature: DVec2, limit: f64) -> Option<(f64, SurfacePoint)> {
        let direction = b.grid - a.grid;
        let hang = curvature.dot(direction * direction);
        let hanging = |t: f64| hang * t * (1.0 - t);
        let at = |t: f64| a.grid + direction * t;
        let straight = |t: f64| a.height + t * (b.height - a.height);
        let worst = Worst::new(limit);
        let mut found = None;
        let may_matter = |block: &Block, from: f64, to: f64| {
            let [first, last] = [from, to].map(|t| block.height(at(t)) + hanging(t) - straight(t));
            let step = direction * ((to - from) / block.side);
            let bend = (block.twist() * step.x * step.y).abs() / 4.0 + hang * (to - from) * (to - from) / 4.0;
            first.max(last) + bend + block.residual[1] > worst.get()
                || first.min(last) - bend + block.residual[0] < -worst.get()
        };
        self.relief.visit_stretches(a.grid, b.grid, may_matter, |start, end| {
            let Some((first, corners)) = self.relief.cell(at((start + end) / 2.0)) else {
                return;
            };
            let cell = Cell::new(first, corners);
            let length = end - start;
            let piece = Piece {
                start,
                end,
                first: cell.height(at(start)) + hanging(start),
                last: cell.height(at(end)) + hanging(end),
                bend: cell.bend(direction * length) - hang * length * length,
            };
            let (t, difference) = piece.worst(a.height, b.height);
            if difference.abs() > worst.get() {
                worst.set(difference.abs());
                let height = straight(t) + difference - hanging(t);
                found = Some(SurfacePoint { at: at(t), height });
            }
        });
        found.map(|point| (worst.get(), point))
    }
}
