use super::*;

/// A reference whose plan coordinates are the grid's, on a plane.
pub(crate) fn flat_earth<'a>(columns: usize, heights: &'a [f32], curvature: &'a [DVec2]) -> Reference<'a> {
    let rows = heights.len() / columns;
    let high = DVec2::new(columns as f64, rows as f64);
    Reference {
        heights: Heights {
            columns,
            rows,
            samples: heights,
        },
        plan: PlanMap::fit(DVec2::ZERO, high, |p| p, |p| p),
        curvature,
        ground: Ground::Plane(DVec2::ONE),
        bound: Bound::Surface,
        finer: None,
    }
}

fn point(c: f64, r: f64, height: f64) -> GridPoint {
    GridPoint {
        grid: DVec2::new(c, r),
        height,
    }
}

const PLANE: [DVec2; 64] = [DVec2::ZERO; 64];

#[test]
fn a_triangle_sees_the_samples_it_covers_and_no_others() {
    let mut heights = vec![0.0; 25];
    heights[2 * 5 + 1] = 7.0;
    heights[4 * 5 + 4] = 90.0;
    let reference = flat_earth(5, &heights, &PLANE);
    let found = reference.triangle_deviation([point(0.0, 0.0, 0.0), point(0.0, 4.0, 0.0), point(4.0, 0.0, 0.0)]);
    assert_eq!(
        found,
        Deviation {
            size: 7.0,
            at: DVec2::new(1.0, 2.0)
        }
    );
}

#[test]
fn an_edge_across_a_saddle_is_worst_in_the_middle_of_the_cell() {
    let heights = [0.0, 8.0, 8.0, 0.0];
    let reference = flat_earth(2, &heights, &PLANE);
    let found = reference.edge_deviation(point(0.0, 0.0, 0.0), point(1.0, 1.0, 0.0));
    assert!((found.size - 4.0).abs() < 1e-12, "{found:?}");
    assert!((found.at - DVec2::splat(0.5)).length() < 1e-12);
}

#[test]
fn an_edge_sees_the_ridge_where_it_crosses_a_grid_line() {
    let heights = [0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 0.0, 0.0, 0.0];
    let reference = flat_earth(3, &heights, &PLANE);
    let found = reference.edge_deviation(point(0.2, 0.0, 0.0), point(0.8, 2.0, 0.0));
    assert!(
        (found.size - 5.0).abs() < 1e-12 && (found.at - DVec2::new(0.5, 1.0)).length() < 1e-12,
        "{found:?}"
    );
}

#[test]
fn a_long_flat_edge_hangs_below_the_round_earth() {
    let heights = vec![0.0; 2 * 11];
    let curvature = [DVec2::splat(1.0e-3); 2];
    let reference = flat_earth(11, &heights, &curvature);
    let found = reference.edge_deviation(point(0.0, 0.5, 0.0), point(10.0, 0.5, 0.0));
    assert!((found.size - 25.0e-3).abs() < 1e-12, "{found:?}");
}

#[test]
fn void_cells_are_no_surface() {
    let mut heights = vec![0.0; 9];
    heights[4] = f32::NAN;
    let reference = flat_earth(3, &heights, &PLANE);
    assert_eq!(
        reference.edge_deviation(point(0.5, 0.5, 99.0), point(1.5, 1.5, 99.0)),
        Deviation::NONE
    );
    assert_eq!(reference.heights.height_near(DVec2::new(0.5, 0.5)), Some(0.0));
    assert!(!reference.heights.cell_is_valid(1, 1) && !reference.heights.cell_is_valid(2, 0));
}

#[test]
fn rounding_does_not_hide_the_samples_along_an_edge() {
    let mut heights = vec![0.0; 25];
    heights[4 * 5 + 2] = 7.0;
    let reference = flat_earth(5, &heights, &PLANE);
    let low = 4.0 - 1e-12;
    for other in [low, 4.0, 4.0 + 1e-12] {
        let found = reference.triangle_deviation([point(0.0, low, 0.0), point(4.0, other, 0.0), point(2.0, 0.0, 0.0)]);
        assert!((found.size - 7.0).abs() < 1e-9, "{other}: {found:?}");
    }
}

#[test]
fn a_wide_flat_triangle_hangs_below_the_round_earth_at_its_samples() {
    let heights = vec![0.0; 11 * 11];
    let curvature = [DVec2::splat(1.0e-3); 11];
    let reference = flat_earth(11, &heights, &curvature);
    let found = reference.triangle_deviation([point(0.0, 0.0, 0.0), point(0.0, 10.0, 0.0), point(10.0, 0.0, 0.0)]);
    // At the middle of the longest side, of 200 squared cells: a quarter of that times k.
    assert!(
        (found.size - 50.0e-3).abs() < 1e-12 && found.at == DVec2::splat(5.0),
        "{found:?}"
    );
}
