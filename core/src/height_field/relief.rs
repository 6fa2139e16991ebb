//! Levels of detail of the samples themselves: blocks of cells with a bound of what they hold, so that most questions about
//! many samples are answered without a look at one.
//!
//! ```text
//!  level 0   cells: bilinear between four samples
//!  level k   blocks of 2^k × 2^k cells: a bilinear patch through four corners, and by how much the surface
//!            is at least and at most above it
//! ```
//! A sample counts as surface, even where all cells around it have voids. A corner is the sample there; where that is void,
//! the mean of the corners of finer blocks around it. Against a bilinear patch a finer
//! bilinear patch is bilinear, with its extremes at its corners: a block's bound follows from those of its four parts.

/// Blocks along the side of a [`Chunk`].
pub const CHUNK: usize = 256;
/// Corners along the side of a [`Chunk`].
pub const CORNERS: usize = CHUNK + 1;

/// [`CHUNK`] × [`CHUNK`] blocks of one level, row by row. It has the corners along all four of its sides, so that a block is
/// never in two chunks.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// Metres, [`CORNERS`] × [`CORNERS`]; NaN where no block beside has a surface.
    pub corners: Vec<f32>,
    /// Indices, growing, of the corners that are no samples.
    pub guessed: Vec<u32>,
    /// Least and greatest height of the surface above the block's patch, metres; the least above the greatest where the block
    /// has no surface. Empty at level 0.
    pub residuals: Vec<[f32; 2]>,
    /// Largest difference between neighbouring samples of a row or a column, metres.
    pub steepest: f32,
}

/// What is in a block without a surface.
pub const NO_SURFACE: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

impl Chunk {
    /// The chunk of level 0 over [`CORNERS`] × [`CORNERS`] samples; none where all are void.
    #[must_use]
    pub fn of_samples(samples: Vec<f32>) -> Option<Self> {
        assert_eq!(samples.len(), CORNERS * CORNERS, "a chunk has so many samples");
        let has_height = samples.iter().any(|sample| !sample.is_nan());
        let rows = samples.chunks_exact(CORNERS);
        let across = rows
            .flat_map(|row| row.windows(2))
            .map(|pair| (pair[1] - pair[0]).abs());
        let down = samples
            .iter()
            .zip(&samples[CORNERS..])
            .map(|(above, below)| (below - above).abs());
        // The difference from a void is NaN, and `max` takes the other one.
        let steepest = across.chain(down).fold(0.0, f32::max);
        has_height.then_some(Self {
            steepest,
            corners: samples,
            guessed: Vec::new(),
            residuals: Vec::new(),
        })
    }

    /// The chunk over four of the level below: north-west, north-east, south-west, south-east in the order of rows. None
    /// where nothing is below.
    #[must_use]
    pub fn over(parts: [Option<&Self>; 4]) -> Option<Self> {
        parts.iter().any(Option::is_some).then(|| {
            let finer = Finer { parts };
            let below = |index: usize| [2 * (index % CORNERS), 2 * (index / CORNERS)];
            let indices = 0..CORNERS * CORNERS;
            let mut chunk = Self {
                steepest: parts.iter().flatten().map(|part| part.steepest).fold(0.0, f32::max),
                corners: indices
                    .clone()
                    .map(|index| finer.corner_or_mean(below(index)))
                    .collect(),
                guessed: indices
                    .filter(|&index| finer.sample(below(index)).is_nan())
                    .map(|index| index as u32)
                    .collect(),
                residuals: Vec::with_capacity(CHUNK * CHUNK),
            };
            for index in 0..CHUNK * CHUNK {
                let (column, row) = (index % CHUNK, index / CHUNK);
                let residual = finer.residual_over(chunk.patch(column, row), 2 * column, 2 * row);
                chunk.residuals.push(residual);
            }
            chunk
        })
    }

    /// Heights of a block's corners, row by row. A cell has NaN where a sample is void; a larger block has the mean of its other
    /// corners there, NaN where it has none.
    #[must_use]
    #[inline]
    pub fn patch(&self, column: usize, row: usize) -> [f64; 4] {
        let first = row * CORNERS + column;
        let patch =
            [first, first + 1, first + CORNERS, first + CORNERS + 1].map(|index| f64::from(self.corners[index]));
        let is_whole = !(patch[0] + patch[1] + patch[2] + patch[3]).is_nan();
        if is_whole || self.residuals.is_empty() {
            return patch;
        }
        let known = patch.into_iter().filter(|corner| !corner.is_nan());
        let mean = known.clone().sum::<f64>() / known.count() as f64;
        patch.map(|corner| if corner.is_nan() { mean } else { corner })
    }

