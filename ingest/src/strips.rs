//! Lines on the lattice, led around the strips along tiles' sides: what is in a strip goes onto the side.
//!
//! ```text
//!   side │ strip │ inside
//!        │       │   ╱
//!      c ●───────●──╱ line      across the strip straight, then along the side to where it leaves the strip
//!        │      ╱│
//!      d ●─────●─│              c and d are stops: vertices of the side at every zoom
//! ```
//! So both tiles, from nothing but the line, come to the same places on their common side, and no two edges in a strip cross.

use std::collections::BTreeMap;

use terrain_core::height_field::snapping::Place;

use crate::lattice::STRIP;
use crate::raster_outline::{crossing, on_line, with_passed};

/// The edges that a step between two places becomes; sides are at multiples of `extent`.
pub(crate) fn out_of_strips(step: [Place; 2], extent: i64) -> Vec<[Place; 2]> {
    // The ends are the same for the steps before and after, whatever strip these are in.
    let own = |at: Place| at.map(|coordinate| onto_side(coordinate, [coordinate; 2], extent));
    let mut way = vec![own(step[0])];
    for pair in cut(step, extent).windows(2) {
        let moved = |end: Place| [0, 1].map(|axis| onto_side(end[axis], [pair[0][axis], pair[1][axis]], extent));
        go_over(&mut way, moved(pair[0]));
        way.push(moved(pair[1]));
    }
    go_over(&mut way, own(step[1]));
    way.dedup();
    way.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Goes on from one piece of a step to where the next begins, over a corner along one axis after the other.
fn go_over(way: &mut Vec<Place>, to: Place) {
    let from = way[way.len() - 1];
    if from[0] != to[0] && from[1] != to[1] {
        way.push([to[0], from[1]]);
    }
    way.push(to);
}

/// The ends of a step and where it passes inner lines of strips, in order.
fn cut(step: [Place; 2], extent: i64) -> Vec<Place> {
    let [from, to] = step;
    let passed = [0, 1].into_iter().flat_map(|axis| {
        let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        let sides = (low - STRIP).div_euclid(extent)..=(high + STRIP).div_euclid(extent) + 1;
        let lines = sides.flat_map(move |side| [side * extent - STRIP, side * extent + STRIP]);
        lines.filter_map(move |line| Some(on_line(axis, line, crossing(step, axis, line)?)))
    });
    with_passed(step, passed)
}

/// A coordinate of a piece's end; where the piece is in a strip, that of the side.
fn onto_side(coordinate: i64, [from, to]: [i64; 2], extent: i64) -> i64 {
    let side = (from + to + extent).div_euclid(2 * extent) * extent;
    if (from + to - 2 * side).abs() < 2 * STRIP {
        side
    } else {
        coordinate
    }
}

/// Where edges begin or end on the line of a side, or turn; not where they go on straight along it. `axis` is that of the coordinate that
/// is `line` there.
pub(crate) fn stops(edges: &[[Place; 2]], axis: usize, line: i64) -> Vec<i64> {
    // For each place whether edges go on in both directions, and whether any leaves the side.
    let mut met: BTreeMap<i64, [bool; 3]> = BTreeMap::new();
    for &[from, to] in edges {
        for (end, other) in [(from, to), (to, from)] {
            if end[axis] != line || end == other {
                continue;
            }
            let along = 1 - axis;
            let direction = match other[axis] == line {
                true => usize::from(other[along] > end[along]),
                false => 2,
            };
            met.entry(end[along]).or_default()[direction] = true;
        }
    }
    met.retain(|_, directions| *directions != [true, true, false]);
    met.into_keys().collect()
}

#[cfg(test)]
#[path = "strips_tests.rs"]
mod tests;
