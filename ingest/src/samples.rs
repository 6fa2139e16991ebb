//! Samples of a raster by windows, wherever they are kept: nothing that is built or measured needs all of them at once.

use std::ops::Range;
use std::sync::Arc;

use anyhow::Result;
use serde::{Deserialize, Serialize};
use terrain_tiles::metadata::{Reading, Vertical};
use terrain_tiles::water::Water;

use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;
use crate::raster::{OwnGrid, ReadError, UNSPECIFIED};
use crate::store::Name;

/// A raster, or several on one lattice, from which samples are read.
pub trait Raster: Sync {
    /// Columns and rows of the rectangle around all samples.
    fn size(&self) -> [usize; 2];

    /// Column and row of the rectangle's first sample, on a lattice that stays the same when rasters are added.
    fn origin(&self) -> [i64; 2];

    /// Columns and rows of each file.
    fn extents(&self) -> Vec<[Range<usize>; 2]>;

    /// Sides of the cells of each file in those of the lattice; 1 where its samples are on it.
    fn coarseness(&self) -> Vec<f64>;

    /// Rows that are best read together.
    fn block_rows(&self) -> usize;

    /// Reads a rectangle of samples.
    ///
    /// # Errors
    /// When a file cannot be read.
    fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Rectangle, ReadError>;

    /// Files whose samples are much farther apart than those of the lattice: where they are alone, these are kept.
    fn own_grids(&self) -> &[Arc<OwnGrid>] {
        &[]
    }

    /// Reads samples of such a file: metres, row by row; NaN where void.
    ///
    /// # Errors
    /// When the file cannot be read.
    fn read_own(&self, own: &OwnGrid, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f32>, ReadError>;

    /// Where the samples are.
    fn georeference(&self) -> &GeoReference;

    /// Where the samples come from.
    fn provenance(&self) -> Provenance;

    /// Tells the person of samples that cannot be right: among those that are there, and what was found file by file.
    ///
    /// # Errors
    /// When no sample has a height.
    fn remark(&self, extremes: Option<Extremes>, faults: &[Faults]) -> Result<(), ReadError>;

    /// For each file, what must be the same for samples that were read of it before to be good still.
    fn stamps(&self) -> Vec<String>;
}

/// What was read of a rectangle.
pub struct Rectangle {
    /// Metres, row by row; NaN where void.
    pub heights: Vec<f32>,
    /// Indices, in order, of those that were not measured: voids that were filled.
    pub filled: Vec<usize>,
    /// For each file what cannot be right in it.
    pub faults: Vec<Faults>,
}

/// What cannot be right among the samples of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Faults {
    /// Samples that are infinite or beyond any height, and so became void.
    pub wild: u64,
    /// Samples of which files before this one have another height, which counts.
    pub disagreeing: u64,
    /// Metres by which they differ, at most.
    pub apart: f32,
    /// Voids that were filled from their rims.
    #[serde(default)]
    pub filled: u64,
}

impl Faults {
    /// Of both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            wild: self.wild + other.wild,
            disagreeing: self.disagreeing + other.disagreeing,
            apart: self.apart.max(other.apart),
            filled: self.filled + other.filled,
        }
    }
}

/// The lowest and the highest of some samples, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Extremes {
    /// Lowest sample.
    pub lowest: f32,
    /// How many samples are as low as that.
    pub lowest_count: u64,
    /// The lowest of the others; none where all are alike.
    pub second_lowest: Option<f32>,
    /// Highest sample.
    pub highest: f32,
}

impl Extremes {
    /// Of some samples; none where all are void.
    #[must_use]
    pub fn of(heights: &[f32]) -> Option<Self> {
        let there = heights.iter().copied().filter(|height| !height.is_nan());
        let alone = there.map(|height| Self {
            lowest: height,
            lowest_count: 1,
            second_lowest: None,
            highest: height,
        });
        alone.reduce(Self::with)
    }

    /// Of both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let lowest = self.lowest.min(other.lowest);
        let count = |of: &Self| if of.lowest == lowest { of.lowest_count } else { 0 };
        let others = [self, other]
            .into_iter()
            .flat_map(|of| [Some(of.lowest), of.second_lowest]);
        Self {
            lowest,
            lowest_count: count(&self) + count(&other),
            second_lowest: others.flatten().filter(|&height| height > lowest).reduce(f32::min),
            highest: self.highest.max(other.highest),
        }
    }
}

/// Where samples come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Names of the files without their folders.
    pub files: Vec<String>,
    /// Name of the files' vertical datum, `unspecified` where nothing says it.
    pub vertical_datum: String,
    /// What heights are above as they are read.
    pub heights_above: String,
    /// Grid that makes them so, if one does.
    pub geoid: Option<String>,
    /// Where there is water.
    pub water: Water,
    /// Lines that the surface keeps as edges, in coordinates of the rasters' reference system.
    #[serde(default)]
    pub breaklines: Vec<Vec<[f64; 2]>>,
    /// What was used instead of what the files say of themselves.
    pub overrides: Overrides,
}

/// What is used instead of what files say of themselves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Overrides {
    /// Coordinate reference system: a code as `EPSG:2056`, WKT, a PROJ string.
    pub crs: Option<String>,
    /// West, south, east, north edges of the outermost pixels, in units of the coordinate reference system.
    pub bounds: Option<[f64; 4]>,
    /// Vertical datum, and what heights are to be above.
    pub vertical: Vertical,
    /// How samples are read.
    #[serde(default)]
    pub reading: Reading,
}

