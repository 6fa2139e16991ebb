//! The heights that one free vertex may take: a linear programme in one unknown, and the best of its answers.

use glam::DVec2;

use crate::height_field::bilinear::Piece;
use crate::height_field::flat::GridPoint;
use crate::height_field::reference::Reference;
use crate::height_field::triangulate::stepped;

/// Weights below this count as none: the free vertex does not move such a point.
const LEAST_WEIGHT: f64 = 1e-9;

/// Heights that keep every constrained point within the tolerance, and the sums for the one of least squares.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub(crate) tolerance: f64,
    low: f64,
    high: f64,
    weights: f64,
    weighted: f64,
    squares: f64,
}

impl Interval {
    /// No height at all.
    pub(crate) fn empty(tolerance: f64) -> Self {
        Self {
            low: f64::INFINITY,
            ..Self::new(tolerance, Some(f64::NEG_INFINITY))
        }
    }

    /// All heights, or `only` one.
    pub(crate) fn new(tolerance: f64, only: Option<f64>) -> Self {
        Self {
            tolerance,
            low: only.unwrap_or(f64::NEG_INFINITY),
            high: only.unwrap_or(f64::INFINITY),
            weights: 0.0,
            weighted: 0.0,
            squares: 0.0,
        }
    }

    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.low > self.high
    }

    #[inline(always)]
    pub(crate) fn is_single(&self) -> bool {
        self.low == self.high
    }

    /// `weight · height` must come within the tolerance of `target`. Tells whether that raises the lowest height allowed, and
    /// whether it lowers the highest.
    #[inline(always)]
    pub(crate) fn constrain(&mut self, weight: f64, target: f64) -> [bool; 2] {
        // A weight of nearly nothing leaves nothing or everything allowed, by the sign of what is left of the tolerance.
        let weight = if weight > LEAST_WEIGHT { weight } else { LEAST_WEIGHT };
        let (low, high) = (target - self.tolerance, target + self.tolerance);
        let tightens = [low > self.low * weight, high < self.high * weight];
        // Few points do: the others need no division.
        if tightens[0] {
            self.low = low / weight;
        }
        if tightens[1] {
            self.high = high / weight;
        }
        tightens
    }

    /// Metres between the heights that the points so far ask for, where no height does for all of them.
    pub(crate) fn gap(&self) -> f64 {
        self.low - self.high
    }

    /// Lets a point count in the least squares.
    #[inline(always)]
    pub(crate) fn add_square(&mut self, weight: f64, target: f64) {
        self.weights += weight * weight;
        self.weighted += weight * target;
        self.squares += target * target;
    }

    /// An allowed height, a multiple of `step`: half-way between that of least squares and the middle of what is allowed,
    /// which leaves room to collapses nearby; `present` where nothing tells.
    pub(crate) fn best(&self, present: f64, step: f64) -> Option<f64> {
        if self.is_empty() {
            return None;
        }
        if self.is_single() {
            return Some(self.low);
        }
        let fitted = if self.weights > 0.0 {
            self.weighted / self.weights
        } else {
            present
        };
        let middle = self.low / 2.0 + self.high / 2.0;
        let fitted = fitted.clamp(self.low, self.high);
        let wanted = if middle.is_finite() {
            (fitted + middle) / 2.0
        } else {
            fitted
        };
        let nearest = stepped(wanted, step);
        let candidates = [nearest, nearest + step, nearest - step];
        candidates
            .into_iter()
            .find(|height| (self.low..=self.high).contains(height))
    }

    /// Sum of the squares of the differences that a height leaves.
    pub(crate) fn squares_at(&self, height: f64) -> f64 {
        self.squares - 2.0 * height * self.weighted + height * height * self.weights
    }

    /// Constrains the vertex at `centre` by the surface along its edges to `ends`, at the ends and the middle of each piece,
    /// until no height is left; notes the pieces, with the height at the end, for an exact check of the height found.
    pub(crate) fn constrain_by_edges(
        &mut self,
        reference: &Reference,
        centre: DVec2,
        ends: &[GridPoint],
        pieces: &mut Vec<(Piece, f64)>,
    ) {
        for &end in ends {
            if self.is_empty() {
                return;
            }
            self.constrain_by_edge(reference, centre, end, pieces);
        }
    }

    fn constrain_by_edge(
        &mut self,
        reference: &Reference,
        centre: DVec2,
        end: GridPoint,
        pieces: &mut Vec<(Piece, f64)>,
    ) {
        let mut passed = f64::NAN;
        reference.visit_pieces(centre, end.grid, |piece| {
            let middle = (piece.start + piece.end) / 2.0;
            if piece.start != passed {
                self.constrain(1.0 - piece.start, piece.first - piece.start * end.height);
            }
            self.constrain(1.0 - middle, piece.middle() - middle * end.height);
            self.constrain(1.0 - piece.end, piece.last - piece.end * end.height);
            self.add_square(1.0 - piece.end, piece.last - piece.end * end.height);
            self.add_square(1.0 - middle, piece.middle() - middle * end.height);
            passed = piece.end;
            pieces.push((piece, end.height));
        });
    }

    /// Checks a height at every point of the pieces; where it fails at a summit, constrains by that. Tells whether it
    /// failed.
    pub(crate) fn cut(&mut self, pieces: &[(Piece, f64)], height: f64) -> bool {
        let mut has_failed = false;
        for (piece, end) in pieces {
            if piece.deviation(height, *end) > self.tolerance {
                has_failed = true;
                let (t, target) = piece.summit_from(height, *end);
                self.constrain(1.0 - t, target - t * end);
            }
        }
        has_failed
    }
}
