//! What a person is told of samples that can hardly be heights.

use std::path::Path;

use super::error::ReadError;
use crate::progress::Progress;
use crate::samples::Extremes;

/// No terrain on any planet is higher or deeper; what is beyond is a void that the file does not declare.
pub(super) const HIGHEST: f64 = 100_000.0;
/// Metres; the Challenger Deep is at −10,935 (Greenaway et al., 2021). Lower samples are kept, with a remark.
const DEEPEST: f32 = -11_000.0;
/// Metres below all others from which on a lowest sample is remarked.
const FAR_BELOW: f32 = 500.0;

/// Remarks on samples that became void because they cannot be heights, counted by file, and on lowest samples that stand out.
///
/// # Errors
/// When no sample has a height.
pub(super) fn remark(
    paths: &[&Path],
    extremes: Option<Extremes>,
    wild: &[usize],
    progress: &Progress,
) -> Result<(), ReadError> {
    for (path, wild) in paths.iter().zip(wild).filter(|&(_, &wild)| wild > 0) {
        let (path, kilometres) = (path.display(), HIGHEST / 1000.0);
        progress.note(&format!(
            "{path}: {wild} samples are infinite or beyond ±{kilometres} km and count as voids; is a nodata value missing?"
        ));
    }
    if let Some(note) = extremes.as_ref().and_then(note_of_low) {
        progress.note(&note);
    }
    match paths.first() {
        Some(first) if extremes.is_none() => Err(ReadError::AllVoid(first.to_path_buf())),
        _ => Ok(()),
    }
}

/// A remark on lowest samples that are likely to stand for voids: below every sea floor, or several alike and farther below all
/// others than these are apart.
fn note_of_low(extremes: &Extremes) -> Option<String> {
    let &Extremes {
        lowest,
        lowest_count: count,
        second_lowest,
        highest,
    } = extremes;
    let is_apart = second_lowest.is_some_and(|second| {
        let gap = second - lowest;
        count > 1 && gap > FAR_BELOW && gap > highest - second
    });
    let why = match () {
        () if lowest < DEEPEST => "below every sea floor",
        () if is_apart => "far below all others",
        () => return None,
    };
    Some(format!(
        "samples at {lowest} m, {why}: {count}; they are taken for heights. If {lowest} means that there is none, say so in the \
         file: gdal_edit.py -a_nodata {lowest} FILE"
    ))
}

#[cfg(test)]
#[path = "remark_tests.rs"]
mod tests;
