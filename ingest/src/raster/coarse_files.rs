//! Which files are so coarse that they are kept as they are, and where each is alone.

use std::ops::Range;
use std::sync::Arc;

use super::between;
use super::mosaic::{self, Mosaic};
use super::own_grid::{OwnGrid, OwnGridRecord};
use super::source::Source;
use super::water::Lake;
use crate::georeference::GeoReference;

/// Files whose cells have sides so many times as long as the lattice's are kept as they are.
const COARSE: f64 = 4.0;

/// Files on one lattice, and what else their heights depend on.
pub(super) struct FilesOnLattice<'a> {
    pub(super) files: &'a [Source],
    pub(super) mosaic: &'a Mosaic,
    pub(super) lakes: &'a [Lake],
    /// Samples of the lattice around a file in which heights of others depend on it.
    pub(super) reach: i64,
    pub(super) georeference: &'a GeoReference,
}

/// The files whose samples are much farther apart than those of the lattice.
pub(super) fn coarse_files(all: &FilesOnLattice) -> Vec<Arc<OwnGrid>> {
    let of_lattice = all.files[all.mosaic.lattice].layout();
    let own_grid = |(file, place): (usize, &mosaic::Place)| {
        let (layout, between) = (all.files[file].layout(), place.between.as_ref()?);
        let is_coarse = place.coarseness >= COARSE
            && !between::is_around(layout)
            && place.extent.iter().all(|range| !range.is_empty());
        let record = is_coarse.then(|| OwnGridRecord {
            file,
            crs: layout.crs.clone(),
            to_crs: layout.to_crs.to_cols_array(),
            size: [layout.columns, layout.rows],
            is_in_degrees: layout.is_in_degrees,
            coarseness: place.coarseness,
            extent: place.extent.clone(),
            composed: composed_around(all, file),
        })?;
        let lattice = (&of_lattice.crs, all.mosaic.to_crs);
        let own = between.own.clone();
        Some(Arc::new(OwnGrid::new(record, lattice, own, all.georeference)))
    };
    all.mosaic.places.iter().enumerate().filter_map(own_grid).collect()
}

/// Columns and rows of the mosaic in which heights are not those of a file alone: where others reach, and in lakes.
fn composed_around(all: &FilesOnLattice, file: usize) -> Vec<[Range<i64>; 2]> {
    let others = all.mosaic.places.iter().enumerate().filter(|(other, _)| *other != file);
    let of_others = others.map(|(_, place)| {
        place
            .extent
            .each_ref()
            .map(|range| range.start as i64 - all.reach..range.end as i64 + all.reach)
    });
    let origin = all.mosaic.origin;
    let of_lakes = all.lakes.iter().map(|lake| {
        let extent = lake.extent();
        [0, 1].map(|axis| {
            let of_mosaic = |place: i64| place.saturating_sub(origin[axis]);
            of_mosaic(extent[axis].start)..of_mosaic(extent[axis].end)
        })
    });
    of_others.chain(of_lakes).collect()
}
