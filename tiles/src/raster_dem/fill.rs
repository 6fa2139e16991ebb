//! Heights under voids: those around them, spread smoothly. No height that comes out is beyond those that went in.

use crate::spread::Values;

/// Fills what is none in a square of `size` a side, a power of two; where everything is none, all of it stays so.
pub(super) fn fill_voids(heights: &mut [Option<f64>], size: usize) {
    if heights.iter().all(Option::is_some) {
        return;
    }
    let square = Values {
        first: [0, 0],
        columns: size,
        rows: size,
        values: heights.iter().map(|height| height.unwrap_or(f64::NAN)).collect(),
    };
    for (height, spread) in heights.iter_mut().zip(square.spread(size.ilog2())) {
        *height = Some(spread).filter(|spread| !spread.is_nan());
    }
}
