use super::*;

#[test]
fn the_sum_is_of_squared_distances() {
    let floor = Quadric::plane(DVec3::new(5.0, 7.0, 2.0), DVec3::Z, 3.0);
    let wall = Quadric::plane(DVec3::new(1.0, 0.0, 0.0), DVec3::X, 1.0);
    assert_eq!((floor + wall).at(DVec3::new(3.0, 9.0, 4.0)), 3.0 * 4.0 + 4.0);
}

#[test]
fn three_planes_meet_in_the_best_place_and_fewer_leave_it_where_it_was_expected() {
    let corner = DVec3::new(1.0, 2.0, 3.0);
    let planes = DVec3::AXES.map(|normal| Quadric::plane(corner, normal, 2.0));
    let expected = DVec3::new(1.5, 2.5, 3.5);
    let all = planes
        .into_iter()
        .fold(Quadric::ZERO, Quadric::add)
        .best_place(expected);
    assert!(all.distance(corner) < 0.01, "{all}");
    let edge = (planes[0] + planes[1]).best_place(expected);
    assert!(edge.distance(DVec3::new(1.0, 2.0, 3.5)) < 0.01, "{edge}");
    assert_eq!(Quadric::ZERO.best_place(expected), expected);
}
