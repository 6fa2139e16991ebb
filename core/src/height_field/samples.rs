//! Which samples lie under which triangle, as one linked list a triangle: an edit of the surface then looks at the
//! samples it concerns and at no others, and no sample is ever missed or seen twice.

use std::ops::Range;

use glam::DVec2;

use crate::height_field::finer::SurfacePoint;
use crate::height_field::reference::Reference;
use crate::height_field::scan;
use crate::height_field::surface::Surface;

/// End of a list.
const END: u32 = u32::MAX;
/// In no list.
const UNCOVERED: u32 = u32::MAX - 1;

/// A sample of the reference surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Column and row.
    pub(crate) at: DVec2,
    pub(crate) height: f64,
    /// Its number in the lists.
    index: u32,
}

impl From<SurfacePoint> for Sample {
    /// In no list.
    fn from(point: SurfacePoint) -> Self {
        Self {
            at: point.at,
            height: point.height,
            index: END,
        }
    }
}

/// The samples of a part of the grid, by triangle, and further places of the surface that turned out to matter.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleLists {
    window: Window,
    further: Vec<SurfacePoint>,
    /// The first sample under each triangle.
    heads: Vec<u32>,
    /// What follows each sample in its list.
    following: Vec<u32>,
}

impl SampleLists {
    /// Looks under every triangle of a surface. A sample on an edge goes to one of the two triangles.
    pub(crate) fn new(surface: &Surface) -> Self {
        let reference = surface.reference;
        let [columns, rows] = surface.window();
        let window = Window::new(&columns, &rows);
        let mut lists = Self {
            window,
            further: Vec::new(),
            heads: vec![END; surface.connectivity.triangle_slots() as usize],
            following: vec![UNCOVERED; window.columns * rows.len()],
        };
        for (triangle, corners) in surface.triangles() {
            let corners = corners.map(|corner| surface.point(corner).grid);
            window.visit_under(reference, corners, |sample| lists.put(triangle, &sample));
        }
        lists
    }

    /// Takes one more place into account; it is in no list yet.
    pub(crate) fn add(&mut self, point: SurfacePoint) -> Sample {
        self.further.push(point);
        self.following.push(UNCOVERED);
        Sample {
            index: self.following.len() as u32 - 1,
            ..Sample::from(point)
        }
    }

    /// Adds a sample to a triangle's list, if it is in none.
    pub(crate) fn put(&mut self, triangle: u32, sample: &Sample) {
        let following = &mut self.following[sample.index as usize];
        if *following == UNCOVERED {
            *following = std::mem::replace(&mut self.heads[triangle as usize], sample.index);
        }
    }

    /// Empties a triangle's list.
    pub(crate) fn clear(&mut self, triangle: u32) {
        let mut index = std::mem::replace(&mut self.heads[triangle as usize], END);
        while index != END {
            index = std::mem::replace(&mut self.following[index as usize], UNCOVERED);
        }
    }

    /// Appends a triangle's samples to `found`.
    #[inline]
    pub(crate) fn gather(&self, reference: &Reference, triangle: u32, found: &mut Vec<Sample>) {
        let mut index = self.heads[triangle as usize];
        while index != END {
            found.push(self.sample(reference, index));
            index = self.following[index as usize];
        }
    }

    #[inline]
    fn sample(&self, reference: &Reference, index: u32) -> Sample {
        let regular = self.following.len() - self.further.len();
        match (index as usize).checked_sub(regular) {
            None => self.window.sample(reference, index),
            Some(further) => Sample {
                index,
                ..Sample::from(self.further[further])
            },
        }
    }

    /// Appends the samples under a triangle that may have no list yet to `found`; those on edges may be there twice.
    pub(crate) fn gather_under(&self, reference: &Reference, corners: [DVec2; 3], found: &mut Vec<Sample>) {
        self.window.visit_under(reference, corners, |sample| found.push(sample));
    }
}

/// The part of the grid that has lists.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    /// Column and row.
    first: [u32; 2],
    columns: usize,
    /// 2^64 over the columns, rounded up.
    per_column: u64,
}

impl Window {
    fn new(columns: &Range<usize>, rows: &Range<usize>) -> Self {
        // The reciprocal of 1 would not fit.
        let width = columns.len().max(2);
        Self {
            first: [columns.start as u32, rows.start as u32],
            columns: width,
            per_column: u64::MAX / width as u64 + 1,
        }
    }

    #[inline]
    fn sample(&self, reference: &Reference, index: u32) -> Sample {
        // The upper half of a product instead of a division, which takes several times as long: exact for 32 bits (D. Lemire
        // et al., Faster remainder by direct computation, 2019).
        let down = ((u128::from(self.per_column) * u128::from(index)) >> 64) as u32;
        let across = index - down * self.columns as u32;
        let (column, row) = (across + self.first[0], down + self.first[1]);
        Sample {
            at: DVec2::new(f64::from(column), f64::from(row)),
            height: reference.heights.sample(column as usize, row as usize),
            index,
        }
    }

    fn visit_under(&self, reference: &Reference, corners: [DVec2; 3], mut visit: impl FnMut(Sample)) {
        scan::visit_rows(
            corners,
            [reference.heights.columns, reference.heights.rows],
            |row, columns| {
                for column in columns {
                    let index = (row - self.first[1] as usize) * self.columns + column - self.first[0] as usize;
                    let sample = self.sample(reference, index as u32);
                    if !sample.height.is_nan() {
                        visit(sample);
                    }
                }
            },
        );
    }
}
