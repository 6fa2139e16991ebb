use std::collections::BTreeSet;

use super::*;

/// Numbers below a limit, the same for the same seed.
fn numbers(seed: u64) -> impl FnMut(i64) -> i64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move |limit| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as i64 % limit
    }
}

fn pieces(ways: &[Vec<Place>]) -> BTreeSet<[Place; 2]> {
    let pairs = ways.iter().flat_map(|way| way.windows(2));
    pairs.map(|pair| [pair[0].min(pair[1]), pair[0].max(pair[1])]).collect()
}

/// Whether a place is on a segment, but not one of its ends.
fn is_inside(place: Place, [from, to]: [Place; 2]) -> bool {
    let (way, before) = (way_between(from, to), way_between(from, place));
    let along = way[0] * before[0] + way[1] * before[1];
    perp(way, before) == 0 && 0 < along && along < way[0] * way[0] + way[1] * way[1]
}

fn distance(place: Place, [from, to]: [Place; 2]) -> f64 {
    let [way, before] = [way_between(from, to), way_between(from, place)].map(|v| v.map(|x| x as f64));
    let length = way[0] * way[0] + way[1] * way[1];
    let share = if length > 0.0 {
        ((way[0] * before[0] + way[1] * before[1]) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (before[0] - share * way[0]).hypot(before[1] - share * way[1])
}

#[test]
fn snapped_lines_meet_at_their_vertices_only_and_stay_near() {
    for seed in 1..200 {
        let mut number = numbers(seed);
        let (count, extent) = (2 + number(30), [6, 20, 1000][number(3) as usize]);
        let segments: Vec<[Place; 2]> = (0..count)
            .map(|_| [[number(extent), number(extent)], [number(extent), number(extent)]])
            .collect();
        let ways = snapped(&segments);
        for (segment, way) in segments.iter().zip(&ways) {
            assert_eq!([way[0], way[way.len() - 1]], *segment, "seed {seed}");
            for &place in way {
                assert!(
                    distance(place, *segment) < 0.708,
                    "seed {seed}: {place:?} of {segment:?}"
                );
            }
        }
        let pieces: Vec<[Place; 2]> = pieces(&ways).into_iter().collect();
        for (index, &first) in pieces.iter().enumerate() {
            for &second in &pieces[index + 1..] {
                assert_eq!(crossing(first, second), None, "seed {seed}: {first:?} {second:?}");
                let is_touched = second.into_iter().any(|end| is_inside(end, first))
                    || first.into_iter().any(|end| is_inside(end, second));
                assert!(!is_touched, "seed {seed}: {first:?} {second:?}");
            }
        }
    }
}

#[test]
fn two_lines_that_cross_are_led_over_the_place_next_to_it() {
    let ways = snapped(&[[[0, 0], [10, 7]], [[0, 7], [10, 0]]]);
    assert_eq!(ways[0], [[0, 0], [5, 4], [10, 7]]);
    assert_eq!(ways[1], [[0, 7], [5, 4], [10, 0]]);
}
