//! Values go on where there are none: from the nearest around, smoothly, by averages over ever larger squares and back.
//!
//! After S. J. Gortler et al., *The Lumigraph*, 1996, section 3.4 (pull and push).

use std::ops::{Add, Div, Mul};

/// A number with a fraction, which may be none.
pub trait Number:
    Copy + Default + PartialEq + From<u8> + Add<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl Number for f32 {}
impl Number for f64 {}

/// Values row by row, NaN where there are none, and the place of the first one by which squares are counted: what comes out at a
/// place does not depend on the rectangle, if that reaches twice the largest square farther on all sides.
pub struct Values<T> {
    /// Column and row of the first one.
    pub first: [i64; 2],
    /// Values in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Row by row.
    pub values: Vec<T>,
}

impl<T: Number> Values<T> {
    /// The same with values everywhere within reach of squares of 2^`levels`; none is beyond those that there were.
    #[must_use]
    pub fn spread(&self, levels: u32) -> Vec<T> {
        if levels == 0 || self.values.iter().all(|&value| is_none(value)) {
            return self.values.clone();
        }
        let coarser = self.halved();
        let spread = coarser.spread(levels - 1);
        let mut values = self.values.clone();
        for (index, value) in values.iter_mut().enumerate().filter(|(_, value)| is_none(**value)) {
            let place = [index % self.columns, index / self.columns];
            *value = coarser.between(&spread, [0, 1].map(|axis| self.first[axis] + place[axis] as i64));
        }
        values
    }

    /// Averages of squares of two by two.
    fn halved(&self) -> Self {
        let first = self.first.map(|first| first.div_euclid(2));
        let size = [self.columns, self.rows];
        let [columns, rows] =
            [0, 1].map(|axis| ((self.first[axis] + size[axis] as i64 + 1).div_euclid(2) - first[axis]) as usize);
        let mut sums = vec![(T::default(), 0_u8); columns * rows];
        for (index, &value) in self.values.iter().enumerate().filter(|(_, value)| !is_none(**value)) {
            let place = [index % self.columns, index / self.columns];
            let [x, y] = [0, 1].map(|axis| (self.first[axis] + place[axis] as i64).div_euclid(2) - first[axis]);
            let (sum, count) = &mut sums[y as usize * columns + x as usize];
            (*sum, *count) = (*sum + value, *count + 1);
        }
        Self {
            first,
            columns,
            rows,
            values: sums.into_iter().map(|(sum, count)| sum / T::from(count)).collect(),
        }
    }

    /// At a place of twice the fineness, between the middles of the four nearest squares that have a value.
    fn between(&self, values: &[T], place: [i64; 2]) -> T {
        // The middle of place p of the finer values is at p / 2 − 1 / 4 of these.
        let nearest = place.map(|place| place.div_euclid(2));
        let beside = [0, 1].map(|axis| nearest[axis] + if place[axis].rem_euclid(2) == 0 { -1 } else { 1 });
        let corners = [
            ([nearest[0], nearest[1]], 9),
            ([beside[0], nearest[1]], 3),
            ([nearest[0], beside[1]], 3),
            ([beside[0], beside[1]], 1),
        ];
        let there = corners
            .into_iter()
            .filter_map(|(square, weight)| Some((self.value(values, square)?, weight)));
        let (sum, weights) = there.fold((T::default(), 0), |(sum, weights), (value, weight)| {
            (sum + value * T::from(weight), weights + weight)
        });
        sum / T::from(weights)
    }

    fn value(&self, values: &[T], square: [i64; 2]) -> Option<T> {
        let [x, y] = [0, 1].map(|axis| square[axis] - self.first[axis]);
        let is_there = x >= 0 && y >= 0 && x < self.columns as i64 && y < self.rows as i64;
        let value = is_there.then(|| values[y as usize * self.columns + x as usize])?;
        (!is_none(value)).then_some(value)
    }
}

#[expect(clippy::eq_op, reason = "what is no number is not even itself")]
fn is_none<T: Number>(value: T) -> bool {
    value != value
}

#[cfg(test)]
#[path = "spread_tests.rs"]
mod tests;
