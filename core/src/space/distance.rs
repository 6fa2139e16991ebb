//! Distances from points to segments and triangles in space.

use glam::DVec3;

/// The point of a segment next to `point`.
pub(crate) fn nearest_on_segment(point: DVec3, [from, to]: [DVec3; 2]) -> DVec3 {
    let along = to - from;
    let squared_length = along.length_squared();
    if squared_length == 0.0 {
        return from;
    }
    from + along * ((point - from).dot(along) / squared_length).clamp(0.0, 1.0)
}

/// The point of a triangle next to `point`. It is made of the corners by weights that add up to one, so that it lies on
/// the triangle even where that is too thin to have a normal: its distance is never less than the true one.
pub(crate) fn nearest_on_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, offset) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let squared_area = normal.length_squared();
    let (of_b, of_c) = (offset.cross(ac).dot(normal), ab.cross(offset).dot(normal));
    let of_a = squared_area - of_b - of_c;
    if squared_area > 0.0 && of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0 {
        return a + ab * (of_b / squared_area) + ac * (of_c / squared_area);
    }
    // What is outside is next to a side that it is beyond; where there is no area, nobody can tell which.
    let mut nearest = (f64::INFINITY, a);
    for (weight, side) in [(of_a, [b, c]), (of_b, [c, a]), (of_c, [a, b])] {
        if weight < 0.0 || squared_area == 0.0 {
            let on_side = nearest_on_segment(point, side);
            let squared = on_side.distance_squared(point);
            if squared < nearest.0 {
                nearest = (squared, on_side);
            }
        }
    }
    nearest.1
}

/// Distance of `point` from a segment, squared.
pub(crate) fn squared_to_segment(point: DVec3, segment: [DVec3; 2]) -> f64 {
    nearest_on_segment(point, segment).distance_squared(point)
}

/// Distance of `point` from a triangle, squared.
pub(crate) fn squared_to_triangle(point: DVec3, triangle: [DVec3; 3]) -> f64 {
    nearest_on_triangle(point, triangle).distance_squared(point)
}

/// Distance of `point` from the box around a triangle, squared: no more than from the triangle, and sooner found.
pub(crate) fn squared_to_box(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    (low - point).max(point - high).max(DVec3::ZERO).length_squared()
}

#[cfg(test)]
#[path = "distance_tests.rs"]
mod tests;
