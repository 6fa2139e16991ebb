//! How files are read: piece by piece, in whole blocks.

use std::ops::Range;

/// Samples that one reader takes at once: 8 MiB of f64.
const SAMPLES_AT_ONCE: usize = 1 << 20;

/// A range cut where steps counted from `first` begin.
pub(super) fn cut(range: &Range<usize>, first: usize, step: usize) -> impl Iterator<Item = Range<usize>> + use<> {
    let Range { start, end } = *range;
    let begin = first + (start - first) / step * step;
    (begin..end)
        .step_by(step)
        .map(move |from| from.max(start)..(from + step).min(end))
}

/// The largest run of whole blocks that stays within [`SAMPLES_AT_ONCE`], in whole rows of blocks where these fit.
pub(super) fn part_size(block: [usize; 2], columns: usize) -> [usize; 2] {
    let blocks_across = (SAMPLES_AT_ONCE / (block[0] * block[1])).clamp(1, columns.div_ceil(block[0]));
    let width = blocks_across * block[0];
    let blocks_down = (SAMPLES_AT_ONCE / (width * block[1])).max(1);
    [width, blocks_down * block[1]]
}
