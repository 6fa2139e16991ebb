//! What a person is told of samples that can hardly be heights.

use std::path::Path;

use super::error::ReadError;
use crate::progress::Progress;

/// No terrain on any planet is higher or deeper; what is beyond is a void that the file does not declare.
pub(super) const HIGHEST: f64 = 100_000.0;
/// Metres; the Challenger Deep is at −10,935 (Greenaway et al., 2021). Lower samples are kept, with a remark.
const DEEPEST: f32 = -11_000.0;

/// Remarks on samples that became void because they cannot be heights, counted by file, and on a lowest sample below every sea
/// floor.
///
/// # Errors
/// When no sample has a height.
pub(super) fn remark(paths: &[&Path], lowest: f32, wild: &[usize], progress: &Progress) -> Result<(), ReadError> {
    for (path, wild) in paths.iter().zip(wild).filter(|&(_, &wild)| wild > 0) {
        let (path, kilometres) = (path.display(), HIGHEST / 1000.0);
        progress.note(&format!(
            "{path}: {wild} samples are infinite or beyond ±{kilometres} km and count as voids; is a nodata value missing?"
        ));
    }
    if lowest < DEEPEST {
        let note = format!("the lowest sample is {lowest} m, below every sea floor; is a nodata value missing?");
        progress.note(&note);
    }
    match paths.first() {
        Some(first) if !lowest.is_finite() => Err(ReadError::AllVoid(first.to_path_buf())),
        _ => Ok(()),
    }
}
