//! Lines on whole-numbered places, made to meet at their vertices only: snap rounding.
//!
//! After J. Hobby, *Practical segment intersection with finite precision output*, 1999: every place where a segment ends, or next to
//! where two cross, is *hot*, and each segment is led through all hot places within half a unit of it. No two segments cross
//! then, none passes a vertex that is not its own, and none is further than half a unit's diagonal from where it was.
//!
//! ```text
//! hot ← ends of all segments, and crossings, rounded
//! for each segment: the hot places whose unit square it passes, in the order in which it does
//! ```

use std::collections::{BTreeSet, HashMap};

/// A place on the lattice.
pub type Place = [i64; 2];

/// The way of each segment through the hot places. Coordinates are below 2^29.
#[must_use]
pub fn snapped(segments: &[[Place; 2]]) -> Vec<Vec<Place>> {
    let size = bin_size(segments);
    let mut hot: BTreeSet<Place> = segments.iter().flatten().copied().collect();
    let by_bin = binned(segments.iter().map(|segment| bins(segment, size, 0)));
    for numbers in by_bin.values() {
        for (index, &first) in numbers.iter().enumerate() {
            let crossed = numbers[index + 1..]
                .iter()
                .filter_map(|&second| crossing(segments[first], segments[second]));
            hot.extend(crossed);
        }
    }
    let hot: Vec<Place> = hot.into_iter().collect();
    let hot_by_bin = binned(hot.iter().map(|&place| bins(&[place, place], size, 0)));
    let way = |segment: &[Place; 2]| way(segment, bins(segment, size, 1), &hot, &hot_by_bin);
    segments.iter().map(way).collect()
}

/// Side of the squares by which neighbours are found: about as long as segments are.
fn bin_size(segments: &[[Place; 2]]) -> i64 {
    let longest = |[from, to]: &[Place; 2]| (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
    let mean = segments.iter().map(longest).sum::<i64>() / segments.len().max(1) as i64;
    (mean.max(1) as u64).next_power_of_two() as i64
}

/// The squares that the rectangle around a segment meets, widened by a margin.
fn bins([from, to]: &[Place; 2], size: i64, margin: i64) -> impl Iterator<Item = Place> + use<> {
    let range = |axis: usize| {
        let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        (low - margin).div_euclid(size)..=(high + margin).div_euclid(size)
    };
    let rows = range(1);
    range(0).flat_map(move |x| rows.clone().map(move |y| [x, y]))
}

/// Which of some things are in each square.
fn binned(things: impl Iterator<Item = impl Iterator<Item = Place>>) -> HashMap<Place, Vec<usize>> {
    let mut by_bin: HashMap<Place, Vec<usize>> = HashMap::new();
    for (number, bins) in things.enumerate() {
        for bin in bins {
            by_bin.entry(bin).or_default().push(number);
        }
    }
    by_bin
}

/// The place next to where two segments cross between their ends.
fn crossing([p, q]: [Place; 2], [r, s]: [Place; 2]) -> Option<Place> {
    let (along, other, apart) = (way_between(p, q), way_between(r, s), way_between(p, r));
    let (turn, here, there) = (perp(along, other), perp(apart, other), perp(apart, along));
    let (turn, here, there) = if turn < 0 {
        (-turn, -here, -there)
    } else {
        (turn, here, there)
    };
    let is_between = |share: i128| 0 < share && share < turn;
    (is_between(here) && is_between(there)).then(|| {
        [0, 1].map(|axis| {
            let doubled = 2 * along[axis] * here + turn;
            p[axis] + doubled.div_euclid(2 * turn) as i64
        })
    })
}

fn way_between(from: Place, to: Place) -> [i128; 2] {
    [0, 1].map(|axis| i128::from(to[axis] - from[axis]))
}

fn perp(a: [i128; 2], b: [i128; 2]) -> i128 {
    a[0] * b[1] - a[1] * b[0]
}

/// The hot places whose unit square a segment passes, from its start to its end.
fn way(
    segment: &[Place; 2],
    bins: impl Iterator<Item = Place>,
    hot: &[Place],
    by_bin: &HashMap<Place, Vec<usize>>,
) -> Vec<Place> {
    let numbers = bins.filter_map(|bin| by_bin.get(&bin)).flatten();
    let mut passed: Vec<(Share, Place)> = numbers
        .filter_map(|&number| Some((passes(segment, hot[number])?, hot[number])))
        .collect();
    passed.sort_by(|(a, _), (b, _)| a.compare(b));
    passed.into_iter().map(|(_, place)| place).collect()
}

/// A part of the way along a segment, as a fraction of a positive denominator.
#[derive(Clone, Copy)]
struct Share {
    numerator: i128,
    denominator: i128,
}

impl Share {
    fn new(numerator: i128, denominator: i128) -> Self {
        let sign = denominator.signum();
        Self {
            numerator: numerator * sign,
            denominator: denominator * sign,
        }
    }

    fn compare(&self, other: &Self) -> std::cmp::Ordering {
        (self.numerator * other.denominator).cmp(&(other.numerator * self.denominator))
    }

    fn max(self, other: Self) -> Self {
        if self.compare(&other).is_lt() { other } else { self }
    }

    fn min(self, other: Self) -> Self {
        if other.compare(&self).is_lt() { other } else { self }
    }
}

/// Half-way between where a segment enters the unit square around a place and where it leaves it, if it does: its left and lower sides are
/// the square's, the others are not.
fn passes([from, to]: &[Place; 2], place: Place) -> Option<Share> {
    let mut shares = [Share::new(0, 1), Share::new(1, 1)];
    for axis in [0, 1] {
        // Doubled, so that all numbers are whole.
        let (start, way) = (2 * i128::from(from[axis]), 2 * i128::from(to[axis] - from[axis]));
        let [low, high] = [-1, 1].map(|half| 2 * i128::from(place[axis]) + half);
        if way == 0 {
            if !(low..high).contains(&start) {
                return None;
            }
            continue;
        }
        let [at_low, at_high] = [low, high].map(|side| Share::new(side - start, way));
        shares = [shares[0].max(at_low.min(at_high)), shares[1].min(at_low.max(at_high))];
    }
    let [enters, leaves] = shares;
    let is_corner = enters.compare(&leaves).is_eq();
    if enters.compare(&leaves).is_gt() || is_corner && !holds([*from, *to], enters, place) {
        return None;
    }
    Some(Share {
        numerator: enters.numerator * leaves.denominator + leaves.numerator * enters.denominator,
        denominator: 2 * enters.denominator * leaves.denominator,
    })
}

/// Whether the square around a place has the point of a segment.
fn holds([from, to]: [Place; 2], share: Share, place: Place) -> bool {
    (0..2).all(|axis| {
        let way = i128::from(to[axis] - from[axis]);
        let doubled = 2 * (i128::from(from[axis]) * share.denominator + way * share.numerator);
        let [low, high] = [-1, 1].map(|half| (2 * i128::from(place[axis]) + half) * share.denominator);
        (low..high).contains(&doubled)
    })
}

#[cfg(test)]
#[path = "snapping_tests.rs"]
mod tests;
