//! What a person is told of files, and of samples that can hardly be heights.

use std::collections::BTreeMap;
use std::path::Path;

use super::error::ReadError;
use super::layout::Layout;
use crate::georeference::{Crs, GeoReferenceError, MissingGrids};
use crate::progress::Progress;
use crate::samples::{Extremes, Faults};

/// No terrain on any planet is higher or deeper; what is beyond is a void that the file does not declare.
pub(super) const HIGHEST: f64 = 100_000.0;
/// Metres; Mount Everest is at 8,849, the Challenger Deep at −10,935 (Greenaway et al., 2021), and the geoid is up to 107 m from the
/// ellipsoid. Samples beyond are kept, with a remark.
const PLAUSIBLE: [f32; 2] = [-12_000.0, 9000.0];
/// Metres below all others from which on a lowest sample is remarked.
const FAR_BELOW: f32 = 500.0;

/// Tells what was found in the files before their samples, once for all of which the same is said.
pub(super) fn tell(files: &[&Layout], progress: &Progress) {
    let mut told: BTreeMap<&str, Vec<&Path>> = BTreeMap::new();
    for file in files {
        for remark in &file.remarks {
            told.entry(remark).or_default().push(&file.path);
        }
    }
    for (remark, paths) in told {
        let first = paths[0].display();
        match paths.len() - 1 {
            0 => progress.note(&format!("{first}: {remark}")),
            others => progress.note(&format!("{first} and {others} more: {remark}")),
        }
    }
}

/// Remarks on what cannot be right in files, and on samples that can hardly be heights.
///
/// # Errors
/// When no sample has a height.
pub(super) fn remark(
    paths: &[&Path],
    extremes: Option<Extremes>,
    faults: &[Faults],
    progress: &Progress,
) -> Result<(), ReadError> {
    let notes = paths
        .iter()
        .zip(faults)
        .flat_map(|(path, faults)| notes_of_faults(path, faults));
    notes
        .chain(extremes.iter().flat_map(notes_of_heights))
        .for_each(|note| progress.note(&note));
    match paths.first() {
        Some(first) if extremes.is_none() => Err(ReadError::AllVoid(first.to_path_buf())),
        _ => Ok(()),
    }
}

fn notes_of_faults(path: &Path, faults: &Faults) -> Vec<String> {
    let (path, kilometres) = (path.display(), HIGHEST / 1000.0);
    let &Faults {
        wild,
        disagreeing,
        apart,
        filled,
    } = faults;
    let of_wild = format!("{path}: {wild} samples are infinite or beyond ±{kilometres} km and count as voids");
    let of_overlap = format!(
        "{path}: {disagreeing} samples differ from those of files that count before it, by up to {apart} m; beside these it is bent to \
         meet them"
    );
    let of_filled = format!("{filled} void samples were filled from their rims");
    let notes = [(wild, of_wild), (disagreeing, of_overlap), (filled, of_filled)];
    notes
        .into_iter()
        .filter(|&(count, _)| count > 0)
        .map(|(_, note)| note)
        .collect()
}

fn notes_of_heights(extremes: &Extremes) -> Vec<String> {
    [note_of_low(extremes), note_of_high(extremes), note_of_one(extremes)]
        .into_iter()
        .flatten()
        .collect()
}

fn note_of_high(&Extremes { highest, .. }: &Extremes) -> Option<String> {
    (highest > PLAUSIBLE[1]).then(|| {
        format!(
            "the highest sample is at {highest} m, above every mountain. If heights are not in metres, say it by --unit: decimetre, \
             foot …; if it means that there is none, by --nodata"
        )
    })
}

fn note_of_one(extremes: &Extremes) -> Option<String> {
    let &Extremes {
        lowest,
        lowest_count: count,
        second_lowest,
        ..
    } = extremes;
    (second_lowest.is_none() && count > 1).then(|| format!("all {count} samples with a height are at {lowest} m"))
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
        () if lowest < PLAUSIBLE[0] => "below every sea floor",
        () if is_apart => "far below all others",
        () => return None,
    };
    Some(format!(
        "samples at {lowest} m, {why}: {count}; they are taken for heights. If it means that there is none, say --nodata with the \
         value that the file has"
    ))
}

/// Says what grids would be better than what there is; an error where there is nothing.
pub(super) fn tell_of_missing(crs: &Crs, missing: MissingGrids, progress: &Progress) -> Result<(), GeoReferenceError> {
    let MissingGrids {
        grids,
        accuracy,
        without,
    } = missing;
    let metres =
        |accuracy: Option<f64>| accuracy.map_or("an unknown distance".to_owned(), |metres| format!("{metres} m"));
    let Some(without) = without else {
        let crs = crs.name.clone();
        return Err(GeoReferenceError::MissingGrids { crs, grids });
    };
    progress.note(&format!(
        "places in {} are right within {} by what PROJ has here, within {} with {}",
        crs.name,
        metres(without),
        metres(accuracy),
        grids.join(", ")
    ));
    Ok(())
}

#[cfg(test)]
#[path = "remark_tests.rs"]
mod tests;
