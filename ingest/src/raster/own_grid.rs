//! Files whose samples are much farther apart than those of the lattice: as far as they are alone, their own samples are kept, and
//! heights on the lattice follow from these whenever they are asked for.

use std::ops::Range;

use glam::{DAffine2, DVec2};
use serde::{Deserialize, Serialize};

use super::between::Between;
use super::layout::Frame;
use crate::georeference::{Crs, GeoReference, GeoReferenceError};

/// Samples of the lattice, across and down, between places that are asked for: those between are bilinear.
pub(crate) const NODES: usize = 16;
/// Cells of a file by which places may bend from one such place to the next but one.
const MOST_BENT: f64 = 1e-4;

/// Samples of a file between those of the lattice.
pub struct OwnGrid {
    record: OwnGridRecord,
    between: Between,
    /// Of the mosaic.
    georeference: GeoReference,
}

/// All that is known of it, written down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OwnGridRecord {
    /// Number of the file.
    pub(super) file: usize,
    pub(super) crs: Crs,
    /// As in a record of rasters.
    pub(super) to_crs: [f64; 6],
    pub(super) size: [usize; 2],
    pub(super) is_in_degrees: bool,
    pub(super) coarseness: f64,
    /// Columns and rows of the mosaic, the file's own reach.
    pub(super) extent: [Range<usize>; 2],
    /// Columns and rows of the mosaic, counted from its first, in which heights depend on other things, too.
    pub(super) composed: Vec<[Range<i64>; 2]>,
}

impl OwnGrid {
    /// On the lattice that `lattice` leads from, of which `georeference` is the mosaic.
    ///
    /// # Errors
    /// When PROJ does not know where the file is.
    pub(super) fn new(
        record: OwnGridRecord,
        lattice: (&Crs, DAffine2),
        georeference: &GeoReference,
    ) -> Result<Self, GeoReferenceError> {
        let to_crs = DAffine2::from_cols_array(&record.to_crs);
        let own = GeoReference::new(&record.crs, to_crs, record.size[0], record.size[1])?;
        let file = Frame {
            crs: &record.crs,
            to_crs,
            is_in_degrees: record.is_in_degrees,
        };
        Ok(Self {
            between: Between::new(lattice, file, own),
            georeference: georeference.clone(),
            record,
        })
    }

    pub(super) fn record(&self) -> &OwnGridRecord {
        &self.record
    }

    /// Number of the file.
    pub(crate) fn file(&self) -> usize {
        self.record.file
    }

