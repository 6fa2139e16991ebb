#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn lake(rings: &[&[[f64; 2]]]) -> Lake {
    let ring = |ring: &&[[f64; 2]]| ring.iter().copied().map(DVec2::from_array).collect();
    let mut lake = Lake::new(rings.iter().map(ring).collect());
    lake.level = Some(7.0);
    lake
}

#[test]
fn what_is_inside_is_level_and_an_island_is_not() {
    let lake = lake(&[
        &[[0.5, 0.5], [6.5, 0.5], [6.5, 5.5], [0.5, 5.5]],
        &[[2.5, 1.5], [4.5, 1.5], [4.5, 3.5], [2.5, 3.5]],
    ]);
    assert_eq!(lake.extent, [1..7, 1..6]);
    let mut heights = vec![0.0; 8 * 7];
    lake.level_in([&(0..8), &(0..7)], &mut heights);
    for (index, &height) in heights.iter().enumerate() {
        let (x, y) = (index % 8, index / 8);
        let is_water = (1..7).contains(&x) && (1..6).contains(&y) && !((3..5).contains(&x) && (2..4).contains(&y));
        assert_eq!(height, if is_water { 7.0 } else { 0.0 }, "{x} {y}");
    }
}

#[test]
fn a_rectangle_is_level_where_the_whole_is() {
    let lake = lake(&[&[[-3.2, -1.0], [12.0, 4.3], [5.0, 9.9]]]);
    let mut whole = vec![0.0; 20 * 20];
    lake.level_in([&(-5..15), &(-5..15)], &mut whole);
    let mut part = vec![0.0; 6 * 4];
    lake.level_in([&(3..9), &(2..6)], &mut part);
    for (row, part) in (2..6).zip(part.chunks_exact(6)) {
        let start = (row + 5) * 20 + 3 + 5;
        assert_eq!(part, &whole[start..start + 6]);
    }
    assert!(whole.contains(&7.0));
}

#[test]
fn a_level_is_the_median_of_the_samples_inside() {
    let lake = lake(&[&[[-0.5, -0.5], [100.5, -0.5], [100.5, 200.5], [-0.5, 200.5]]]);
    let of_rows = |[columns, rows]: [&Range<i64>; 2]| {
        let rows = rows.clone();
        Ok(rows
            .flat_map(|row| {
                columns
                    .clone()
                    .map(move |_| if row < 0 { f32::NAN } else { row as f32 })
            })
            .collect())
    };
    assert_eq!(level(&lake, [&(0..50), &(0..101)], of_rows).unwrap(), Some(50.0));
    assert_eq!(level(&lake, [&(0..50), &(-9..0)], of_rows).unwrap(), None);
    assert_eq!(level(&lake, [&(300..350), &(0..9)], of_rows).unwrap(), None);
}
