//! OFF, the Object File Format, as text: Geomview's, of three dimensions.
//!
//! ```text
//! OFF                       or NOFF, COFF, STOFF …: what else a vertex has
//! 8 6 12                    vertices, faces, edges; may stand on the line above; comments begin with #
//! 0.5 0.5 -0.5              a vertex a line: position, then its normal if there is an N, then what is not read
//! 4  0 1 2 3  255 0 0       a face a line: how many corners, those, then what is not read
//! ```

use std::io::BufRead;
use std::str::FromStr;

use glam::DVec3;

use super::polygons::{Column, PolygonError, PolygonLimits, Polygons, Storage};

/// Reads a file; normals of vertices become columns.
///
/// # Errors
/// Where the bytes are of another format, or more than `limits` allow.
pub fn read(file: impl BufRead, limits: PolygonLimits) -> Result<Polygons, PolygonError> {
    let mut lines = Lines { file, count: 0 };
    let first = lines.next()?;
    let (has_normals, counts) = header(&first)?;
    let counts = if counts.is_empty() {
        lines.next()?
    } else {
        counts.to_owned()
    };
    let [vertices, faces] =
        numbers::<u64, 2>(&counts).ok_or_else(|| lines.malformed("counts of vertices and faces"))?;
    for (count, limit, what) in [
        (vertices, limits.vertices, "vertices"),
        (faces, limits.triangles, "faces"),
    ] {
        if count > u64::from(limit) {
            return Err(PolygonError::TooLarge(limit, what));
        }
    }
    let mut polygons = Polygons::default();
    let mut normals = [(); 3].map(|()| Vec::new());
    for _ in 0..vertices {
        let line = lines.next()?;
        let position = numbers::<f64, 3>(&line).ok_or_else(|| lines.malformed("a vertex"))?;
        polygons.positions.push(DVec3::from_array(position));
        if has_normals {
            let [.., x, y, z] = numbers::<f64, 6>(&line).ok_or_else(|| lines.malformed("a normal"))?;
            normals
                .iter_mut()
                .zip([x, y, z])
                .for_each(|(values, value)| values.push(value));
        }
    }
    for _ in 0..faces {
        let line = lines.next()?;
        let corners = corners(&line).ok_or_else(|| lines.malformed("a face"))?;
        polygons.add_face(&corners, limits)?;
    }
    if has_normals {
        polygons.columns = columns(normals);
    }
    Ok(polygons)
}

/// Whether vertices have normals, and what follows on the first line.
fn header(line: &str) -> Result<(bool, &str), PolygonError> {
    let unknown = |reason: &str| PolygonError::Malformed {
        format: "OFF",
        reason: reason.to_owned(),
    };
    let (kind, counts) = line
        .split_once("OFF")
        .ok_or_else(|| unknown("it does not begin with OFF"))?;
    match kind.trim_start_matches("ST").trim_start_matches('C') {
        _ if counts.trim_start().starts_with("BINARY") => Err(unknown("it is binary; only text is read")),
        "" => Ok((false, counts.trim())),
        "N" => Ok((true, counts.trim())),
        _ => Err(unknown("it has not three dimensions")),
    }
}

/// The first numbers of a line.
fn numbers<T: FromStr + Copy + Default, const COUNT: usize>(line: &str) -> Option<[T; COUNT]> {
    let mut words = line.split_whitespace();
    let mut numbers = [T::default(); COUNT];
    for number in &mut numbers {
        *number = words.next()?.parse().ok()?;
    }
    Some(numbers)
}

fn corners(line: &str) -> Option<Vec<u64>> {
    let mut words = line.split_whitespace();
    let count: usize = words.next()?.parse().ok()?;
    let corners: Vec<u64> = words.take(count).map_while(|word| word.parse().ok()).collect();
    (corners.len() == count).then_some(corners)
}

fn columns(normals: [Vec<f64>; 3]) -> Vec<Column> {
    let named = ["nx", "ny", "nz"].into_iter().zip(normals);
    named
        .map(|(name, values)| Column {
            name: name.to_owned(),
            storage: Storage::Float,
            values,
        })
        .collect()
}

/// Lines that say something.
struct Lines<R> {
    file: R,
    /// Lines read.
    count: usize,
}

/// The longest line that is read.
const LONGEST: u64 = 1 << 20;

impl<R: BufRead> Lines<R> {
    /// The next one without its comment.
    fn next(&mut self) -> Result<String, PolygonError> {
        loop {
            let mut bytes = Vec::new();
            let length = std::io::Read::take(&mut self.file, LONGEST).read_until(b'\n', &mut bytes)?;
            self.count += 1;
            if length == 0 {
                return Err(self.malformed("more lines"));
            }
            let line = String::from_utf8_lossy(&bytes);
            let said = line.split('#').next().unwrap_or_default().trim();
            if !said.is_empty() {
                return Ok(said.to_owned());
            }
        }
    }

    fn malformed(&self, expected: &str) -> PolygonError {
        PolygonError::Malformed {
            format: "OFF",
            reason: format!("line {}: expected {expected}", self.count),
        }
    }
}

#[cfg(test)]
#[path = "off_tests.rs"]
mod tests;
