//! One lattice of samples over several files.
//!
//! It is that of the first file, if the samples of all others are on it, else that of the file with the finest cells. Files whose
//! samples are elsewhere are read between them.

use std::ops::Range;

use glam::{DAffine2, DVec2};

use super::between::{self, Between, FARTHEST};
use super::layout::Layout;
use super::placement;
use super::{RasterLimits, ReadError};
use crate::georeference::{GeoReference, nearest_turn};

/// Largest distance, in cells, of a file's samples from the lattice that they are on.
const MISALIGNMENT: f64 = 0.01;
/// Cells whose sides differ by less than that share are equally fine.
const EQUALLY_FINE: f64 = 0.01;

/// Where files lie on one lattice.
pub(super) struct Mosaic {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Column and row of its first sample, on the lattice.
    pub(super) origin: [i64; 2],
    /// Number of the file that the lattice is of.
    pub(super) lattice: usize,
    /// From the lattice's columns and rows.
    pub(super) to_crs: DAffine2,
    pub(super) places: Vec<Place>,
    /// Numbers of the files, those first whose heights count where several have one.
    pub(super) ranks: Vec<usize>,
}

/// Where a file is.
pub(super) struct Place {
    /// Columns and rows of the mosaic that it reaches into.
    pub(super) extent: [Range<usize>; 2],
    /// How its samples are found where they are not on the lattice.
    pub(super) between: Option<Between>,
    /// Sides of its cells in those of the lattice: 1 where its samples are on it.
    pub(super) coarseness: f64,
}

/// How files are put together.
#[derive(Clone, Copy)]
pub(super) struct Rules {
    /// How many of the files, the last ones, are below and around all others.
    pub(super) underlays: usize,
    /// Metres that these reach beyond the others; as far as the others are wide, by halves, if not given.
    pub(super) around: Option<f64>,
    /// Whether files count in their order, whatever their cells.
    pub(super) by_order: bool,
    pub(super) limits: RasterLimits,
}

/// A file before the lattice is known.
struct File<'a> {
    layout: &'a Layout,
    /// Where its samples are on the Earth, where files have different cells.
    own: Option<GeoReference>,
    /// Metres of a side of its cells, where these differ from file to file.
    cell: f64,
}

/// A file before the mosaic has its size: on the lattice.
struct Found {
    extent: [Range<i64>; 2],
    between: Option<Between>,
    /// Metres of a side of its cells, where these differ from file to file.
    cell: f64,
}

impl Mosaic {
    /// The smallest grid over all `files`.
    pub(super) fn new(files: &[&Layout], rules: Rules) -> Result<Self, ReadError> {
        let first = *files.first().ok_or(ReadError::NoFile)?;
        let is_one_lattice = files.iter().all(|file| offset(first, file).is_some());
        let file = |&layout| File::new(layout, is_one_lattice);
        let files = files.iter().map(file).collect::<Result<Vec<_>, _>>()?;
        let (measured, underlays) = files.split_at(files.len() - rules.underlays);
        let lattice = finest(measured);
        let of_lattice = measured.get(lattice).ok_or(ReadError::NoFile)?;
        let mut found = measured
            .iter()
            .map(|file| find(of_lattice.layout, file))
            .collect::<Result<Vec<_>, _>>()?;
        let around = rectangle_around(&found, rules.around, of_lattice)?;
        for file in underlays {
            found.push(below(of_lattice.layout, file, &around)?);
        }
        let ranks = ranks(&files, measured.len(), rules.by_order);
        Self::over(of_lattice.layout, lattice, found, ranks, rules.limits)
    }

    fn over(
        first: &Layout,
        lattice: usize,
        found: Vec<Found>,
        ranks: Vec<usize>,
        limits: RasterLimits,
    ) -> Result<Self, ReadError> {
        let [columns, rows] = union(&found);
        let size = [&columns, &rows].map(|range| (range.end - range.start) as usize);
        placement::check_size(&first.path, size[0], size[1], limits.samples)?;
        let origin = [columns.start, rows.start];
        let finest = found[lattice].cell;
        let place = |file: Found| Place {
            extent: [0, 1].map(|axis| {
                let range = &file.extent[axis];
                (range.start - origin[axis]) as usize..(range.end - origin[axis]) as usize
            }),
            between: file.between,
            coarseness: file.cell / finest,
        };
        Ok(Self {
            columns: size[0],
            rows: size[1],
            origin,
            lattice,
            to_crs: first.to_crs,
            places: found.into_iter().map(place).collect(),
            ranks,
        })
    }
}

impl<'a> File<'a> {
    /// `is_alike` where all files have the same cells.
    fn new(layout: &'a Layout, is_alike: bool) -> Result<Self, ReadError> {
        let own = (!is_alike).then(|| georeference(layout)).transpose()?;
        let cell = match &own {
            _ if is_alike => 1.0,
            Some(own) => {
                let sides = own.cell_metres(DVec2::new(layout.columns as f64, layout.rows as f64) / 2.0);
                (sides.x * sides.y).sqrt()
            }
            None => layout.to_crs.matrix2.determinant().abs().sqrt(),
        };
        Ok(Self { layout, own, cell })
    }

