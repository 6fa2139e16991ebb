//! STL, text or binary, read by the `stl_io` crate. Three vertices a triangle, in single precision; a triangle's normal says no
//! more than its corners and is not kept.

use std::io::{Cursor, Read};

use glam::DVec3;

use super::polygons::{PolygonError, PolygonLimits, Polygons};

/// Bytes before the triangles of a binary file: a comment, and how many there are.
const HEADER: usize = 84;
/// Bytes of a triangle in a binary file.
const TRIANGLE: usize = 50;
/// How each solid of a text begins.
const SOLID: &[u8] = b"solid";

/// Reads all solids of a file as one set of polygons.
///
/// # Errors
/// Where the bytes are of another format, or more than `limits` allow.
pub fn read(mut file: impl Read, limits: PolygonLimits) -> Result<Polygons, PolygonError> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let mut polygons = Polygons::default();
    if is_binary(&bytes) {
        // A comment may begin as texts do.
        bytes[..SOLID.len()].fill(b' ');
        add_solid(bytes, &mut polygons, limits)?;
        return Ok(polygons);
    }
    for solid in solids(&bytes) {
        // The crate wants a name, or the space before it.
        let rest = &solid[SOLID.len()..];
        add_solid([SOLID, b" ", rest].concat(), &mut polygons, limits)?;
    }
    match polygons.faces {
        0 if !is_text(&bytes) => Err(malformed(
            &"it has neither as many bytes as it says nor `solid` at its beginning",
        )),
        _ => Ok(polygons),
    }
}

/// Whether there are exactly as many bytes as a binary file says there are triangles.
fn is_binary(bytes: &[u8]) -> bool {
    let count = bytes.get(HEADER - 4..HEADER).and_then(|count| count.try_into().ok());
    count.is_some_and(|count| u32::from_le_bytes(count) as usize == (bytes.len() - HEADER) / TRIANGLE)
        && (bytes.len() - HEADER).is_multiple_of(TRIANGLE)
}

fn is_text(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().starts_with(SOLID)
}

/// The solids of a text: from each line that begins with the word to the next.
fn solids(bytes: &[u8]) -> Vec<&[u8]> {
    let mut solids = Vec::new();
    let (mut begin, mut at) = (None, 0);
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        if is_text(line) {
            solids.extend(begin.map(|begin| &bytes[begin..at]));
            begin = Some(at + line.len() - line.trim_ascii_start().len());
        }
        at += line.len();
    }
    solids.extend(begin.map(|begin| &bytes[begin..]));
    solids
}

fn add_solid(bytes: Vec<u8>, polygons: &mut Polygons, limits: PolygonLimits) -> Result<(), PolygonError> {
    let mut bytes = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut bytes).map_err(|error| malformed(&error))?;
    for triangle in triangles {
        let corners = triangle.map_err(|error| malformed(&error))?.vertices;
        let first = polygons.positions.len() as u64;
        if first + 3 > u64::from(limits.vertices) {
            return Err(PolygonError::TooLarge(limits.vertices, "vertices"));
        }
        polygons
            .positions
            .extend(corners.map(|corner| DVec3::from_array(corner.0.map(f64::from))));
        polygons.add_face(&[first, first + 1, first + 2], limits)?;
    }
    Ok(())
}

fn malformed(reason: &impl ToString) -> PolygonError {
    PolygonError::Malformed {
        format: "STL",
        reason: reason.to_string(),
    }
}

#[cfg(test)]
#[path = "stl_tests.rs"]
mod tests;
