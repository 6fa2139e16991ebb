//! How far samples are from the nearest one of some.
//!
//! After P. Felzenszwalb and D. Huttenlocher, *Distance Transforms of Sampled Functions*, 2012: along columns, then along rows by
//! the lower envelope of parabolas.

/// Distances in metres, row by row, from each sample of a rectangle to the nearest one that is `marked`; infinite where none is.
/// `cell` is metres from column to column and from row to row.
pub(crate) fn distances(marked: &[bool], columns: usize, cell: [f64; 2]) -> Vec<f32> {
    let rows = marked.len() / columns;
    let mut squares = vec![f64::INFINITY; marked.len()];
    for column in 0..columns {
        let at = |row: usize| row * columns + column;
        let mut nearest: Option<usize> = None;
        for row in 0..rows {
            nearest = if marked[at(row)] { Some(row) } else { nearest };
            if let Some(nearest) = nearest {
                squares[at(row)] = ((row - nearest) as f64 * cell[1]).powi(2);
            }
        }
        nearest = None;
        for row in (0..rows).rev() {
            nearest = if marked[at(row)] { Some(row) } else { nearest };
            if let Some(nearest) = nearest {
                squares[at(row)] = squares[at(row)].min(((nearest - row) as f64 * cell[1]).powi(2));
            }
        }
    }
    squares
        .chunks_exact(columns)
        .flat_map(|row| along(row, cell[0]))
        .collect()
}

/// The least of `squares[i] + ((x − i) · cell)²` over a row, its root at each x.
fn along(squares: &[f64], cell: f64) -> Vec<f32> {
    // Parabolas of the lower envelope, and from where on each is the lowest.
    let mut envelope: Vec<(usize, f64)> = Vec::new();
    for (index, &square) in squares.iter().enumerate().filter(|(_, square)| square.is_finite()) {
        let from = loop {
            let Some(&(last, from)) = envelope.last() else {
                break f64::NEG_INFINITY;
            };
            // Differences of places alone, so that the same samples elsewhere in a row come to the same.
            let apart = (index - last) as f64;
            let crossing = last as f64 + apart / 2.0 + (square - squares[last]) / (2.0 * apart * cell * cell);
            if crossing > from {
                break crossing;
            }
            envelope.pop();
        };
        envelope.push((index, from));
    }
    let mut lowest = 0;
    let mut distance = |index: usize| {
        while envelope.get(lowest + 1).is_some_and(|&(_, from)| from <= index as f64) {
            lowest += 1;
        }
        envelope.get(lowest).map_or(f32::INFINITY, |&(parabola, _)| {
            let across = index.abs_diff(parabola) as f64 * cell;
            (squares[parabola] + across * across).sqrt() as f32
        })
    };
    (0..squares.len()).map(&mut distance).collect()
}

/// 1 at no distance, 0 from one on, level at both: a cubic.
pub(crate) fn fading(distance: f64) -> f64 {
    let left = (1.0 - distance).clamp(0.0, 1.0);
    left * left * (3.0 - 2.0 * left)
}

#[cfg(test)]
#[path = "distances_tests.rs"]
mod tests;