    /// The sample at a corner; NaN where it is void.
    #[must_use]
    pub fn sample(&self, column: usize, row: usize) -> f32 {
        let index = row * CORNERS + column;
        match self.guessed.binary_search(&(index as u32)) {
            Ok(_) => f32::NAN,
            Err(_) => self.corners[index],
        }
    }

    /// The bound of a block, metres above its patch: least and greatest.
    #[must_use]
    #[inline]
    pub fn residual(&self, column: usize, row: usize) -> [f32; 2] {
        match self.residuals.get(row * CHUNK + column) {
            Some(&residual) => residual,
            None if self.patch(column, row).iter().all(|corner| corner.is_nan()) => NO_SURFACE,
            None => [0.0; 2],
        }
    }
}

/// Four chunks of a level side by side.
struct Finer<'a> {
    parts: [Option<&'a Chunk>; 4],
}

impl Finer<'_> {
    /// What one of the parts that have a corner says of it. A corner between parts is in all of them; one that is missing must
    /// not hide it.
    fn at(&self, [column, row]: [usize; 2], of_part: impl Fn(&Chunk, usize, usize) -> f32) -> f32 {
        let sides = |place: usize| [(place / CHUNK).min(1), place.saturating_sub(1) / CHUNK];
        for down in sides(row) {
            for across in sides(column) {
                if let Some(part) = self.parts[2 * down + across] {
                    let found = of_part(part, column - across * CHUNK, row - down * CHUNK);
                    if !found.is_nan() {
                        return found;
                    }
                }
            }
        }
        f32::NAN
    }

    fn corner(&self, place: [usize; 2]) -> f32 {
        self.at(place, |part, column, row| part.corners[row * CORNERS + column])
    }

    fn sample(&self, place: [usize; 2]) -> f32 {
        self.at(place, Chunk::sample)
    }

    fn corner_or_mean(&self, [column, row]: [usize; 2]) -> f32 {
        let own = self.corner([column, row]);
        if !own.is_nan() {
            return own;
        }
        let beside = |place: usize| place.saturating_sub(1)..=(place + 1).min(2 * CHUNK);
        let around = beside(row).flat_map(|row| beside(column).map(move |column| self.corner([column, row])));
        let (sum, count) = around
            .filter(|corner| !corner.is_nan())
            .fold((0.0, 0_u32), |(sum, count), corner| {
                (sum + f64::from(corner), count + 1)
            });
        (sum / f64::from(count)) as f32
    }

    /// The bound of a block over `patch`, from its four parts.
    fn residual_over(&self, [a, b, c, d]: [f64; 4], column: usize, row: usize) -> [f32; 2] {
        let (top, left, right, bottom) = ((a + b) / 2.0, (a + c) / 2.0, (b + d) / 2.0, (c + d) / 2.0);
        let middle = (top + bottom) / 2.0;
        let coarse = [
            [a, top, left, middle],
            [top, b, middle, right],
            [left, middle, c, bottom],
            [middle, right, bottom, d],
        ];
        let mut bound = NO_SURFACE.map(f64::from);
        for (place, coarse) in coarse.into_iter().enumerate() {
            let (column, row) = (column + place % 2, row + place / 2);
            let Some(part) = self.parts[2 * (row / CHUNK) + column / CHUNK] else {
                continue;
            };
            let (column, row) = (column % CHUNK, row % CHUNK);
            let [least, greatest] = part.residual(column, row);
            if least > greatest {
                continue;
            }
            let corners = part.patch(column, row).into_iter().zip(coarse);
            for (fine, coarse) in corners.filter(|(fine, _)| !fine.is_nan()) {
                bound[0] = bound[0].min(fine - coarse + f64::from(least));
                bound[1] = bound[1].max(fine - coarse + f64::from(greatest));
            }
        }
        [rounded_down(bound[0]), -rounded_down(-bound[1])]
    }
}

/// The largest single-precision number that is not above a height.
fn rounded_down(height: f64) -> f32 {
    let nearest = height as f32;
    if f64::from(nearest) > height {
        nearest.next_down()
    } else {
        nearest
    }
}