    /// Columns and rows of the file.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.record.size
    }

    /// Sides of the file's cells in those of the lattice.
    pub(crate) fn coarseness(&self) -> f64 {
        self.record.coarseness
    }

    /// All that heights on the lattice depend on but the samples.
    pub(crate) fn fingerprint(&self) -> String {
        format!(
            "{:?} {:?} {}",
            self.record.crs,
            self.record.to_crs,
            self.georeference.of_lattice().fingerprint()
        )
    }

    /// Whether heights in a rectangle of the mosaic depend on nothing but this file.
    pub(crate) fn is_alone_in(&self, rectangle: &[Range<i64>; 2]) -> bool {
        let reaches = |other: &[Range<i64>; 2]| {
            (0..2).all(|axis| {
                let (other, own) = (&other[axis], &rectangle[axis]);
                other.start < own.end && own.start < other.end
            })
        };
        let extent = self
            .record
            .extent
            .each_ref()
            .map(|range| range.start as i64..range.end as i64);
        reaches(&extent) && !self.record.composed.iter().any(reaches)
    }

    /// Columns and rows of the file at each `step`-th sample of the mosaic from `first` on, row by row. `step` is a power of two; between
    /// each [`NODES`]-th place from `first` on they are bilinear, so that a place is the same from wherever a multiple of it is begun.
    pub(crate) fn places(&self, first: [i64; 2], step: usize, [columns, rows]: [usize; 2]) -> Vec<DVec2> {
        let at = |column: i64, row: i64| {
            let sample = DVec2::new((first[0] + column) as f64, (first[1] + row) as f64);
            self.between.place(&self.georeference, sample)
        };
        if step >= NODES {
            let in_row = |row: usize| (0..columns).map(move |column| at((column * step) as i64, (row * step) as i64));
            return (0..rows).flat_map(in_row).collect();
        }
        let nodes = [columns, rows].map(|count| (count - 1) * step / NODES + 2);
        let of_nodes: Vec<DVec2> = (0..nodes[0] * nodes[1])
            .map(|index| {
                let [column, row] = [index % nodes[0], index / nodes[0]].map(|node| (node * NODES) as i64);
                at(column, row)
            })
            .collect();
        let mut places = Vec::with_capacity(columns * rows);
        for row in (0..rows).map(|row| row * step) {
            let down = (row % NODES) as f64 / NODES as f64;
            let of_row = &of_nodes[row / NODES * nodes[0]..];
            for column in (0..columns).map(|column| column * step) {
                let across = (column % NODES) as f64 / NODES as f64;
                let node = column / NODES;
                let above = of_row[node].lerp(of_row[node + 1], across);
                let below = of_row[nodes[0] + node].lerp(of_row[nodes[0] + node + 1], across);
                places.push(above.lerp(below, down));
            }
        }
        places
    }

    /// Columns and rows of the file around all heights in `count` × `count` steps of [`NODES`] samples from `first` on; none where some
    /// place is beside the file, or places are too bent to be bilinear between.
    pub(crate) fn samples_under(&self, first: [i64; 2], count: usize) -> Option<[Range<usize>; 2]> {
        let side = count + 1;
        let places = self.places(first, NODES, [side, side]);
        let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let last = DVec2::new(self.record.size[0] as f64, self.record.size[1] as f64) - 1.0;
        let is_inside = places.iter().all(|place| place.is_finite())
            && (low - MOST_BENT).cmpge(DVec2::ZERO).all()
            && (high + MOST_BENT).cmple(last).all();
        if !is_inside || bend(&places, side).max_element() > MOST_BENT {
            return None;
        }
        Some(around(low - MOST_BENT, high + MOST_BENT, self.record.size))
    }

    /// Columns and rows of the file that heights in its reach may be made from.
    pub(crate) fn reached(&self) -> [Range<usize>; 2] {
        const STRETCHES: usize = 64;
        let [columns, rows] = &self.record.extent;
        let at = |range: &Range<usize>, step: usize| {
            range.start as f64 + (range.end - range.start) as f64 * step as f64 / STRETCHES as f64
        };
        let steps = (0..=STRETCHES).flat_map(|down| (0..=STRETCHES).map(move |across| (across, down)));
        let places: Vec<DVec2> = steps
            .map(|(across, down)| DVec2::new(at(columns, across), at(rows, down)))
            .map(|sample| self.between.place(&self.georeference, sample))
            .collect();
        if places.iter().any(|place| !place.is_finite()) {
            return self.record.size.map(|size| 0..size);
        }
        let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        // Between the places it may bulge by a small part of what lies between.
        let margin = (high - low) / STRETCHES as f64 + 2.0;
        around(low - margin, high + margin, self.record.size)
    }
}

/// Cells of a file by which places, `columns` in a row, bend from one to the next but one, across and down.
pub(crate) fn bend(places: &[DVec2], columns: usize) -> DVec2 {
    let second = |[a, b, c]: [DVec2; 3]| (a - 2.0 * b + c).abs();
    let across = places
        .chunks_exact(columns)
        .flat_map(|row| row.windows(3))
        .map(|three| second([three[0], three[1], three[2]]));
    let down = places
        .iter()
        .zip(&places[columns..])
        .zip(&places[2 * columns..])
        .map(|((&a, &b), &c)| second([a, b, c]));
    across.chain(down).fold(DVec2::ZERO, DVec2::max)
}

/// Samples of a file of some size with all cells from `low` to `high`.
fn around(low: DVec2, high: DVec2, size: [usize; 2]) -> [Range<usize>; 2] {
    [0, 1].map(|axis| {
        let first = (low[axis].floor().max(0.0) as usize).min(size[axis] - 1);
        first..((high[axis].max(0.0).floor() as usize).saturating_add(2)).clamp(first + 1, size[axis])
    })
}
