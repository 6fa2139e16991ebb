use std::f64::consts::PI;

use super::*;

/// Around a pole: the angle and the distance from it, seen as x and y.
fn polar(plan: DVec2) -> DVec2 {
    DVec2::from_angle(plan.x) * plan.y
}

fn angle_and_distance(grid: DVec2) -> DVec2 {
    DVec2::new(grid.to_angle(), grid.length())
}

#[test]
fn an_affine_map_is_exact() {
    let to_grid = |plan: DVec2| DVec2::new(plan.y / 4.0 + 1.0, plan.x / 8.0);
    let to_plan = |grid: DVec2| DVec2::new(grid.y * 8.0, (grid.x - 1.0) * 4.0);
    let map = PlanMap::fit(DVec2::ZERO, DVec2::splat(64.0), to_grid, to_plan);
    assert!(map.is_affine());
    assert_eq!(map.handedness(), -1.0);
    assert_eq!(map.grid(DVec2::new(24.0, 44.0)), DVec2::new(12.0, 3.0));
    assert_eq!(map.plan(DVec2::new(12.0, 3.0)), DVec2::new(24.0, 44.0));
}

#[test]
fn beside_a_pole_the_map_is_close_both_ways() {
    // A quarter turn, a hundred cells long.
    let (low, high) = (DVec2::new(0.1, 20.0), DVec2::new(0.1 + PI / 2.0, 120.0));
    let map = PlanMap::fit(low, high, polar, angle_and_distance);
    assert_eq!(map.handedness(), -1.0);
    for (across, down) in (0..=20).flat_map(|across| (0..=20).map(move |down| (across, down))) {
        let plan = low + (high - low) * DVec2::new(f64::from(across), f64::from(down)) / 20.0;
        let grid = polar(plan);
        assert!(map.grid(plan).distance(grid) < 2e-4, "{plan}");
        assert!(
            polar(map.plan(grid)).distance(grid) < 2e-2,
            "{plan}: {}",
            polar(map.plan(grid)).distance(grid)
        );
    }
}

#[test]
fn a_map_right_around_a_pole_turns_as_it_does_everywhere() {
    let (low, high) = (DVec2::new(-PI, 0.0), DVec2::new(PI, 50.0));
    assert_eq!(PlanMap::fit(low, high, polar, angle_and_distance).handedness(), -1.0);
}