/// A rectangle of samples, cut off at the raster's edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Column and row in the raster of the first sample.
    pub first: [usize; 2],
    /// Samples in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Row by row, metres; NaN where void.
    pub heights: Vec<f32>,
}

impl Window {
    /// The window without outer columns and rows that are all void; none where all are.
    pub(crate) fn without_void_edges(self) -> Option<Self> {
        let has_height = |index: &usize| !self.heights[*index].is_nan();
        let places: Vec<usize> = (0..self.heights.len()).filter(has_height).collect();
        let rows = places.first()? / self.columns..places.last()? / self.columns + 1;
        let of_column = places.iter().map(|place| place % self.columns);
        let columns = of_column.clone().min()?..of_column.max()? + 1;
        let row = |row: usize| &self.heights[row * self.columns..][columns.clone()];
        Some(Self {
            first: [self.first[0] + columns.start, self.first[1] + rows.start],
            columns: columns.len(),
            rows: rows.len(),
            heights: rows.flat_map(row).copied().collect(),
        })
    }
}

/// What gives windows of samples.
pub trait Samples: Sync {
    /// Columns and rows of the whole raster.
    fn size(&self) -> [usize; 2];

    /// The samples in these columns and rows, as far as the raster reaches.
    ///
    /// # Errors
    /// When they cannot be read.
    fn window(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Window>;

    /// Columns and rows of the samples among these that were not measured: voids that were filled. None where that is not known.
    ///
    /// # Errors
    /// When they cannot be read.
    fn filled(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Option<Vec<[usize; 2]>>>;

    /// Whether some sample in these columns and rows may have a height, as far as that is known without reading them.
    fn may_hold(&self, columns: Range<usize>, rows: Range<usize>) -> bool;

    /// Whether all samples in these columns and rows follow from others that are much farther apart.
    fn is_coarse(&self, _columns: Range<usize>, _rows: Range<usize>) -> bool {
        false
    }

    /// Heights in these columns and rows where [`Self::is_coarse`]; else none.
    ///
    /// # Errors
    /// When those cannot be read.
    fn coarse(&self, _columns: Range<usize>, _rows: Range<usize>) -> Result<Option<Box<dyn CoarseWindow + '_>>> {
        Ok(None)
    }
}

/// A rectangle of samples that follow from others, which are much farther apart: bilinear between these, and none is void.
pub trait CoarseWindow {
    /// Height of a sample, metres.
    fn height(&self, column: usize, row: usize) -> f32;

    /// Metres that samples side by side in a row or a column differ, at most.
    fn steepest(&self) -> f32;

    /// Columns and rows of the samples around each of those that all others follow from, in no order.
    fn around_own(&self) -> Vec<[usize; 2]>;
}

impl Raster for HeightGrid {
    fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    fn origin(&self) -> [i64; 2] {
        [0, 0]
    }

    fn extents(&self) -> Vec<[Range<usize>; 2]> {
        vec![[0..self.columns, 0..self.rows]]
    }

    fn coarseness(&self) -> Vec<f64> {
        vec![1.0]
    }

    fn block_rows(&self) -> usize {
        1
    }

    fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Rectangle, ReadError> {
        Ok(Rectangle {
            heights: self.heights_in(&columns, &rows),
            filled: Vec::new(),
            faults: vec![Faults::default()],
        })
    }

    fn read_own(&self, _own: &OwnGrid, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f32>, ReadError> {
        Ok(self.heights_in(&columns, &rows))
    }

    fn georeference(&self) -> &GeoReference {
        &self.georeference
    }

    fn provenance(&self) -> Provenance {
        Provenance {
            files: Vec::new(),
            vertical_datum: UNSPECIFIED.to_owned(),
            heights_above: UNSPECIFIED.to_owned(),
            geoid: None,
            water: Water::default(),
            breaklines: Vec::new(),
            overrides: Overrides::default(),
        }
    }

    fn remark(&self, _extremes: Option<Extremes>, _faults: &[Faults]) -> Result<(), ReadError> {
        Ok(())
    }

    fn stamps(&self) -> Vec<String> {
        let bytes: Vec<u8> = self.heights.iter().flat_map(|height| height.to_le_bytes()).collect();
        vec![Name::of([bytes.as_slice()]).to_string()]
    }
}

impl Samples for HeightGrid {
    fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    fn window(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Window> {
        let (columns, rows) = (
            columns.start..columns.end.min(self.columns),
            rows.start..rows.end.min(self.rows),
        );
        Ok(Window {
            first: [columns.start, rows.start],
            columns: columns.len(),
            rows: rows.len(),
            heights: self.heights_in(&columns, &rows),
        })
    }

    fn filled(&self, _columns: Range<usize>, _rows: Range<usize>) -> Result<Option<Vec<[usize; 2]>>> {
        Ok(None)
    }

    fn may_hold(&self, columns: Range<usize>, rows: Range<usize>) -> bool {
        columns.start < self.columns && rows.start < self.rows
    }
}

#[cfg(test)]
#[path = "samples_tests.rs"]
mod tests;
