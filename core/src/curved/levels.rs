//! Curved levels of detail (C-LODs, §8): every patch that ever was, with the levels that it belongs to, so that each level is
//! extracted without the others.
//!
//! Patches are sorted by when they went, latest first. What a level shows is in the prefix of those that were there after it,
//! so that extracting it looks at about as many patches as it has, whatever came before.

use crate::curved::curve_twins;
use crate::curved::model::{CurvedModel, Input};
use crate::curved::patch::CubicPatch;
use crate::topology::half_edges::HalfEdges;

/// A patch and where it belongs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelPatch {
    /// Its control points.
    pub patch: CubicPatch,
    /// The vertices at its corners.
    pub corners: [u32; 3],
    /// Whether each of its curves AB, BC and CA is a crease.
    pub creases: [bool; 3],
    /// Its points are no farther than this from those of the model that they stand for, and the other way round.
    pub error: f64,
    /// The first level that has it; level 0 is the model.
    pub(crate) born: u32,
    /// The first level after that one that has not.
    pub(crate) died: u32,
}

/// A model at every level of detail.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvedLevels {
    patches: Vec<LevelPatch>,
    /// How many patches, at the beginning, were there after each level.
    prefixes: Vec<usize>,
}

impl CurvedLevels {
    /// Sorts patches that `level_count` levels have between them.
    pub(crate) fn new(mut patches: Vec<LevelPatch>, level_count: u32) -> Self {
        patches.sort_by_key(|patch| (std::cmp::Reverse(patch.died), patch.born));
        let prefix = |level| patches.partition_point(|patch| patch.died > level);
        Self {
            prefixes: (0..level_count).map(prefix).collect(),
            patches,
        }
    }

    /// How many levels there are; level 0 is the model, the last is the coarsest.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "the model itself is always there")]
    pub fn len(&self) -> usize {
        self.prefixes.len()
    }

    /// How many patches a level has.
    #[must_use]
    pub fn patch_count(&self, level: usize) -> usize {
        self.level(level).count()
    }

    /// All patches of all levels; those that go last come first.
    #[must_use]
    pub fn patches(&self) -> &[LevelPatch] {
        &self.patches
    }

    /// One level as a model. Its vertices are numbered anew, in the order of their old numbers.
    #[must_use]
    pub fn model(&self, level: usize) -> CurvedModel {
        let shown: Vec<&LevelPatch> = self.level(level).collect();
        let mut vertices: Vec<u32> = shown.iter().flat_map(|patch| patch.corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let number = |corner: u32| vertices.partition_point(|&vertex| vertex < corner) as u32;
        let corners: Vec<[u32; 3]> = shown.iter().map(|patch| patch.corners.map(number)).collect();
        let patches: Vec<CubicPatch> = shown.iter().map(|patch| patch.patch).collect();
        let twins = curve_twins::twins(&corners, &patches);
        CurvedModel {
            patches,
            topology: HalfEdges::with_twins(vertices.len(), corners, twins),
            is_crease: shown.iter().flat_map(|patch| patch.creases).collect(),
            input: Input::Near(shown.iter().map(|patch| patch.error).collect()),
        }
    }

    /// The patches of one level; none past the last.
    pub fn level(&self, level: usize) -> impl Iterator<Item = &LevelPatch> + Clone {
        let count = self.prefixes.get(level).copied().unwrap_or(0);
        let shown = self.patches[..count].iter();
        shown.filter(move |patch| patch.born as usize <= level)
    }

    /// Bytes that the levels take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.patches.as_slice()) + size_of_val(self.prefixes.as_slice())
    }

    /// The largest error of a level's patches: no point of it is farther from the model, and none of the model from it.
    #[must_use]
    pub fn error(&self, level: usize) -> f64 {
        self.level(level).map(|patch| patch.error).fold(0.0, f64::max)
    }
}
