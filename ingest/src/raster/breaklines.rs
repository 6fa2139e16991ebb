//! Lines of vector files that the surface keeps as edges.

use std::path::Path;

use glam::DVec2;

use super::ReadError;
use super::layout::Layout;
use super::vectors::{lines, rings_in};
use crate::georeference::nearest_turn;

/// The lines of a vector file in coordinates of a raster's reference system, in which they are straight between their vertices;
/// degrees go on past the antimeridian.
///
/// Lines for ground that is nowhere on the Earth are in metres of its plane, whatever the file says.
///
/// # Errors
/// When the file cannot be read, or has no place in the raster's reference system.
pub(super) fn breaklines(path: &Path, raster: &Layout) -> Result<Vec<Vec<[f64; 2]>>, ReadError> {
    let laid = raster.crs.is_laid_plane().then_some(&raster.crs);
    let mut found = Vec::new();
    for layer in lines(path, laid)? {
        for of_feature in layer.features {
            let placed = rings_in(&of_feature, &layer.crs, &raster.crs);
            let placed = placed.map_err(|source| ReadError::Position(path.to_owned(), source))?;
            found.extend(placed.into_iter().map(|line| continuous(&line, raster.is_in_degrees)));
        }
    }
    let vertices = || found.iter().flatten().flatten();
    if vertices().any(|coordinate: &f64| !coordinate.is_finite()) {
        return Err(ReadError::unreadable(path, "a coordinate of a line is no number"));
    }
    Ok(found)
}

/// A line whose longitudes, if it has any, do not jump.
fn continuous(line: &[DVec2], is_in_degrees: bool) -> Vec<[f64; 2]> {
    let mut before = line.first().map_or(0.0, |first| first.x);
    let place = |&at: &DVec2| {
        let at = if is_in_degrees { nearest_turn(at, before) } else { at };
        before = at.x;
        at.to_array()
    };
    line.iter().map(place).collect()
}
