//! Levels from what a file keeps of them, checked; and which of their patches meet.

use std::collections::HashMap;
use std::ops::Range;

use thiserror::Error;

use crate::curved::curve_twins::{Curve, curves};
use crate::curved::levels::{CurvedLevels, LevelPatch};
use crate::curved::patch::CubicPatch;

/// Why patches make no levels.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum LevelsError {
    /// A patch that belongs to no level, or to one that is not there.
    #[error("patch {0} belongs to no level, or to one that is not there")]
    Lifetime(usize),
    /// A level without patches.
    #[error("level {0} is empty")]
    Empty(u32),
    /// Two patches of one level on the same side of one curve.
    #[error("patches {0} and {1} are on the same side of one curve")]
    SameSide(usize, usize),
    /// A control point or an error is not finite, or an error is below 0.
    #[error("patch {0} has a number that is not finite, or an error below 0")]
    NotFinite(usize),
}

impl LevelPatch {
    /// The levels that show it.
    #[must_use]
    pub fn levels(&self) -> Range<u32> {
        self.born..self.died
    }

    /// The same, shown by other levels.
    #[must_use]
    pub fn shown_by(self, levels: Range<u32>) -> Self {
        Self {
            born: levels.start,
            died: levels.end,
            ..self
        }
    }

    /// The same with another surface.
    #[must_use]
    pub fn with(self, patch: CubicPatch, error: f64) -> Self {
        Self { patch, error, ..self }
    }

    /// A patch that no level shows yet.
    #[must_use]
    pub fn new(patch: CubicPatch, corners: [u32; 3], creases: [bool; 3], error: f64) -> Self {
        Self {
            patch,
            corners,
            creases,
            error,
            born: 0,
            died: 0,
        }
    }

    fn is_finite(&self) -> bool {
        self.patch.points.iter().all(|point| point.is_finite()) && self.error.is_finite() && self.error >= 0.0
    }
}

impl CurvedLevels {
    /// Levels of patches that belong to the levels that they say.
    ///
    /// # Errors
    /// Where they are not such that every level can be drawn.
    pub fn from_patches(patches: Vec<LevelPatch>, level_count: u32) -> Result<Self, LevelsError> {
        let mut is_shown = vec![0_i64; level_count as usize + 1];
        for (index, patch) in patches.iter().enumerate() {
            if patch.levels().is_empty() || patch.died > level_count {
                return Err(LevelsError::Lifetime(index));
            }
            if !patch.is_finite() {
                return Err(LevelsError::NotFinite(index));
            }
            is_shown[patch.born as usize] += 1;
            is_shown[patch.died as usize] -= 1;
        }
        let mut shown = 0;
        for level in 0..level_count {
            shown += is_shown[level as usize];
            if shown == 0 {
                return Err(LevelsError::Empty(level));
            }
        }
        check_sides(&patches)?;
        Ok(Self::new(patches, level_count))
    }
}

/// Each side of a curve has one patch at most, at any level.
fn check_sides(patches: &[LevelPatch]) -> Result<(), LevelsError> {
    let mut sides: HashMap<Curve, Vec<usize>> = HashMap::with_capacity(3 * patches.len());
    for (index, patch) in patches.iter().enumerate() {
        for curve in curves(patch.corners, &patch.patch) {
            sides.entry(curve).or_default().push(index);
        }
    }
    let mut shared: Vec<Vec<usize>> = sides.into_values().filter(|on_side| on_side.len() > 1).collect();
    shared.sort_unstable();
    for mut on_side in shared {
        on_side.sort_by_key(|&index| patches[index].born);
        if let Some(pair) = on_side
            .windows(2)
            .find(|pair| patches[pair[0]].died > patches[pair[1]].born)
        {
            return Err(LevelsError::SameSide(pair[0], pair[1]));
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "level_record_tests.rs"]
mod tests;
