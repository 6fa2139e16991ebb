use super::*;

/// A fine raster in a coarse one of the whole Earth.
fn depths(fine: [f64; 4]) -> Depths {
    let rasters = vec![
        Depth {
            leaf_zoom: 9,
            bounds: fine,
        },
        Depth {
            leaf_zoom: 3,
            bounds: [-180.0, -90.0, 180.0, 90.0],
        },
    ];
    Depths { leaf_zoom: 9, rasters }
}

fn leaves(depths: &Depths, square: Square) -> Vec<Square> {
    if depths.is_leaf(square) {
        return vec![square];
    }
    let children = square.children().into_iter();
    children.flat_map(|child| leaves(depths, child)).collect()
}

fn all_leaves(depths: &Depths) -> Vec<Square> {
    let roots = [0, 1].map(|x| Square { zoom: 0, x, y: 0 });
    roots.into_iter().flat_map(|root| leaves(depths, root)).collect()
}

#[test]
fn leaves_are_deep_over_a_fine_raster_and_nowhere_far_from_it() {
    let depths = depths([10.3, 45.1, 10.9, 45.4]);
    let all = all_leaves(&depths);
    for leaf in &all {
        let side = 180.0 / f64::from(1 << leaf.zoom);
        let [west, south] = [leaf.x as f64 * side - 180.0, leaf.y as f64 * side - 90.0];
        let meets = west < 10.9 && west + side > 10.3 && south < 45.4 && south + side > 45.1;
        assert!(!meets || leaf.zoom == 9, "{leaf:?}");
        let is_far = (west - 10.6).abs() > 90.0 || (south - 45.0).abs() > 60.0;
        assert!(!is_far || leaf.zoom == 3, "{leaf:?}");
    }
    assert!(all.len() < 600, "{}", all.len());
}

#[test]
fn leaves_that_share_a_side_differ_by_one_zoom_at_most() {
    // Beside the antimeridian, at a corner of squares, at the pole, and a single place.
    let fines = [
        [10.3, 45.1, 10.9, 45.4],
        [179.2, -3.0, 180.7, -2.0],
        [0.0, 0.0, 0.1, 0.1],
        [-40.0, 89.5, -39.0, 90.0],
        [22.5, 11.25, 22.5, 11.25],
    ];
    for fine in fines {
        let all = all_leaves(&depths(fine));
        for leaf in &all {
            let around = 2_i64 << leaf.zoom;
            let beside = [[-1, 0], [1, 0], [0, -1], [0, 1]].map(|[x, y]| Square {
                zoom: leaf.zoom,
                x: (leaf.x + x).rem_euclid(around),
                y: leaf.y + y,
            });
            for square in beside {
                let is_there = (0..1 << square.zoom).contains(&square.y);
                let coarser =
                    std::iter::successors(Some(square), |square| square.parent()).find(|square| all.contains(square));
                if let Some(coarser) = coarser.filter(|_| is_there) {
                    assert!(leaf.zoom <= coarser.zoom + 1, "{leaf:?} beside {coarser:?}, {fine:?}");
                }
            }
        }
    }
}

#[test]
fn a_square_below_a_leaf_is_not_reached() {
    let depths = depths([10.3, 45.1, 10.9, 45.4]);
    let far = Square { zoom: 4, x: 1, y: 1 };
    assert!(!depths.is_reached(far));
    assert!(depths.is_reached(Square { zoom: 3, x: 0, y: 0 }));
    let over_the_fine_one = Square {
        zoom: 9,
        x: 542,
        y: 384,
    };
    assert!(depths.is_reached(over_the_fine_one));
}
