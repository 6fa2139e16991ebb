//! Two curves become one.

use glam::DVec3;
use smallvec::SmallVec;

use crate::curved::merging;
use crate::curved::patterns::MergeablePair;

/// A mergeable pair and the curve that it becomes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) pair: MergeablePair,
    pub(super) curve: FittedCurve,
}

/// What a vertex's pairs become, those that deviate least first.
pub(super) type Candidates = SmallVec<[Candidate; 3]>;

/// A curve that two others become.
#[derive(Clone, Copy, Debug)]
pub(super) struct FittedCurve {
    /// Its inner control points.
    pub(super) inner: [DVec3; 2],
    /// Where the two met, from its start to its end.
    pub(super) t: f64,
    /// The largest distance of a control point of its two parts from that of the curve it replaces.
    pub(super) deviation: f64,
}

/// The cubic from the start of `left` to the end of `right` whose parts' control points deviate least from theirs, in the
/// sense of least squares. They met where the lengths beside it say, as they do for parts of one curve, or the lengths of the
/// chords, whichever deviates less. None where nothing says.
///
/// Parts of one curve give it back. Others do not keep the directions of their far ends, as the inverse of de Casteljau's
/// algorithm would: it carries what is said of one end of a short curve all along a long one.
pub(super) fn fit(left: [DVec3; 4], right: [DVec3; 4]) -> Option<FittedCurve> {
    let by_tangents = merging::cut_parameter(left, right).and_then(|t| fit_at(left, right, t));
    let (before, after) = (left[0].distance(left[3]), right[0].distance(right[3]));
    let by_chords = fit_at(left, right, before / (before + after));
    let both = by_tangents.into_iter().chain(by_chords);
    both.min_by(|a, b| a.deviation.total_cmp(&b.deviation))
}

fn fit_at(left: [DVec3; 4], right: [DVec3; 4], t: f64) -> Option<FittedCurve> {
    let rest = 1.0 - t;
    let (start, end) = (left[0], right[3]);
    // Each row: shares of the two inner control points in a control point of a part, and what else is in it.
    let rows = [
        (t, 0.0, left[1] - rest * start),
        (2.0 * t * rest, t * t, left[2] - rest * rest * start),
        (
            3.0 * t * rest * rest,
            3.0 * t * t * rest,
            left[3] - rest * rest * rest * start - t * t * t * end,
        ),
        (rest * rest, 2.0 * t * rest, right[1] - t * t * end),
        (0.0, rest, right[2] - t * end),
    ];
    let sum = |share: fn(f64, f64) -> f64| rows.iter().map(|row| share(row.0, row.1)).sum::<f64>();
    let [aa, ab, bb] = [sum(|a, _| a * a), sum(|a, b| a * b), sum(|_, b| b * b)];
    let (to_a, to_b) = rows
        .iter()
        .fold((DVec3::ZERO, DVec3::ZERO), |(to_a, to_b), &(a, b, given)| {
            (to_a + a * given, to_b + b * given)
        });
    let determinant = aa * bb - ab * ab;
    let inner = [
        (bb * to_a - ab * to_b) / determinant,
        (aa * to_b - ab * to_a) / determinant,
    ];
    let squares = rows
        .iter()
        .map(|&(a, b, given)| (a * inner[0] + b * inner[1]).distance_squared(given));
    let deviation = squares.fold(0.0, f64::max).sqrt();
    deviation.is_finite().then_some(FittedCurve { inner, t, deviation })
}
