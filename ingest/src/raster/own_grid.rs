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

/// Cells of a file beyond its reach that may be asked for, where it is four times as coarse as the lattice, with those around them.
const BEYOND: f64 = 8.0;

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

impl OwnGridRecord {
    fn to_crs(&self) -> DAffine2 {
        DAffine2::from_cols_array(&self.to_crs)
    }

    /// Where the file's samples are on the Earth.
    ///
    /// # Errors
    /// When PROJ does not know it.
    pub(super) fn georeference(&self) -> Result<GeoReference, GeoReferenceError> {
        GeoReference::new(&self.crs, self.to_crs(), self.size[0], self.size[1])
    }
}

impl OwnGrid {
    /// On the lattice that `lattice` leads from, of which `georeference` is the mosaic; `own` is where the file's samples are on the Earth.
    pub(super) fn new(
        record: OwnGridRecord,
        lattice: (&Crs, DAffine2),
        own: GeoReference,
        georeference: &GeoReference,
    ) -> Self {
        let file = Frame {
            crs: &record.crs,
            to_crs: record.to_crs(),
            is_in_degrees: record.is_in_degrees,
        };
        Self {
            between: Between::new(lattice, file, own),
            georeference: georeference.clone(),
            record,
        }
    }

    pub(super) fn record(&self) -> &OwnGridRecord {
        &self.record
    }

    /// Where the file's samples are on the Earth.
    pub(super) fn own(&self) -> &GeoReference {
        &self.between.own
    }

    /// Number of the file.
    pub(crate) fn file(&self) -> usize {
        self.record.file
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
        let is_in_reach = (0..2).all(|axis| {
            let (extent, own) = (&self.record.extent[axis], &rectangle[axis]);
            extent.start as i64 <= own.start && own.end <= extent.end as i64
        });
        let reaches = |other: &[Range<i64>; 2]| {
            (0..2).all(|axis| {
                let (other, own) = (&other[axis], &rectangle[axis]);
                other.start < own.end && own.start < other.end
            })
        };
        is_in_reach && !self.record.composed.iter().any(reaches)
    }

    /// Columns and rows of the file at samples of the mosaic from `first` on: at each `apart`-th, and bilinear between these. Where `apart` is
    /// [`NODES`], a place is the same from wherever a multiple of it is begun. There are `columns` × `rows` that are not between others.
    pub(crate) fn places(&self, first: [i64; 2], apart: usize, [columns, rows]: [usize; 2]) -> Places {
        let place = |index: usize| {
            let [column, row] = [index % columns, index / columns].map(|node| (node * apart) as i64);
            self.place([first[0] + column, first[1] + row])
        };
        Places {
            nodes: (0..columns * rows).map(place).collect(),
            across: columns,
            apart,
        }
    }

    /// Column and row of the file at a sample of the mosaic.
    pub(crate) fn place(&self, [column, row]: [i64; 2]) -> DVec2 {
        self.between
            .place(&self.georeference, DVec2::new(column as f64, row as f64))
    }

    /// Columns and rows of the mosaic at a sample of the file, once around the Earth to the west and to the east, too.
    pub(crate) fn on_mosaic(&self, column: usize, row: usize) -> [DVec2; 3] {
        let place = self.own().geographic(DVec2::new(column as f64, row as f64));
        [-360.0, 0.0, 360.0].map(|turn| self.georeference.grid(place + DVec2::new(turn, 0.0)))
    }

    /// Columns and rows of the file around all heights in `count` × `count` steps of [`NODES`] samples from `first` on; none where some
    /// place is beside the file, or places are too bent to be bilinear between.
    pub(crate) fn samples_under(&self, first: [i64; 2], count: usize) -> Option<[Range<usize>; 2]> {
        let places = self.places(first, NODES, [count + 1, count + 1]);
        let last = DVec2::new(self.record.size[0] as f64, self.record.size[1] as f64) - 1.0;
        let is_inside = |place: &DVec2| {
            place.is_finite() && (place - MOST_BENT).cmpge(DVec2::ZERO).all() && (place + MOST_BENT).cmple(last).all()
        };
        let is_usable = places.nodes.iter().all(is_inside) && places.bend().max_element() <= MOST_BENT;
        is_usable.then(|| self.samples_around(&places.nodes, DVec2::splat(MOST_BENT)))
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
        // Between the places it may bulge by a small part of what lies between; and chunks ask for places one step beyond their last.
        let [low, high] = extent(&places);
        self.samples_around(&places, (high - low) / STRETCHES as f64 + BEYOND)
    }

    /// Columns and rows of the file with all cells that are no more than `margin` cells beside some places.
    pub(crate) fn samples_around(&self, places: &[DVec2], margin: DVec2) -> [Range<usize>; 2] {
        let [low, high] = extent(places);
        let (low, high) = ((low - margin).max(DVec2::ZERO), (high + margin).max(DVec2::ZERO));
        [0, 1].map(|axis| {
            let size = self.record.size[axis];
            let first = (low[axis] as usize).min(size - 2);
            first..(high[axis] as usize).saturating_add(2).clamp(first + 2, size)
        })
    }
}

/// Places of samples of the lattice in a file, its columns and rows.
#[derive(Debug)]
pub(crate) struct Places {
    /// At every `apart`-th sample, `across` in a row.
    pub(crate) nodes: Vec<DVec2>,
    pub(crate) across: usize,
    pub(crate) apart: usize,
}

impl Places {
    /// Of a sample, so many columns and rows after the first.
    pub(crate) fn at(&self, column: usize, row: usize) -> DVec2 {
        let first = row / self.apart * self.across + column / self.apart;
        let node = |right: usize, below: usize| self.nodes[first + below * self.across + right];
        between(node, [column, row], self.apart)
    }

    /// Cells of the file by which nodes bend from one to the next but one, at most, across and down.
    pub(crate) fn bend(&self) -> DVec2 {
        let second = |[a, b, c]: [DVec2; 3]| (a - 2.0 * b + c).abs();
        let across = self
            .nodes
            .chunks_exact(self.across)
            .flat_map(|row| row.windows(3))
            .map(|three| second([three[0], three[1], three[2]]));
        let down = self
            .nodes
            .iter()
            .zip(&self.nodes[self.across..])
            .zip(&self.nodes[2 * self.across..])
            .map(|((&a, &b), &c)| second([a, b, c]));
        across.chain(down).fold(DVec2::ZERO, DVec2::max)
    }
}

/// The place of a sample between four nodes, `apart` samples from each other: `node` gives the one that is so many to the right and
/// below. Only the first is asked for where the sample is at it.
pub(crate) fn between(node: impl Fn(usize, usize) -> DVec2, [column, row]: [usize; 2], apart: usize) -> DVec2 {
    let share = |samples: usize| (samples % apart) as f64 / apart as f64;
    let (across, down) = (share(column), share(row));
    if across == 0.0 && down == 0.0 {
        return node(0, 0);
    }
    let above = node(0, 0).lerp(node(1, 0), across);
    let below = node(0, 1).lerp(node(1, 1), across);
    above.lerp(below, down)
}

/// The least and the greatest of some places, in both directions.
fn extent(places: &[DVec2]) -> [DVec2; 2] {
    let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    [low, places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max)]
}