    /// Where its samples are on the Earth.
    fn georeference(&self) -> Result<GeoReference, ReadError> {
        self.own.clone().map_or_else(|| georeference(self.layout), Ok)
    }
}

/// The file with the finest cells, the first of several.
fn finest(files: &[File]) -> usize {
    let least = files.iter().map(|file| file.cell).fold(f64::INFINITY, f64::min);
    files
        .iter()
        .position(|file| file.cell <= least * (1.0 + EQUALLY_FINE))
        .unwrap_or(0)
}

/// Underlays last; finer cells first, unless files count in their order.
fn ranks(files: &[File], measured: usize, by_order: bool) -> Vec<usize> {
    let mut ranks: Vec<usize> = (0..files.len()).collect();
    let fineness = |file: usize| (files[file].cell.ln() / EQUALLY_FINE.ln_1p()).round() as i64;
    ranks.sort_by_key(|&file| (file >= measured, if by_order { 0 } else { fineness(file) }, file));
    ranks
}

fn find(lattice: &Layout, file: &File) -> Result<Found, ReadError> {
    let layout = file.layout;
    let Some(offset) = offset(lattice, layout) else {
        return Ok(Found {
            extent: between::reach(lattice, layout)?,
            between: Some(Between::new(
                (&lattice.crs, lattice.to_crs),
                layout.frame(),
                file.georeference()?,
            )),
            cell: file.cell,
        });
    };
    let [left, top] = [offset.x as i64, offset.y as i64];
    Ok(Found {
        extent: [left..left + layout.columns as i64, top..top + layout.rows as i64],
        between: None,
        cell: file.cell,
    })
}

/// A file that is below and around others, as far as `around` reaches.
fn below(lattice: &Layout, file: &File, around: &[Range<i64>; 2]) -> Result<Found, ReadError> {
    let within = |reach: [Range<i64>; 2]| {
        [0, 1].map(|axis| {
            let start = reach[axis].start.clamp(around[axis].start, around[axis].end);
            start..reach[axis].end.clamp(start, around[axis].end)
        })
    };
    // A file as large as the Earth has no place on the plane of a small one's reference system: it is asked everywhere.
    let extent = match between::reach(lattice, file.layout) {
        Ok(reach) if !between::is_around(file.layout) => within(reach),
        _ => around.clone(),
    };
    Ok(Found {
        extent,
        between: Some(Between::new(
            (&lattice.crs, lattice.to_crs),
            file.layout.frame(),
            file.georeference()?,
        )),
        cell: file.cell,
    })
}

/// The rectangle of all files and so many metres around them, or half its size.
fn rectangle_around(found: &[Found], metres: Option<f64>, lattice: &File) -> Result<[Range<i64>; 2], ReadError> {
    let rectangle = union(found);
    let margins = match metres {
        None => [0, 1].map(|axis| (rectangle[axis].end - rectangle[axis].start) / 2),
        Some(metres) => {
            let layout = lattice.layout;
            let cell = lattice
                .georeference()?
                .cell_metres(DVec2::new(layout.columns as f64, layout.rows as f64) / 2.0);
            [0, 1].map(|axis| (metres / cell[axis]).ceil() as i64)
        }
    };
    Ok([0, 1].map(|axis| rectangle[axis].start - margins[axis]..rectangle[axis].end + margins[axis]))
}

fn union(found: &[Found]) -> [Range<i64>; 2] {
    [0, 1].map(|axis| {
        let starts = found.iter().map(|file| file.extent[axis].start);
        let ends = found.iter().map(|file| file.extent[axis].end);
        starts.min().unwrap_or(0)..ends.max().unwrap_or(0)
    })
}

fn georeference(file: &Layout) -> Result<GeoReference, ReadError> {
    GeoReference::new(&file.crs, file.to_crs, file.columns, file.rows)
        .map_err(|source| ReadError::Position(file.path.clone(), source))
}

/// Whole cells from the first sample of `first` to that of `layout`, on the lattice of `first`; none where it is not on that.
fn offset(first: &Layout, layout: &Layout) -> Option<DVec2> {
    let to_first = first.to_crs.inverse() * turned_to(first, layout);
    let last = DVec2::new((layout.columns - 1) as f64, (layout.rows - 1) as f64);
    let begin = to_first.transform_point2(DVec2::ZERO);
    let drift = (to_first.transform_point2(last) - begin - last).abs().max_element();
    let cells = begin.round();
    let shift = (begin - cells).abs().max_element();
    let is_on_lattice = layout.crs == first.crs
        && drift <= MISALIGNMENT
        && shift <= MISALIGNMENT
        && cells.abs().max_element() <= FARTHEST;
    is_on_lattice.then_some(cells)
}

/// The layout's transform, turned by whole turns of longitude where that brings it nearer to `first`: two files on
/// either side of the antimeridian are neighbours.
fn turned_to(first: &Layout, layout: &Layout) -> DAffine2 {
    let mut to_crs = layout.to_crs;
    if first.is_in_degrees {
        to_crs.translation = nearest_turn(to_crs.translation, first.to_crs.translation.x);
    }
    to_crs
}
