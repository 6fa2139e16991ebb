//! Files of tensor-product Bézier patches, as the Utah teapot is handed around: numbers as text, between spaces or commas, in
//! one of four layouts.
//!
//! ```text
//!  written out      N, then for each patch its 16 points, a point being x y z
//!  with degrees     N, then for each patch its degrees along u and v and (degree + 1)·(degree + 1) points     (.bpt)
//!  indexed          BEZ V N, then V points, then for each patch the numbers of its 16 points, from 1 on
//!  Newell's         V, then V points, then N, then for each patch the numbers of its 16 points, from 1 on
//! ```
//! Which of them it is follows from the word `BEZ` and from how many numbers there are; points run along v first.

use std::io::Read;

use glam::DVec3;
use terrain_core::curved::tensor::{TensorError, TensorPatch};
use thiserror::Error;

/// How much a file may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BezierLimits {
    /// Bytes.
    pub bytes: u64,
    /// The degree of a patch along u and v.
    pub degree: usize,
}

impl Default for BezierLimits {
    fn default() -> Self {
        Self {
            bytes: 1 << 30,
            degree: 32,
        }
    }
}

/// Why a file holds no patches.
#[derive(Debug, Error)]
pub enum BezierError {
    /// The system says no.
    #[error("cannot be read")]
    Unreadable(#[from] std::io::Error),
    /// The numbers fit none of the layouts.
    #[error("not a readable file of Bézier patches: {0}")]
    Malformed(String),
    /// A number that is no point's.
    #[error("patch {patch} uses point {point}, but there are {count} (counted from 1)")]
    BadIndex {
        /// Which patch, counted from 0.
        patch: usize,
        /// What it uses.
        point: f64,
        /// Points there are.
        count: usize,
    },
    /// A patch that is none.
    #[error("patch {patch}: {error}")]
    NoPatch {
        /// Which patch, counted from 0.
        patch: usize,
        /// Why.
        error: TensorError,
    },
    /// More than the limits allow.
    #[error("more than {0}")]
    TooLarge(&'static str),
}

/// Control points of a bicubic patch.
const BICUBIC: usize = 16;

/// Reads all patches of a file.
///
/// # Errors
/// Where its numbers make no patches, or are more than `limits` allow.
pub fn read(file: impl Read, limits: BezierLimits) -> Result<Vec<TensorPatch>, BezierError> {
    let mut text = String::new();
    let length = file.take(limits.bytes + 1).read_to_string(&mut text)?;
    if length as u64 > limits.bytes {
        return Err(BezierError::TooLarge("the bytes that are read"));
    }
    let is_indexed = text.trim_start().starts_with("BEZ");
    let words = text.split(|character: char| character.is_whitespace() || character == ',');
    let words = words.filter(|word| !word.is_empty()).skip(usize::from(is_indexed));
    let numbers: Result<Vec<f64>, _> = words.map(|word| word.parse().map_err(|_| no_number(word))).collect();
    patches(Numbers { rest: &numbers? }, is_indexed, limits)
}

fn no_number(word: &str) -> BezierError {
    let word: String = word.chars().take(20).collect();
    BezierError::Malformed(format!("`{word}` is no number"))
}

fn patches(mut numbers: Numbers, is_indexed: bool, limits: BezierLimits) -> Result<Vec<TensorPatch>, BezierError> {
    let count = numbers.count()?;
    if is_indexed {
        let patches = numbers.count()?;
        let points = numbers.points(count)?;
        return indexed(numbers, &points, patches);
    }
    if Some(numbers.rest.len()) == count.checked_mul(3 * BICUBIC) {
        return written_out(numbers, count);
    }
    let mut after_points = Numbers {
        rest: numbers.rest.get(count.saturating_mul(3)..).unwrap_or_default(),
    };
    let is_newells = after_points
        .count()
        .is_ok_and(|patches| Some(after_points.rest.len()) == patches.checked_mul(BICUBIC));
    if is_newells {
        let points = numbers.points(count)?;
        let patches = numbers.count()?;
        return indexed(numbers, &points, patches);
    }
    with_degrees(numbers, count, limits)
}

fn written_out(mut numbers: Numbers, count: usize) -> Result<Vec<TensorPatch>, BezierError> {
    (0..count)
        .map(|patch| made(patch, numbers.points(BICUBIC)?, 4))
        .collect()
}

fn with_degrees(mut numbers: Numbers, count: usize, limits: BezierLimits) -> Result<Vec<TensorPatch>, BezierError> {
    let mut patches = Vec::new();
    for patch in 0..count {
        let [along_u, along_v] = [numbers.count()?, numbers.count()?];
        if along_u.max(along_v) > limits.degree {
            return Err(BezierError::TooLarge("the degree that is read"));
        }
        let points = numbers.points((along_u + 1) * (along_v + 1))?;
        patches.push(made(patch, points, along_v + 1)?);
    }
    numbers.end()?;
    Ok(patches)
}

fn indexed(mut numbers: Numbers, points: &[DVec3], count: usize) -> Result<Vec<TensorPatch>, BezierError> {
    let mut patches = Vec::new();
    for patch in 0..count {
        let found = numbers.take(BICUBIC)?.iter().map(|&number| {
            let point = (number >= 1.0 && number.fract() == 0.0)
                .then(|| points.get(number as usize - 1))
                .flatten();
            point.copied().ok_or(BezierError::BadIndex {
                patch,
                point: number,
                count: points.len(),
            })
        });
        patches.push(made(patch, found.collect::<Result<_, _>>()?, 4)?);
    }
    numbers.end()?;
    Ok(patches)
}

fn made(patch: usize, points: Vec<DVec3>, columns: usize) -> Result<TensorPatch, BezierError> {
    TensorPatch::new(points, columns).map_err(|error| BezierError::NoPatch { patch, error })
}

/// What was not read yet.
#[derive(Clone, Copy)]
struct Numbers<'a> {
    rest: &'a [f64],
}

impl<'a> Numbers<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [f64], BezierError> {
        let (taken, rest) = self
            .rest
            .split_at_checked(count)
            .ok_or_else(|| malformed("it ends too early"))?;
        self.rest = rest;
        Ok(taken)
    }

    /// A whole number, which nothing is allocated for.
    fn count(&mut self) -> Result<usize, BezierError> {
        match self.take(1)? {
            [count] if *count >= 0.0 && *count < 1e9 && count.fract() == 0.0 => Ok(*count as usize),
            _ => Err(malformed("a count is no whole number")),
        }
    }

    fn points(&mut self, count: usize) -> Result<Vec<DVec3>, BezierError> {
        let numbers = self.take(count.saturating_mul(3))?;
        Ok(numbers.chunks_exact(3).map(DVec3::from_slice).collect())
    }

    fn end(&self) -> Result<(), BezierError> {
        if self.rest.is_empty() {
            Ok(())
        } else {
            Err(malformed("there are numbers after the last patch"))
        }
    }
}

fn malformed(reason: &str) -> BezierError {
    BezierError::Malformed(reason.to_owned())
}

#[cfg(test)]
#[path = "bezier_tests.rs"]
mod tests;
