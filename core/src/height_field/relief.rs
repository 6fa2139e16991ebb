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

use std::fmt::Debug;
use std::sync::Arc;

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
    /// What gives corners and bounds one by one, all of the former samples; the lists of both are empty then.
    pub computed: Option<Computed>,
}

/// Blocks that follow from less than what they hold: cheaper made each time that they are asked for than kept.
pub trait Blocks: Debug + Send + Sync {
    /// Height at a corner, metres.
    fn corner(&self, column: usize, row: usize) -> f32;

    /// Bound of a block, as in [`Chunk::residuals`]; 0 at level 0.
    fn residual(&self, column: usize, row: usize) -> [f32; 2];

    /// What it takes in memory, bytes.
    fn bytes(&self) -> usize;
}

/// Blocks that are made when they are asked for.
#[derive(Clone, Debug)]
pub struct Computed(pub Arc<dyn Blocks>);

impl PartialEq for Computed {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
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
            computed: None,
        })
    }

    /// What it takes in memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let computed = self.computed.as_ref().map_or(0, |computed| computed.0.bytes());
        computed + 4 * self.corners.len() + 8 * self.residuals.len()
    }

    /// With all corners and bounds as lists, where it has none yet.
    fn listed(&self) -> Option<Self> {
        let Computed(blocks) = self.computed.as_ref()?;
        let corners = (0..CORNERS * CORNERS).map(|index| blocks.corner(index % CORNERS, index / CORNERS));
        let residuals = (0..CHUNK * CHUNK).map(|index| blocks.residual(index % CHUNK, index / CHUNK));
        Some(Self {
            corners: corners.collect(),
            residuals: residuals.collect(),
            computed: None,
            guessed: Vec::new(),
            steepest: self.steepest,
        })
    }

    /// The chunk over four of the level below: north-west, north-east, south-west, south-east in the order of rows. None
    /// where nothing is below.
    #[must_use]
    pub fn over(parts: [Option<&Self>; 4]) -> Option<Self> {
        let listed = parts.map(|part| part.and_then(Self::listed));
        let parts = [0, 1, 2, 3].map(|part| listed[part].as_ref().or(parts[part]));
        parts.iter().any(Option::is_some).then(|| {
            let finer = Finer::new(parts);
            let mut chunk = Self {
                steepest: parts.iter().flatten().map(|part| part.steepest).fold(0.0, f32::max),
                corners: Vec::with_capacity(CORNERS * CORNERS),
                guessed: Vec::new(),
                residuals: Vec::with_capacity(CHUNK * CHUNK),
                computed: None,
            };
            for index in 0..CORNERS * CORNERS {
                let below = [2 * (index % CORNERS), 2 * (index / CORNERS)];
                let mut corner = finer.sample(below);
                if corner.is_nan() {
                    chunk.guessed.push(index as u32);
                    corner = finer.corner_or_mean(below);
                }
                chunk.corners.push(corner);
            }
            for index in 0..CHUNK * CHUNK {
                let (column, row) = (index % CHUNK, index / CHUNK);
                let patch = completed(chunk.corners_of(column, row));
                let residual = finer.residual_over(patch, 2 * column, 2 * row);
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
        let patch = self.corners_of(column, row);
        if self.residuals.is_empty() {
            patch
        } else {
            completed(patch)
        }
    }

    /// Whether all corners of its blocks are known to be samples.
    #[must_use]
    #[inline]
    pub fn is_sampled(&self) -> bool {
        self.computed.is_some() || !self.residuals.is_empty() && self.guessed.is_empty()
    }

    #[inline]
    fn corners_of(&self, column: usize, row: usize) -> [f64; 4] {
        if let Some(Computed(blocks)) = &self.computed {
            let corners = [[0, 0], [1, 0], [0, 1], [1, 1]];
            return corners.map(|[across, down]| f64::from(blocks.corner(column + across, row + down)));
        }
        let first = row * CORNERS + column;
        [first, first + 1, first + CORNERS, first + CORNERS + 1].map(|index| f64::from(self.corners[index]))
    }

    /// The sample at a corner; NaN where it is void.
    #[must_use]
    pub fn sample(&self, column: usize, row: usize) -> f32 {
        if let Some(Computed(blocks)) = &self.computed {
            return blocks.corner(column, row);
        }
        let index = row * CORNERS + column;
        match self.guessed.binary_search(&(index as u32)) {
            Ok(_) => f32::NAN,
            Err(_) => self.corners[index],
        }
    }

    /// The sample at a corner of a chunk of level 0, where all corners are samples; NaN where it is void.
    #[inline(always)]
    pub(crate) fn sample_at_level_0(&self, column: usize, row: usize) -> f32 {
        match &self.computed {
            None => self.corners[row * CORNERS + column],
            Some(Computed(blocks)) => blocks.corner(column, row),
        }
    }

    /// The bound of a block, metres above its patch: least and greatest.
    #[must_use]
    #[inline]
    pub fn residual(&self, column: usize, row: usize) -> [f32; 2] {
        if let Some(Computed(blocks)) = &self.computed {
            return blocks.residual(column, row);
        }
        match self.residuals.get(row * CHUNK + column) {
            Some(&residual) => residual,
            None if self.patch(column, row).iter().all(|corner| corner.is_nan()) => NO_SURFACE,
            None => [0.0; 2],
        }
    }

    /// The bound of four blocks side by side against one patch over them all; `column` and `row` are the first one's.
    fn residual_of_four(&self, [a, b, c, d]: [f64; 4], column: usize, row: usize) -> [f32; 2] {
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
            let [least, greatest] = self.residual(column, row).map(f64::from);
            if least > greatest {
                continue;
            }
            for (fine, coarse) in self.patch(column, row).into_iter().zip(coarse) {
                // The difference from a void is NaN, and both take the other one.
                bound[0] = bound[0].min(fine - coarse + least);
                bound[1] = bound[1].max(fine - coarse + greatest);
            }
        }
        [rounded_down(bound[0]), -rounded_down(-bound[1])]
    }
}

/// Corners along the side of four chunks.
const FINER_CORNERS: usize = 2 * CHUNK + 1;

/// Four chunks of a level side by side.
struct Finer<'a> {
    parts: [Option<&'a Chunk>; 4],
    /// [`FINER_CORNERS`] × [`FINER_CORNERS`], row by row.
    corners: Vec<f32>,
    /// The same, NaN where the corner is no sample.
    samples: Vec<f32>,
}

impl<'a> Finer<'a> {
    /// A corner between parts is in all of them; one that is missing must not hide it.
    fn new(parts: [Option<&'a Chunk>; 4]) -> Self {
        let mut corners = vec![f32::NAN; FINER_CORNERS * FINER_CORNERS];
        let mut samples = corners.clone();
        for (place, part) in parts.into_iter().enumerate() {
            if let Some(part) = part {
                lay(&part.corners, place, &mut corners);
                let mut of_part = part.corners.clone();
                part.guessed
                    .iter()
                    .for_each(|&index| of_part[index as usize] = f32::NAN);
                lay(&of_part, place, &mut samples);
            }
        }
        Self {
            parts,
            corners,
            samples,
        }
    }

    fn sample(&self, [column, row]: [usize; 2]) -> f32 {
        self.samples[row * FINER_CORNERS + column]
    }

    fn corner_or_mean(&self, [column, row]: [usize; 2]) -> f32 {
        let own = self.corners[row * FINER_CORNERS + column];
        if !own.is_nan() {
            return own;
        }
        let beside = |place: usize| place.saturating_sub(1)..=(place + 1).min(2 * CHUNK);
        let around = beside(row).flat_map(|row| &self.corners[row * FINER_CORNERS..][beside(column)]);
        let (sum, count) = around
            .filter(|corner| !corner.is_nan())
            .fold((0.0, 0_u32), |(sum, count), &corner| {
                (sum + f64::from(corner), count + 1)
            });
        (sum / f64::from(count)) as f32
    }

    /// The bound of a block over `patch`, from its four parts, which are all in one chunk.
    fn residual_over(&self, patch: [f64; 4], column: usize, row: usize) -> [f32; 2] {
        match self.parts[2 * (row / CHUNK) + column / CHUNK] {
            Some(part) if !patch[0].is_nan() => part.residual_of_four(patch, column % CHUNK, row % CHUNK),
            _ => NO_SURFACE,
        }
    }
}

/// Lays the corners of one of four parts among those of all that are not NaN.
fn lay(of_part: &[f32], place: usize, corners: &mut [f32]) {
    let first = (place / 2 * FINER_CORNERS + place % 2) * CHUNK;
    for (row, of_row) in of_part.chunks_exact(CORNERS).enumerate() {
        for (corner, &of_part) in corners[first + row * FINER_CORNERS..].iter_mut().zip(of_row) {
            *corner = if of_part.is_nan() { *corner } else { of_part };
        }
    }
}

/// Corners of a block with the mean of the others where one is NaN; all of them are where the block has no surface.
#[inline]
fn completed(patch: [f64; 4]) -> [f64; 4] {
    if !(patch[0] + patch[1] + patch[2] + patch[3]).is_nan() {
        return patch;
    }
    let known = patch.into_iter().filter(|corner| !corner.is_nan());
    let mean = known.clone().sum::<f64>() / known.count() as f64;
    patch.map(|corner| if corner.is_nan() { mean } else { corner })
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
