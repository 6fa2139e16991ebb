use super::*;

fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

#[test]
fn the_nearest_point_is_inside_on_an_edge_or_a_corner() {
    let triangle = [at(0.0, 0.0, 0.0), at(4.0, 0.0, 0.0), at(0.0, 4.0, 0.0)];
    assert_eq!(nearest_on_triangle(at(1.0, 1.0, 5.0), triangle), at(1.0, 1.0, 0.0));
    assert_eq!(nearest_on_triangle(at(2.0, -3.0, 4.0), triangle), at(2.0, 0.0, 0.0));
    assert_eq!(nearest_on_triangle(at(4.0, 4.0, 1.0), triangle), at(2.0, 2.0, 0.0));
    assert_eq!(nearest_on_triangle(at(-1.0, -1.0, 0.0), triangle), at(0.0, 0.0, 0.0));
    assert_eq!(squared_to_triangle(at(9.0, 0.0, 12.0), triangle), 169.0);
}

#[test]
fn triangles_without_area_are_their_edges() {
    let line = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(3.0, 0.0, 0.0)];
    assert_eq!(nearest_on_triangle(at(2.0, 1.0, 0.0), line), at(2.0, 0.0, 0.0));
    let point = [at(1.0, 1.0, 1.0); 3];
    assert_eq!(squared_to_triangle(at(1.0, 1.0, 3.0), point), 4.0);
    assert_eq!(squared_to_segment(at(1.0, 1.0, 3.0), [point[0]; 2]), 4.0);
}
