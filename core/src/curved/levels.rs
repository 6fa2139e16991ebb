//! Curved levels of detail (C-LODs, §8): every patch that ever was, tagged with the levels that it belongs to, so that each
//! level is extracted without the others.
//!
//! Patches share what they have in common: vertices never move, and a curve is stored once for the patches on both its sides.
//! So no level has a gap, and a curve tells which patches meet: that is the adjacency, at every level.
//!
//! Patches are sorted by when they went, latest first. What a level shows is in the prefix of those that were there after it.
//! A removal that takes two patches away leaves four new ones at most, so that the prefix of a level is no longer than some
//! three times what it shows.

use glam::DVec3;

use crate::curved::model::CurvedModel;
use crate::curved::patch::CubicPatch;
use crate::topology::half_edges::{HalfEdges, NONE};

/// A patch and where it belongs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LevelPatch {
    /// The control point that no curve has.
    pub(crate) centre: DVec3,
    /// No point of it is farther from the model's point that it stands for.
    pub(crate) error: f64,
    /// The vertices at its corners.
    pub(crate) corners: [u32; 3],
    /// Its curves AB, BC and CA.
    pub(crate) curves: [CurveUse; 3],
    /// The first level that has it; level 0 is the model.
    pub(crate) born: u32,
    /// The first level after that one that has not.
    pub(crate) died: u32,
}

/// A curve in one of its directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct CurveUse(u32);

impl CurveUse {
    pub(crate) fn new(curve: usize, is_reversed: bool) -> Self {
        Self(2 * curve as u32 + u32::from(is_reversed))
    }

    pub(crate) fn curve(self) -> usize {
        self.0 as usize / 2
    }

    pub(crate) fn reversed(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// The curve's inner control points in this direction.
    pub(crate) fn directed(self, [first, second]: [DVec3; 2]) -> [DVec3; 2] {
        if self.0 % 2 == 1 {
            [second, first]
        } else {
            [first, second]
        }
    }
}

/// What patches have in common.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Frame {
    /// By vertex.
    pub(crate) positions: Vec<DVec3>,
    /// The inner control points of each curve.
    pub(crate) curves: Vec<[DVec3; 2]>,
    pub(crate) is_crease: Vec<bool>,
}

impl Frame {
    /// Adds a curve, for use in its own direction.
    pub(crate) fn add(&mut self, inner: [DVec3; 2], is_crease: bool) -> CurveUse {
        self.curves.push(inner);
        self.is_crease.push(is_crease);
        CurveUse::new(self.curves.len() - 1, false)
    }

    /// The inner control points in the direction of use.
    pub(crate) fn inner(&self, use_of: CurveUse) -> [DVec3; 2] {
        use_of.directed(self.curves[use_of.curve()])
    }

    pub(crate) fn patch(&self, corners: [u32; 3], curves: [CurveUse; 3], centre: DVec3) -> CubicPatch {
        let corners = corners.map(|corner| self.positions[corner as usize]);
        CubicPatch::from_curves(corners, curves.map(|curve| self.inner(curve)), centre)
    }
}

/// A model at every level of detail.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvedLevels {
    frame: Frame,
    patches: Vec<LevelPatch>,
    /// How many patches, at the beginning, were there after each level.
    prefixes: Vec<usize>,
    /// What rounding may add to an error.
    rounding: f64,
}

/// Steps of computing with doubles may add up to this share of the largest coordinate.
pub(crate) const ROUNDING: f64 = 1e-12;

impl CurvedLevels {
    /// Sorts patches that `level_count` levels have between them.
    pub(crate) fn new(frame: Frame, mut patches: Vec<LevelPatch>, level_count: u32) -> Self {
        patches.retain(|patch| patch.born < patch.died);
        patches.sort_by_key(|patch| (std::cmp::Reverse(patch.died), patch.born));
        let prefix = |level| patches.partition_point(|patch| patch.died > level);
        let largest = frame.positions.iter().map(|at| at.abs().max_element());
        Self {
            prefixes: (0..level_count).map(prefix).collect(),
            rounding: ROUNDING * largest.fold(0.0, f64::max),
            frame,
            patches,
        }
    }

    /// How many levels there are; level 0 is the model, the last is the coarsest.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "the model itself is always there")]
    pub fn len(&self) -> usize {
        self.prefixes.len()
    }

    /// How many patches a level has; none past the last.
    #[must_use]
    pub fn patch_count(&self, level: usize) -> usize {
        self.shown(level).count()
    }

    /// A bound of how far a level is from the model that was simplified, in the model's units: no point of either is farther
    /// from the other surface.
    #[must_use]
    pub fn error(&self, level: usize) -> f64 {
        let errors = self.shown(level).map(|patch| patch.error);
        match errors.fold(0.0, f64::max) {
            0.0 => 0.0,
            largest => largest + self.rounding,
        }
    }

    /// One level as a model. Its vertices are numbered anew, in the order of their old numbers.
    #[must_use]
    pub fn model(&self, level: usize) -> CurvedModel {
        let shown: Vec<&LevelPatch> = self.shown(level).collect();
        let mut vertices: Vec<u32> = shown.iter().flat_map(|patch| patch.corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let number = |corner: u32| vertices.partition_point(|&vertex| vertex < corner) as u32;
        let corners = shown.iter().map(|patch| patch.corners.map(number)).collect();
        let uses: Vec<CurveUse> = shown.iter().flat_map(|patch| patch.curves).collect();
        let patch = |patch: &&LevelPatch| self.frame.patch(patch.corners, patch.curves, patch.centre);
        CurvedModel {
            patches: shown.iter().map(patch).collect(),
            topology: HalfEdges::with_twins(vertices.len(), corners, twins_of(&uses)),
            is_crease: uses.iter().map(|curve| self.frame.is_crease[curve.curve()]).collect(),
        }
    }

    fn shown(&self, level: usize) -> impl Iterator<Item = &LevelPatch> {
        let count = self.prefixes.get(level).copied().unwrap_or(0);
        let prefix = self.patches[..count].iter();
        prefix.filter(move |patch| patch.born as usize <= level)
    }

    /// Bytes that the levels take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.frame.positions.as_slice())
            + size_of_val(self.frame.curves.as_slice())
            + size_of_val(self.frame.is_crease.as_slice())
            + size_of_val(self.patches.as_slice())
    }
}

/// The half-edges that use a curve in opposite directions.
fn twins_of(uses: &[CurveUse]) -> Vec<u32> {
    let mut sorted: Vec<(CurveUse, u32)> = uses.iter().copied().zip(0..).collect();
    sorted.sort_unstable();
    let mut twins = vec![NONE; uses.len()];
    for pair in sorted.windows(2) {
        let [(one, edge), (other, twin)] = [pair[0], pair[1]];
        if one.curve() == other.curve() {
            twins[edge as usize] = twin;
            twins[twin as usize] = edge;
        }
    }
    twins
}
