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
    if squared_area > 0.0 && of_b >= 0.0 && of_c >= 0.0 && of_b + of_c <= squared_area {
        return a + ab * (of_b / squared_area) + ac * (of_c / squared_area);
    }
    let on_edges = [[a, b], [b, c], [c, a]].map(|edge| nearest_on_segment(point, edge));
    let nearer = |best: DVec3, next: DVec3| {
        let is_nearer = next.distance_squared(point) < best.distance_squared(point);
        if is_nearer { next } else { best }
    };
    nearer(nearer(on_edges[0], on_edges[1]), on_edges[2])
}

/// Distance of `point` from a segment, squared.
pub(crate) fn squared_to_segment(point: DVec3, segment: [DVec3; 2]) -> f64 {
    nearest_on_segment(point, segment).distance_squared(point)
}

/// Distance of `point` from a triangle, squared.
pub(crate) fn squared_to_triangle(point: DVec3, triangle: [DVec3; 3]) -> f64 {
    nearest_on_triangle(point, triangle).distance_squared(point)
}

#[cfg(test)]
#[path = "distance_tests.rs"]
mod tests;
