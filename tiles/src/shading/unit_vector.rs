//! Unit vectors in two bytes.

use glam::{DVec2, DVec3};

/// A unit vector in two bytes: projected onto the octahedron, its lower half folded out. After Z. Cigolle, S. Donow and
/// others, *A Survey of Efficient Representations for Independent Unit Vectors*, JCGT 3(2), 2014.
#[must_use]
pub fn oct_encode(unit: DVec3) -> [u8; 2] {
    let projected = unit.truncate() / (unit.x.abs() + unit.y.abs() + unit.z.abs());
    let folded = if unit.z < 0.0 { fold(projected) } else { projected };
    let byte = |coordinate: f64| ((coordinate.clamp(-1.0, 1.0) * 0.5 + 0.5) * 255.0).round() as u8;
    [byte(folded.x), byte(folded.y)]
}

/// The unit vector of two such bytes.
#[must_use]
pub fn oct_decode(bytes: [u8; 2]) -> DVec3 {
    let [x, y] = bytes.map(|byte| f64::from(byte) / 255.0 * 2.0 - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let plane = DVec2::new(x, y);
    (if z < 0.0 { fold(plane) } else { plane }).extend(z).normalize()
}

/// Swaps the inner and the outer four triangles of the octahedron's square.
fn fold(point: DVec2) -> DVec2 {
    let sign = |coordinate: f64| if coordinate < 0.0 { -1.0 } else { 1.0 };
    DVec2::new(
        (1.0 - point.y.abs()) * sign(point.x),
        (1.0 - point.x.abs()) * sign(point.y),
    )
}

#[cfg(test)]
#[path = "unit_vector_tests.rs"]
mod tests;
