//! A curve with the fewest vertices inside a tolerance, its vertices chosen among its own points.
//!
//! After H. Imai, M. Iri, *Polygonal approximations of a curve: formulations and algorithms*, 1988, for the graph of a
//! function: a shortcut from point i stays within the tolerance as long as its slope lies in the cone that all points
//! passed so far leave open.
//!
//! ```text
//! for each candidate i, in order, that can be reached:
//!     cone ← all slopes
//!     for each point j after i:
//!         if j is a candidate and the slope i → j is in the cone: j can be reached from i in one step
//!         cone ← cone ∩ slopes from i through the tolerance around j; stop when it is empty
//! walk back from the last point by fewest steps
//! ```

use glam::DVec2;

/// Indices of the vertices to keep: a subset of `candidates` with the first and the last of them, of the smallest
/// count, such that no point between them is further than `tolerance` from the polyline, measured along y.
///
/// `points` run by growing x; `candidates` are growing indices into them. Every candidate can be kept, so there is
/// always an answer.
#[must_use]
pub fn fewest_vertices(points: &[DVec2], candidates: &[usize], tolerance: f64) -> Vec<usize> {
    let count = candidates.len();
    let mut steps = vec![usize::MAX; count];
    let mut came_from = vec![0; count];
    if count == 0 {
        return Vec::new();
    }
    steps[0] = 0;
    for start in 0..count - 1 {
        for end in reachable(points, candidates, start, tolerance) {
            if steps[start] + 1 < steps[end] {
                steps[end] = steps[start] + 1;
                came_from[end] = start;
            }
        }
    }
    let mut kept = vec![candidates[count - 1]];
    let mut at = count - 1;
    while at > 0 {
        at = came_from[at];
        kept.push(candidates[at]);
    }
    kept.reverse();
    kept
}

/// Candidates that a straight line from candidate `start` reaches within the tolerance; the next one always is.
fn reachable(points: &[DVec2], candidates: &[usize], start: usize, tolerance: f64) -> Vec<usize> {
    let origin = points[candidates[start]];
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut ends = vec![start + 1];
    let mut next = start + 1;
    for (index, point) in points.iter().enumerate().skip(candidates[start] + 1) {
        let offset = *point - origin;
        if index == candidates[next] {
            let slope = offset.y / offset.x;
            if next > start + 1 && (low..=high).contains(&slope) {
                ends.push(next);
            }
            next += 1;
        }
        low = low.max((offset.y - tolerance) / offset.x);
        high = high.min((offset.y + tolerance) / offset.x);
        if low > high || next == candidates.len() {
            break;
        }
    }
    ends
}

#[cfg(test)]
#[path = "chain_tests.rs"]
mod tests;
