//! Lists of edge collapses as other programs write them (Surface Partitions §2.4).
//!
//! The **text form** has one collapse a line, in the order performed: the blue vertex, the red vertex and, where the
//! collapse moved the red vertex, its new position. Vertices are numbered from 0 in the order of the mesh. White space
//! separates; `#` begins a comment.
//!
//! ```text
//! # blue red [x y z]
//! 5 1
//! 6 2  2.0 0.5 1.25
//! ```
//!
//! The **JSON form** is an array with one array of the same two or five numbers for each collapse:
//! `[[5, 1], [6, 2, 2.0, 0.5, 1.25]]`.

use glam::DVec3;
use thiserror::Error;

use crate::levels::collapse_log::{Band, Collapse, CollapseLog, LogError};

/// One collapse of a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListedCollapse {
    /// The vertex that is removed.
    pub blue: u32,
    /// The vertex that remains.
    pub red: u32,
    /// Where the red vertex is from now on, if it moves.
    pub moved_to: Option<DVec3>,
}

/// Why a list cannot be read.
#[derive(Debug, Error)]
pub enum ListError {
    /// A word of the text form is no number.
    #[error("line {line}: {word:?} is not a number")]
    NotANumber {
        /// Counted from 1.
        line: usize,
        /// What stands there.
        word: String,
    },
    /// A line or an entry is not a collapse.
    #[error("{place}: a collapse is a blue and a red vertex (whole numbers) and perhaps a position x y z")]
    NotACollapse {
        /// The line, counted from 1, or the entry, counted from 0.
        place: String,
    },
    /// Not JSON, or not an array of arrays of numbers.
    #[error("the list of collapses is not an array of arrays of numbers")]
    Json(#[from] serde_json::Error),
}

/// Reads the text form.
///
/// # Errors
/// The first line that is not a collapse.
pub fn parse_text(text: &str) -> Result<Vec<ListedCollapse>, ListError> {
    let mut list = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let words = content.split('#').next().unwrap_or_default().split_whitespace();
        let number = |word: &str| {
            let not_a_number = |_| ListError::NotANumber {
                line,
                word: word.to_owned(),
            };
            word.parse::<f64>().map_err(not_a_number)
        };
        let numbers = words.map(number).collect::<Result<Vec<f64>, _>>()?;
        if !numbers.is_empty() {
            list.push(listed(&numbers, || format!("line {line}"))?);
        }
    }
    Ok(list)
}

/// Reads the JSON form.
///
/// # Errors
/// Where it is not JSON, or the first entry that is not a collapse.
pub fn parse_json(text: &str) -> Result<Vec<ListedCollapse>, ListError> {
    let entries: Vec<Vec<f64>> = serde_json::from_str(text)?;
    let numbered = entries.iter().enumerate();
    numbered
        .map(|(index, numbers)| listed(numbers, || format!("entry {index}")))
        .collect()
}

/// The log that a list stands for, on vertices at `positions`, in one band of certified error `error`; infinity where
/// none is known. Whether the collapses are valid is for the replay to find.
///
/// # Errors
/// Where a red vertex is not of the mesh.
pub fn to_log(list: &[ListedCollapse], positions: &[DVec3], error: f64) -> Result<CollapseLog, LogError> {
    let mut current = positions.to_vec();
    let collapse = |(index, listed): (usize, &ListedCollapse)| {
        let place = current
            .get_mut(listed.red as usize)
            .ok_or(LogError::BadVertices(index))?;
        let red_before = *place;
        *place = listed.moved_to.unwrap_or(red_before);
        Ok(Collapse {
            blue: listed.blue,
            red: listed.red,
            red_before,
            red_after: *place,
            closes_hole: false,
        })
    };
    let collapses = list
        .iter()
        .enumerate()
        .map(collapse)
        .collect::<Result<Vec<_>, LogError>>()?;
    let bands = vec![Band {
        end: collapses.len(),
        error,
    }];
    Ok(CollapseLog { collapses, bands })
}

fn listed(numbers: &[f64], place: impl Fn() -> String) -> Result<ListedCollapse, ListError> {
    let moved_to = match numbers {
        [_, _] => Some(None),
        [_, _, position @ ..] if position.len() == 3 => Some(Some(DVec3::from_slice(position))),
        _ => None,
    };
    let read = || {
        let moved_to = moved_to?;
        let is_finite = moved_to.is_none_or(DVec3::is_finite);
        Some(ListedCollapse {
            blue: whole(numbers[0])?,
            red: whole(numbers[1])?,
            moved_to: is_finite.then_some(moved_to)?,
        })
    };
    read().ok_or_else(|| ListError::NotACollapse { place: place() })
}

fn whole(number: f64) -> Option<u32> {
    let is_whole = number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number);
    is_whole.then_some(number as u32)
}

#[cfg(test)]
#[path = "collapse_list_tests.rs"]
mod tests;
