use super::*;

const VOID: f32 = f32::NAN;

fn rules(blend: f64, fill: Option<f64>) -> Rules {
    Rules {
        origin: [0, 0],
        cell: [1.0, 1.0],
        blends: vec![blend; 2],
        fill,
    }
}

fn laid(rules: &Rules, columns: i64, layers: [&[f32]; 2]) -> Vec<f32> {
    let rows = layers[0].len() as i64 / columns;
    let mut composition = Composition::new(rules, [0..columns, 0..rows]);
    for (file, layer) in layers.into_iter().enumerate() {
        composition.lay(file, &area([0..columns, 0..rows], layer));
    }
    composition.window(&(0..columns), &(0..rows))
}

fn area([columns, rows]: [Range<i64>; 2], heights: &[f32]) -> Area {
    Area {
        columns,
        rows,
        heights: heights.to_vec(),
    }
}

/// 7 m higher in its first twenty columns, as far as `above` reaches.
fn step() -> [Vec<f32>; 2] {
    let above = (0..60).map(|column| if column < 20 { 107.0 } else { VOID });
    [above.collect(), vec![100.0; 60]]
}

#[test]
fn a_raster_is_bent_to_meet_the_one_that_counts_and_is_itself_farther_away() {
    let [above, below] = step();
    let heights = laid(&rules(8.0, None), 60, [&above, &below]);
    assert_eq!(heights[..20], [107.0; 20]);
    assert!((heights[20] - 107.0).abs() < 0.5, "{heights:?}");
    assert!(
        heights[20..28]
            .windows(2)
            .all(|pair| pair[0] > pair[1] && pair[0] - pair[1] < 1.5),
        "{heights:?}"
    );
    assert_eq!(heights[27..], [100.0; 33]);
}

#[test]
fn without_a_blend_a_raster_stays_as_it_is() {
    let [above, below] = step();
    let heights = laid(&rules(0.0, None), 60, [&above, &below]);
    assert_eq!(heights, [[107.0; 20].as_slice(), &[100.0; 40]].concat());
}

#[test]
fn rasters_that_agree_are_not_touched() {
    let above: Vec<f32> = (0..40)
        .map(|column| if column < 20 { 0.3 * column as f32 } else { VOID })
        .collect();
    let below: Vec<f32> = (0..40).map(|column| 0.3 * column as f32 + 0.005).collect();
    let heights = laid(&rules(8.0, None), 40, [&above, &below]);
    assert_eq!(heights, [&above[..20], &below[20..]].concat());
}

/// A plane of 40 × 40 with a hole of so many samples a side in its middle, and a bay of six columns into its eastern rim.
fn holed(side: usize) -> Vec<f32> {
    let hole = 20 - side / 2..20 - side / 2 + side;
    (0..1600)
        .map(|index| {
            let (column, row) = (index % 40, index / 40);
            let is_void = (hole.contains(&column) && hole.contains(&row)) || column >= 34;
            if is_void {
                VOID
            } else {
                2.0 * column as f32 + row as f32
            }
        })
        .collect()
}

fn filled(heights: &[f32], widest: f64) -> (Vec<f32>, u64) {
    let rules = rules(0.0, Some(widest));
    let mut composition = Composition::new(&rules, [-30..70, -30..70]);
    let mut all = vec![VOID; 100 * 100];
    for row in 0..40 {
        all[(row + 30) * 100 + 30..][..40].copy_from_slice(&heights[row * 40..][..40]);
    }
    composition.lay(0, &area([-30..70, -30..70], &all));
    let count = composition.fill([&(0..40), &(0..40)]).len() as u64;
    (composition.window(&(0..40), &(0..40)), count)
}

#[test]
fn a_narrow_hole_is_filled_between_its_rims_and_outer_rims_stay() {
    let (heights, count) = filled(&holed(6), 10.0);
    assert_eq!(count, 36);
    for (index, &height) in heights.iter().enumerate() {
        let (column, row) = (index % 40, index / 40);
        let plane = 2.0 * column as f32 + row as f32;
        match column {
            34.. => assert!(height.is_nan(), "{column} {row}"),
            _ => assert!((height - plane).abs() < 2.0, "{column} {row}: {height}, not {plane}"),
        }
    }
}

#[test]
fn of_a_wide_hole_only_corners_are_filled() {
    let (heights, count) = filled(&holed(20), 10.0);
    assert!(count < 20 * 20 / 8, "{count}");
    for (index, height) in heights.iter().enumerate() {
        let (column, row) = (index % 40, index / 40);
        let is_far_inside = (13..27).contains(&column) && (13..27).contains(&row);
        assert!(!is_far_inside || height.is_nan(), "{column} {row}");
    }
}

#[test]
fn a_file_is_laid_in_its_own_rectangle_as_if_it_had_voids_around() {
    let rules = rules(6.0, None);
    let mut random = fastrand::Rng::with_seed(9);
    let above: Vec<f32> = (0..50 * 40)
        .map(|index| {
            if index % 50 < 20 && random.u8(0..9) > 0 {
                100.0 + random.f32()
            } else {
                VOID
            }
        })
        .collect();
    let below: Vec<f32> = (0..30 * 20).map(|_| 95.0 + random.f32()).collect();
    let mut around = vec![VOID; 50 * 40];
    for row in 0..20 {
        around[(row + 11) * 50 + 13..][..30].copy_from_slice(&below[row * 30..][..30]);
    }
    let with = |second: &Area| {
        let mut composition = Composition::new(&rules, [0..50, 0..40]);
        composition.lay(0, &area([0..50, 0..40], &above));
        composition.lay(1, second);
        let found = composition.differences(second, [&(5..48), &(2..30)]);
        (composition.window(&(0..50), &(0..40)), found)
    };
    let (heights, _) = with(&area([13..43, 11..31], &below));
    let (same, _) = with(&area([0..50, 0..40], &around));
    let is_same = |(a, b): (&f32, &f32)| a == b || (a.is_nan() && b.is_nan());
    assert!(heights.iter().zip(&same).all(is_same));
    assert!(
        heights.iter().any(|height| (97.0..99.0).contains(height)),
        "some are bent"
    );
}

#[test]
fn of_a_file_beside_what_is_asked_for_nothing_is_counted() {
    let rules = rules(6.0, None);
    let mut composition = Composition::new(&rules, [0..50, 0..40]);
    composition.lay(0, &area([0..50, 0..40], &[100.0; 50 * 40]));
    for [columns, rows] in [[45..50, 35..40], [0..5, 0..5], [45..50, 0..5], [0..5, 35..40]] {
        let beside = area([columns, rows], &[90.0; 25]);
        let found = composition.differences(&beside, [&(20..30), &(20..30)]);
        assert_eq!(found, Faults::default());
    }
    // In rows of which some are asked for, but in no column.
    let found = composition.differences(&area([0..5, 20..22], &[90.0; 10]), [&(20..30), &(20..30)]);
    assert_eq!(found, Faults::default());
    let found = composition.differences(&area([45..50, 35..40], &[90.0; 25]), [&(0..47), &(0..37)]);
    assert_eq!((found.disagreeing, found.apart), (4, 10.0));
}
