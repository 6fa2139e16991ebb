//! Values that stand for voids and are not declared as such: usual ones, far outside all others of their file.
//!
//! ```text
//! ends  ← the lowest and highest few different values of a file, and how often they occur
//! range ← from the lowest to the highest of those that are no usual sign for voids
//! void  ← every usual sign that is farther from the range than the range is wide, and than 500 m
//! ```
//! A file is looked through before its first sample is given to anyone, so that what is void does not depend on what is read of it.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use super::ReadError;
use super::pieces::{cut, part_size};
use super::reader::Reader;
use crate::progress::Progress;

/// Values that programs write where there is no height.
const USUAL: [f64; 15] = [
    -32_768.0,
    -32_767.0,
    -9999.0,
    -999.0,
    -99_999.0,
    -999_999.0,
    -9_999_999.0,
    -2_147_483_648.0,
    32_767.0,
    65_535.0,
    9999.0,
    99_999.0,
    999_999.0,
    2_147_483_647.0,
    4_294_967_295.0,
];
/// No height in any unit is as large: ±3.4·10³⁸, 1.7·10³⁸, 10³⁰ and the like.
const HUGE: f64 = 1e29;
/// Metres that a void is from all heights, at least.
const FAR: f64 = 500.0;
/// Different values that are kept at each end.
const ENDS: usize = 8;
/// Samples that a file is looked through for; of larger ones every second piece, or third, …
const LOOKED_AT: usize = 1 << 26;

/// The stored values that stand for voids in a file.
pub(super) struct Voids {
    known: Mutex<Option<Arc<Values>>>,
    progress: Progress,
}

/// What is looked through.
pub(super) struct Looked<'a> {
    pub(super) path: &'a Path,
    pub(super) reader: &'a dyn Reader,
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// Samples of a block that is stored as one, across and down.
    pub(super) block: [usize; 2],
}

/// Stored values.
pub(super) struct Values(Vec<f64>);

impl Values {
    /// Values are said as decimals, and stored in single precision at times.
    pub(super) fn contain(&self, stored: f64) -> bool {
        self.0
            .iter()
            .any(|&void| stored == void || stored as f32 == void as f32)
    }
}

impl Voids {
    /// Where a person says which they are, none are looked for.
    pub(super) fn new(said: Option<Vec<f64>>, progress: &Progress) -> Self {
        Self {
            known: Mutex::new(said.map(|values| Arc::new(Values(values)))),
            progress: progress.clone(),
        }
    }

    /// Looks through the file if nobody has yet, and tells the person what was found.
    pub(super) fn values(&self, file: &Looked, scale: f64, offset: f64) -> Result<Arc<Values>, ReadError> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(values) = known.as_ref() {
            return Ok(Arc::clone(values));
        }
        let (ends, is_whole) = look_through(file)?;
        let found = ends.voids(scale);
        let path = file.path.display();
        for void in &found {
            self.progress
                .note(&format!("{path}: {}", void.remark(scale, offset, is_whole)));
        }
        let values = Arc::new(Values(found.iter().map(|void| void.value).collect()));
        *known = Some(Arc::clone(&values));
        Ok(values)
    }
}

/// The ends of a file's values, and whether all of it was looked at.
fn look_through(file: &Looked) -> Result<(Ends, bool), ReadError> {
    let [columns, rows] = file.size;
    // In many small pieces, a file in an archive would be unpacked again and again.
    let [width, height] = part_size(file.block, columns);
    let every = (columns * rows).div_ceil(LOOKED_AT);
    let mut ends = Ends::default();
    for rows in cut(&(0..rows), 0, height).step_by(every) {
        for columns in cut(&(0..columns), 0, width) {
            file.reader
                .stored(columns, rows.clone())?
                .into_iter()
                .for_each(|value| ends.add(value));
        }
    }
    Ok((ends, every == 1))
}

/// The lowest and the highest different values, each with how often it occurs.
#[derive(Default)]
struct Ends {
    /// From the end on.
    lowest: Vec<(f64, u64)>,
    highest: Vec<(f64, u64)>,
}

/// A value that stands for a void.
#[derive(Debug, PartialEq)]
struct Void {
    value: f64,
    count: u64,
    /// The least and the greatest of all values that are none.
    others: [f64; 2],
}

impl Ends {
    fn add(&mut self, value: f64) {
        if !value.is_nan() {
            keep(&mut self.lowest, value, |a, b| a < b);
            keep(&mut self.highest, value, |a, b| a > b);
        }
    }

    /// `scale` is metres in a unit of the stored values.
    fn voids(&self, scale: f64) -> Vec<Void> {
        let first = |end: &[(f64, u64)]| end.iter().map(|&(value, _)| value).find(|&value| !is_usual(value));
        let Some((low, high)) = first(&self.lowest).zip(first(&self.highest)) else {
            return Vec::new();
        };
        let far = (high - low).max(FAR / scale.abs());
        let is_far = |value: f64| low - value > far || value - high > far;
        let both = self.lowest.iter().chain(&self.highest);
        let mut found: Vec<Void> = both
            .filter(|&&(value, _)| is_usual(value) && is_far(value))
            .map(|&(value, count)| Void {
                value,
                count,
                others: [low, high],
            })
            .collect();
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
        found.dedup_by(|a, b| a.value == b.value);
        found
    }
}

/// Keeps a value if it is among the first by `is_before`.
fn keep(end: &mut Vec<(f64, u64)>, value: f64, is_before: impl Fn(f64, f64) -> bool) {
    if end.len() == ENDS && is_before(end[ENDS - 1].0, value) {
        return;
    }
    match end.iter().position(|&(kept, _)| !is_before(kept, value)) {
        Some(at) if end[at].0 == value => end[at].1 += 1,
        Some(at) => {
            end.insert(at, (value, 1));
            end.truncate(ENDS);
        }
        None => end.push((value, 1)),
    }
}

fn is_usual(value: f64) -> bool {
    value.abs() > HUGE || USUAL.contains(&value)
}

impl Void {
    fn remark(&self, scale: f64, offset: f64, is_whole: bool) -> String {
        let Self { value, count, others } = self;
        let [low, high] = others.map(|value| value * scale + offset);
        let least = if is_whole { "" } else { "at least " };
        format!(
            "{value} is stored in {least}{count} samples, all others have heights from {low} to {high} m: it is taken for a void. If it \
             is none, say --nodata none; to say it yourself, --nodata {value}"
        )
    }
}

#[cfg(test)]
#[path = "undeclared_tests.rs"]
mod tests;
