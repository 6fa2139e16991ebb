//! Patches while levels are made: they share their curves, which are stored once for both sides. Vertices never move. So no level
//! has a gap, and a curve tells which patches meet.

use glam::DVec3;

use crate::curved::levels::{CurvedLevels, LevelPatch};
use crate::curved::patch::CubicPatch;

/// Steps of computing with doubles may add up to this share of the largest coordinate.
pub(super) const ROUNDING: f64 = 1e-12;

/// A patch and where it belongs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RecordedPatch {
    /// The control point that no curve has.
    pub(super) centre: DVec3,
    /// No point of it is farther from the model's point that it stands for.
    pub(super) error: f64,
    /// The vertices at its corners.
    pub(super) corners: [u32; 3],
    /// Its curves AB, BC and CA.
    pub(super) curves: [CurveUse; 3],
    /// The first level that has it; level 0 is the model.
    pub(super) born: u32,
    /// The first level after that one that has not.
    pub(super) died: u32,
}

/// A curve in one of its directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CurveUse(u32);

impl CurveUse {
    pub(super) fn new(curve: usize, is_reversed: bool) -> Self {
        Self(2 * curve as u32 + u32::from(is_reversed))
    }

    pub(super) fn curve(self) -> usize {
        self.0 as usize / 2
    }

    pub(super) fn reversed(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// The curve's inner control points in this direction.
    pub(super) fn directed(self, [first, second]: [DVec3; 2]) -> [DVec3; 2] {
        if self.0 % 2 == 1 {
            [second, first]
        } else {
            [first, second]
        }
    }
}

/// What patches have in common.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Frame {
    /// By vertex.
    pub(super) positions: Vec<DVec3>,
    /// The inner control points of each curve.
    pub(super) curves: Vec<[DVec3; 2]>,
    pub(super) is_crease: Vec<bool>,
}

impl Frame {
    /// Adds a curve, for use in its own direction.
    pub(super) fn add(&mut self, inner: [DVec3; 2], is_crease: bool) -> CurveUse {
        self.curves.push(inner);
        self.is_crease.push(is_crease);
        CurveUse::new(self.curves.len() - 1, false)
    }

    /// The inner control points in the direction of use.
    pub(super) fn inner(&self, use_of: CurveUse) -> [DVec3; 2] {
        use_of.directed(self.curves[use_of.curve()])
    }

    pub(super) fn patch(&self, corners: [u32; 3], curves: [CurveUse; 3], centre: DVec3) -> CubicPatch {
        let corners = corners.map(|corner| self.positions[corner as usize]);
        CubicPatch::from_curves(corners, curves.map(|curve| self.inner(curve)), centre)
    }
}

/// The levels that recorded patches belong to, with control points of their own.
pub(super) fn levels_of(frame: &Frame, recorded: &[RecordedPatch], level_count: u32) -> CurvedLevels {
    let largest = frame.positions.iter().map(|at| at.abs().max_element());
    let rounding = ROUNDING * largest.fold(0.0, f64::max);
    let own = |recorded: &RecordedPatch| {
        let &RecordedPatch {
            centre,
            error,
            corners,
            curves,
            born,
            died,
        } = recorded;
        let creases = curves.map(|curve| frame.is_crease[curve.curve()]);
        let error = if error > 0.0 { error + rounding } else { 0.0 };
        LevelPatch::new(frame.patch(corners, curves, centre), corners, creases, error).shown_by(born..died)
    };
    let shown = recorded.iter().filter(|patch| patch.born < patch.died);
    CurvedLevels::new(shown.map(own).collect(), level_count)
}
