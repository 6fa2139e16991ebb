//! Values go on where there are none: from the nearest around, smoothly, by averages over ever larger squares and back.
//!
//! After S. J. Gortler et al., *The Lumigraph*, 1996, section 3.4 (pull and push).

/// Values row by row, NaN where there are none, and the place of the first one by which squares are counted: what comes out at a
/// place does not depend on the rectangle, if that reaches twice the largest square farther on all sides.
pub(crate) struct Values {
    pub(crate) first: [i64; 2],
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) values: Vec<f32>,
}

impl Values {
    /// The same with values everywhere within reach of squares of 2^`levels`.
    pub(crate) fn spread(&self, levels: u32) -> Vec<f32> {
        if levels == 0 || self.values.iter().all(|value| value.is_nan()) {
            return self.values.clone();
        }
        let coarser = self.halved();
        let spread = coarser.spread(levels - 1);
        let mut values = self.values.clone();
        for (index, value) in values.iter_mut().enumerate().filter(|(_, value)| value.is_nan()) {
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
        let mut sums = vec![0.0_f32; columns * rows];
        let mut counts = vec![0.0_f32; columns * rows];
        for (index, &value) in self.values.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
            let place = [index % self.columns, index / self.columns];
            let [x, y] = [0, 1].map(|axis| (self.first[axis] + place[axis] as i64).div_euclid(2) - first[axis]);
            let square = y as usize * columns + x as usize;
            sums[square] += value;
            counts[square] += 1.0;
        }
        let values = sums.iter().zip(&counts).map(|(sum, count)| sum / count).collect();
        Self {
            first,
            columns,
            rows,
            values,
        }
    }

    /// At a place of twice the fineness, between the middles of the four nearest squares that have a value.
    fn between(&self, values: &[f32], place: [i64; 2]) -> f32 {
        // The middle of place p of the finer values is at p / 2 − 1 / 4 of these.
        let nearest = place.map(|place| place.div_euclid(2));
        let beside = [0, 1].map(|axis| nearest[axis] + if place[axis].rem_euclid(2) == 0 { -1 } else { 1 });
        let corners = [
            ([nearest[0], nearest[1]], 9.0),
            ([beside[0], nearest[1]], 3.0),
            ([nearest[0], beside[1]], 3.0),
            ([beside[0], beside[1]], 1.0),
        ];
        let there = corners.into_iter().filter_map(|(square, weight)| {
            let value = self.value(values, square)?;
            Some((value * weight, weight))
        });
        let (sum, weights) = there.fold((0.0, 0.0), |(sum, weights), (value, weight)| {
            (sum + value, weights + weight)
        });
        sum / weights
    }

    fn value(&self, values: &[f32], square: [i64; 2]) -> Option<f32> {
        let [x, y] = [0, 1].map(|axis| square[axis] - self.first[axis]);
        let is_there = x >= 0 && y >= 0 && x < self.columns as i64 && y < self.rows as i64;
        let value = is_there.then(|| values[y as usize * self.columns + x as usize])?;
        (!value.is_nan()).then_some(value)
    }
}

#[cfg(test)]
#[path = "spread_tests.rs"]
mod tests;
