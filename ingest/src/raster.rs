//! Elevation rasters: opened together as one lattice of samples, and read by rectangles, in metres, voids as NaN.

mod archive_file;
mod between;
mod breaklines;
mod coarse_files;
mod composition;
mod crs;
mod drivers;
mod error;
mod exr_file;
mod gdal_file;
pub(crate) mod geopackage;
mod layout;
mod mosaic;
mod options;
mod own_grid;
mod pieces;
mod placement;
mod raw_file;
mod reader;
mod record;
mod remark;
mod source;
mod tiff_file;
mod undeclared;
mod units;
mod vectors;
mod vertical;
mod water;
mod zip;

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::UNIX_EPOCH;

use glam::DVec2;
use rayon::prelude::*;
use terrain_tiles::metadata::Reading;
use terrain_tiles::water::Water;

pub use drivers::is_raster;
pub use error::ReadError;
pub use options::{RasterLimits, ReadOptions};
pub use own_grid::OwnGrid;
pub(crate) use own_grid::{NODES, Places, between};
pub use record::{RasterRecord, RecordedRaster};
pub use units::metres_in;
pub use vectors::{Rings, polygons_on_earth};
pub use vertical::undulations;
pub(crate) use vertical::{SeaLevel, UNSPECIFIED, is_ellipsoid};

use crate::georeference::{GeoReference, missing_grids};
use crate::height_grid::HeightGrid;
use crate::progress::Progress;
use crate::samples::{Extremes, Faults, Overrides, Provenance, Raster, Rectangle};
use between::Between;
use composition::{Area, Composition, common};
use layout::Layout;
use mosaic::Mosaic;
use pieces::{cut, part_size};
use remark::{HIGHEST, remark, tell, tell_of_missing};
use source::Source;
use vertical::HeightReference;
use water::Lake;

/// Cells of a file across which it is bent to meet one that counts before it, if nothing else is asked for.
const BLEND: f64 = 5.0;
/// And no more than so many cells of the lattice: all that is within it is read again for every rectangle.
const MOST_BLEND: f64 = 100.0;
/// Cells that a void that is filled may be wide, if nothing else is asked for.
const FILL: f64 = 40.0;
/// How many times longer than wide cells may be where distances are told.
const MOST_OBLONG: f64 = 4.0;
/// Vertices of polygons of water that an archive may keep.
const MOST_WATER: usize = 1 << 17;

/// Rasters on one lattice of samples, opened but not read.
pub struct Rasters {
    files: Vec<Source>,
    mosaic: Mosaic,
    rules: composition::Rules,
    lakes: Vec<Lake>,
    breaklines: Vec<Vec<[f64; 2]>>,
    georeference: GeoReference,
    own_grids: Vec<Arc<OwnGrid>>,
    limits: RasterLimits,
    progress: Progress,
    overrides: Overrides,
}

/// A rectangle of one file's samples.
struct Part {
    file: usize,
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Rasters {
    /// Opens band 1 of `paths`. The lattice is that of the first file if all share it, else that of the file with the finest cells,
    /// and the others are read between their samples. Where files overlap, the finest that is not void counts, of equally fine ones
    /// the first; the others are bent to meet it. Underlays count last.
    ///
    /// # Errors
    /// A [`ReadError`] of one line that names the file.
    pub fn open(paths: &[PathBuf], options: &ReadOptions) -> Result<Self, ReadError> {
        let reading = &options.overrides.reading;
        let underlays = reading.underlay.iter().map(PathBuf::from);
        let files = paths
            .iter()
            .cloned()
            .chain(underlays)
            .map(|path| Source::open(&path, options))
            .collect::<Result<Vec<_>, _>>()?;
        let layouts: Vec<&Layout> = files.iter().map(Source::layout).collect();
        let rules = mosaic::Rules {
            underlays: reading.underlay.len(),
            around: reading.around,
            by_order: reading.by_order,
            limits: options.limits,
        };
        let mosaic = Mosaic::new(&layouts, rules)?;
        let georeference = georeference(files[mosaic.lattice].layout(), &mosaic, options)?;
        tell(&layouts, &options.progress);
        tell_of_lattice(&layouts, &mosaic, &options.progress);
        let breaklines = match &reading.breaklines {
            Some(path) => breaklines::breaklines(Path::new(path), files[mosaic.lattice].layout())?,
            None => Vec::new(),
        };
        let mut rasters = Self {
            breaklines,
            rules: composition_rules(&mosaic, &georeference, reading),
            lakes: Vec::new(),
            files,
            mosaic,
            georeference,
            own_grids: Vec::new(),
            limits: options.limits,
            progress: options.progress.clone(),
            overrides: options.overrides.clone(),
        };
        for (path, is_water) in [(&reading.water, true), (&reading.flatten, false)] {
            if let Some(path) = path {
                let lakes = rasters.levelled(Path::new(path), is_water)?;
                rasters.lakes.extend(lakes);
            }
        }
        let all = coarse_files::FilesOnLattice {
            files: &rasters.files,
            mosaic: &rasters.mosaic,
            lakes: &rasters.lakes,
            reach: rasters.rules.reach() as i64,
            georeference: &rasters.georeference,
        };
        rasters.own_grids = coarse_files::coarse_files(&all);
        Ok(rasters)
    }

    /// The polygons of a file, each at the level of the samples inside.
    fn levelled(&self, path: &Path, is_water: bool) -> Result<Vec<Lake>, ReadError> {
        let mut lakes = water::lakes(
            path,
            is_water,
            &self.files[self.mosaic.lattice].layout().crs,
            self.mosaic.to_crs,
        )?;
        let whole = self.on_lattice(&self.size().map(|size| 0..size as i64));
        for lake in &mut lakes {
            lake.level = water::level(lake, [&whole[0], &whole[1]], |on_lattice| {
                let [columns, rows] = [0, 1].map(|axis| {
                    let first = self.mosaic.origin[axis];
                    (on_lattice[axis].start - first) as usize..(on_lattice[axis].end - first) as usize
                });
                Ok(self.read(columns, rows)?.heights)
            })?;
        }
        let there = lakes.iter().filter(|lake| lake.level.is_some()).count();
        self.progress.note(&format!(
            "{}: {there} of {} polygons are on samples, and level",
            path.display(),
            lakes.len()
        ));
        lakes.retain(|lake| lake.level.is_some());
        let vertices = lakes
            .iter()
            .flat_map(|lake| &lake.on_earth)
            .map(Vec::len)
            .sum::<usize>();
        if vertices > MOST_WATER {
            self.progress.note(&format!(
                "{}: no water masks are made, since there would be {vertices} vertices of polygons in the archive, and {MOST_WATER} are the \
                 limit; fewer vertices are as good",
                path.display()
            ));
            lakes.iter_mut().for_each(|lake| lake.on_earth.clear());
        }
        Ok(lakes)
    }

    /// Where the lakes are on the Earth.
    fn water(&self) -> Water {
        let rings = self.lakes.iter().map(|lake| &lake.on_earth);
        Water {
            polygons: rings.filter(|rings| !rings.is_empty()).cloned().collect(),
        }
    }

    /// Columns and rows, counted from the mosaic's first sample, on the lattice.
    fn on_lattice(&self, ranges: &[Range<i64>; 2]) -> [Range<i64>; 2] {
        [0, 1].map(|axis| {
            let first = self.mosaic.origin[axis];
            first + ranges[axis].start..first + ranges[axis].end
        })
    }

    /// What files say of their heights, each different one once.
    fn of_heights(&self, of: impl Fn(&HeightReference) -> String) -> String {
        let names: BTreeSet<String> = self.files.iter().map(|file| of(&file.layout().heights)).collect();
        let names: Vec<String> = names.into_iter().filter(|name| !name.is_empty()).collect();
        names.join(", ")
    }

    /// Paths as they were given, those of underlays last.
    fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|file| file.layout().path.as_path())
    }

    /// Paths of all but underlays, which are among what was asked for.
    fn own_paths(&self) -> impl Iterator<Item = &Path> {
        let underlays = self.overrides.reading.underlay.len();
        self.paths().take(self.files.len() - underlays)
    }

    /// All that is known of the rasters but their samples.
    #[must_use]
    pub fn record(&self) -> RasterRecord {
        let first = self.files[self.mosaic.lattice].layout();
        RasterRecord {
            paths: self.own_paths().map(absolute).collect(),
            crs: first.crs.clone(),
            to_crs: self.mosaic.to_crs.to_cols_array(),
            origin: self.mosaic.origin,
            size: self.size(),
            extents: self.extents(),
            coarseness: self.coarseness(),
            own_grids: self.own_grids.iter().map(|grid| grid.record().clone()).collect(),
            block_rows: self.block_rows(),
            provenance: self.provenance(),
            stamps: self.stamps(),
        }
    }

    /// All samples as one grid in memory.
    ///
    /// # Errors
    /// A [`ReadError`] of one line that names the file.
    pub fn grid(self) -> Result<HeightGrid, ReadError> {
        let [columns, rows] = self.size();
        let path = &self.files[0].layout().path;
        placement::check_size(path, columns, rows, self.limits.samples_in_memory)?;
        self.progress.stage("reading samples", (columns * rows) as u64);
        let Rectangle { heights, faults, .. } = self.read(0..columns, 0..rows)?;
        self.progress.done();
        self.remark(Extremes::of(&heights), &faults)?;
        Ok(HeightGrid {
            columns,
            rows,
            heights,
            georeference: self.georeference,
        })
    }

    /// What a rectangle has of a file, by several readers at once, in whole blocks where it lies along them; and how many of its
    /// samples that are `asked` for cannot be heights.
    fn read_file(
        &self,
        file: usize,
        rectangle: [&Range<i64>; 2],
        asked: &[Range<i64>; 2],
    ) -> Result<(Area, u64), ReadError> {
        let [columns, rows] = self.rectangle_of(file, rectangle);
        let whole = [&columns, &rows].map(|range| range.start as i64..range.end as i64);
        let (mut area, mut wild) = (Area::void(whole), 0);
        let parts = self.parts(file, [&columns, &rows]);
        // Memory is that of the rectangle and of what is read at once.
        for parts in parts.chunks(rayon::current_num_threads()) {
            let read: Result<Vec<Vec<f64>>, ReadError> = parts.par_iter().map(|part| self.read_part(part)).collect();
            for (part, metres) in parts.iter().zip(read?) {
                let columns = part.columns.start as i64..part.columns.end as i64;
                let rows = part.rows.start as i64..part.rows.end as i64;
                for (row, metres) in rows.zip(metres.chunks_exact(part.columns.len())) {
                    let run = area.run(row, &columns);
                    for ((height, column), &metres) in area.heights[run].iter_mut().zip(columns.clone()).zip(metres) {
                        let (value, is_wild) = checked_height(metres);
                        *height = value;
                        wild += u64::from(is_wild && asked[0].contains(&column) && asked[1].contains(&row));
                    }
                }
            }
        }
        Ok((area, wild))
    }

    /// Columns and rows that a rectangle has of a file.
    fn rectangle_of(&self, file: usize, [columns, rows]: [&Range<i64>; 2]) -> [Range<usize>; 2] {
        let [across, down] = &self.mosaic.places[file].extent;
        [intersection(columns, across), intersection(rows, down)]
    }

    /// A rectangle of a file, cut into parts along its blocks.
    fn parts(&self, file: usize, [columns, rows]: [&Range<usize>; 2]) -> Vec<Part> {
        let place = &self.mosaic.places[file];
        let [across, down] = &place.extent;
        let block = match place.between {
            None => self.files[file].block(),
            Some(_) => [columns.len(), 1],
        };
        let [width, height] = part_size(block, columns.len());
        let with_columns = |rows: Range<usize>| {
            cut(columns, across.start, width).map(move |columns| Part {
                file,
                columns,
                rows: rows.clone(),
            })
        };
        cut(rows, down.start, height).flat_map(with_columns).collect()
    }

    /// Metres of a part, above what heights are above: the file's own samples, or between them.
    fn read_part(&self, part: &Part) -> Result<Vec<f64>, ReadError> {
        let (file, place) = (&self.files[part.file], &self.mosaic.places[part.file]);
        let metres = match &place.between {
            None => {
                let [left, top] = [0, 1].map(|axis| place.extent[axis].start);
                let in_file = |range: &Range<usize>, first: usize| range.start - first..range.end - first;
                let mut metres = file.read(in_file(&part.columns, left), in_file(&part.rows, top))?;
                let (rectangle, origin) = ([&part.columns, &part.rows], self.mosaic.origin);
                let Layout { path, heights, .. } = file.layout();
                heights.to_ellipsoid(path, &self.georeference, origin, rectangle, &mut metres)?;
                metres
            }
            Some(between) => self.read_between(part, between)?,
        };
        self.progress.advance(metres.len() as u64);
        Ok(metres)
    }

    /// Metres of a part between a file's own samples.
    fn read_between(&self, part: &Part, between: &Between) -> Result<Vec<f64>, ReadError> {
        let layout = self.files[part.file].layout();
        let size = [layout.columns, layout.rows];
        let places = between.places(&self.georeference, [&part.columns, &part.rows]);
        let Some([columns, rows]) = between::needed(&places, size) else {
            return Ok(vec![f64::NAN; places.len()]);
        };
        let own = self.read_samples(part.file, &between.own, [&columns, &rows])?;
        Ok(between::bilinear(&places, size, [&columns, &rows], &own))
    }

    /// Metres of a file's own samples, which are at `own`, in the precision in which samples are kept.
    fn read_samples(
        &self,
        file: usize,
        own: &GeoReference,
        [columns, rows]: [&Range<usize>; 2],
    ) -> Result<Vec<f64>, ReadError> {
        let file = &self.files[file];
        let mut metres = file.read(columns.clone(), rows.clone())?;
        let Layout { path, heights, .. } = file.layout();
        heights.to_ellipsoid(path, own, [0, 0], [columns, rows], &mut metres)?;
        metres.iter_mut().for_each(|metres| *metres = f64::from(*metres as f32));
        Ok(metres)
    }

    /// Numbers of the files that reach into a rectangle, those first that count first.
    fn files_in(&self, rectangle: [&Range<i64>; 2]) -> Vec<usize> {
        let reaches = |&file: &usize| self.rectangle_of(file, rectangle).iter().all(|range| !range.is_empty());
        self.mosaic.ranks.iter().copied().filter(reaches).collect()
    }
}

impl Raster for Rasters {
    fn size(&self) -> [usize; 2] {
        [self.mosaic.columns, self.mosaic.rows]
    }

    fn origin(&self) -> [i64; 2] {
        self.mosaic.origin
    }

    fn extents(&self) -> Vec<[Range<usize>; 2]> {
        self.mosaic.places.iter().map(|place| place.extent.clone()).collect()
    }

    fn coarseness(&self) -> Vec<f64> {
        self.mosaic.places.iter().map(|place| place.coarseness).collect()
    }

    fn block_rows(&self) -> usize {
        self.files.iter().map(|file| file.block()[1]).max().unwrap_or(1)
    }

    fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Rectangle, ReadError> {
        let asked = [&columns, &rows].map(|range| range.start as i64..range.end as i64);
        let reach = self.rules.reach() as i64;
        let wider = [0, 1].map(|axis| asked[axis].start - reach..asked[axis].end + reach);
        let files = self.files_in([&wider[0], &wider[1]]);
        let has_joints = files.len() > 1 || self.rules.fill.is_some();
        let read = if has_joints { &wider } else { &asked };
        let mut composition = Composition::new(&self.rules, read.clone());
        let mut faults = vec![Faults::default(); self.files.len()];
        for file in files {
            let (area, wild) = self.read_file(file, [&read[0], &read[1]], &asked)?;
            let apart = composition.differences(&area, [&asked[0], &asked[1]]);
            faults[file] = Faults { wild, ..apart };
            composition.lay(file, &area);
        }
        let filled = composition.fill([&asked[0], &asked[1]]);
        faults[self.mosaic.ranks[0]].filled = filled.len() as u64;
        let mut heights = composition.window(&asked[0], &asked[1]);
        let on_lattice = self.on_lattice(&asked);
        for lake in &self.lakes {
            lake.level_in([&on_lattice[0], &on_lattice[1]], &mut heights);
        }
        Ok(Rectangle {
            heights,
            filled,
            faults,
        })
    }

    fn own_grids(&self) -> &[Arc<OwnGrid>] {
        &self.own_grids
    }

    fn read_own(&self, own: &OwnGrid, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f32>, ReadError> {
        let metres = self.read_samples(own.file(), own.own(), [&columns, &rows])?;
        Ok(metres.into_iter().map(|metres| checked_height(metres).0).collect())
    }

    fn georeference(&self) -> &GeoReference {
        &self.georeference
    }

    fn provenance(&self) -> Provenance {
        Provenance {
            files: self.own_paths().map(file_name).collect(),
            vertical_datum: self.of_heights(HeightReference::datum),
            heights_above: self.of_heights(HeightReference::heights_above),
            geoid: Some(self.of_heights(|heights| heights.geoid().unwrap_or_default().to_owned()))
                .filter(|names| !names.is_empty()),
            water: self.water(),
            breaklines: self.breaklines.clone(),
            overrides: self.overrides.clone(),
        }
    }

    fn remark(&self, extremes: Option<Extremes>, faults: &[Faults]) -> Result<(), ReadError> {
        let paths: Vec<&Path> = self.paths().collect();
        remark(&paths, extremes, faults, &self.progress)
    }

    /// Path, size and time of the last change of each file, and of those so near that its heights depend on them, and how they are
    /// read.
    fn stamps(&self) -> Vec<String> {
        let own: Vec<String> = self.paths().map(stamp_of).collect();
        let reach = self.rules.reach() as i64;
        // A lake's level depends on all samples in it.
        let Reading { water, flatten, .. } = &self.overrides.reading;
        let polygons: Vec<String> = [water, flatten]
            .into_iter()
            .flatten()
            .map(|path| stamp_of(Path::new(path)))
            .collect();
        let water = if polygons.is_empty() {
            String::new()
        } else {
            format!("{} {}", polygons.join(" "), own.join(" "))
        };
        let stamp = |place: &mosaic::Place| {
            let wider = [0, 1].map(|axis| {
                let range = &place.extent[axis];
                range.start as i64 - 2 * reach..range.end as i64 + 2 * reach
            });
            let near = self.files_in([&wider[0], &wider[1]]);
            let stamps: Vec<&str> = near.into_iter().map(|file| own[file].as_str()).collect();
            format!("{} {water} {:?}", stamps.join(" "), self.overrides)
        };
        let of_places = self.mosaic.places.iter().map(stamp);
        own.iter()
            .zip(of_places)
            .map(|(own, near)| format!("{own} {near}"))
            .collect()
    }
}

fn stamp_of(path: &Path) -> String {
    let absolute = absolute(path);
    let changed = std::fs::metadata(path).map(|metadata| {
        let since = metadata
            .modified()
            .ok()
            .and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        (metadata.len(), since.map(|since| since.as_nanos()))
    });
    format!("{} {:?}", absolute.display(), changed.ok())
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Reads band 1 of `paths` as one grid in memory.
///
/// # Errors
/// A [`ReadError`] of one line that names the file.
pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<HeightGrid, ReadError> {
    Rasters::open(paths, options)?.grid()
}

/// What a range, counted from the mosaic's first sample, has of an extent.
fn intersection(range: &Range<i64>, extent: &Range<usize>) -> Range<usize> {
    let range = common(&(extent.start as i64..extent.end as i64), range);
    range.start as usize..range.end as usize
}

/// What heights are put together by, in metres.
fn composition_rules(mosaic: &Mosaic, georeference: &GeoReference, reading: &Reading) -> composition::Rules {
    let middle = DVec2::new((mosaic.columns - 1) as f64, (mosaic.rows - 1) as f64) / 2.0;
    let cell = georeference.cell_metres(middle);
    // Next to a pole, cells are slivers: distances are then those of wider ones.
    let cell = cell.max(DVec2::splat(cell.max_element() / MOST_OBLONG));
    let side = (cell.x * cell.y).sqrt();
    let blend = |place: &mosaic::Place| {
        reading
            .blend
            .unwrap_or(side * (BLEND * place.coarseness).min(MOST_BLEND))
    };
    composition::Rules {
        origin: mosaic.origin,
        cell: cell.to_array(),
        blends: mosaic.places.iter().map(blend).collect(),
        fill: reading.fill.map(|fill| fill.widest.unwrap_or(FILL * side)),
    }
}

/// Tells where the lattice is when it is not that of all files.
fn tell_of_lattice(files: &[&Layout], mosaic: &Mosaic, progress: &Progress) {
    let between = mosaic.places.iter().filter(|place| place.between.is_some());
    let count = between.count();
    if count > 0 {
        let lattice = file_name(&files[mosaic.lattice].path);
        progress.note(&format!(
            "tiles are made on the samples of {lattice}; of {count} of {} files heights are taken between their samples",
            files.len()
        ));
    }
}

fn georeference(first: &Layout, mosaic: &Mosaic, options: &ReadOptions) -> Result<GeoReference, ReadError> {
    let georeference = GeoReference::on_lattice(&first.crs, mosaic.to_crs, mosaic.origin, mosaic.columns, mosaic.rows)
        .map_err(|source| ReadError::Position(first.path.clone(), source))?;
    let missing = missing_grids(&first.crs.definition, georeference.geographic_bounds());
    if let Some(missing) = missing {
        tell_of_missing(&first.crs, missing, &options.progress)
            .map_err(|source| ReadError::Position(first.path.clone(), source))?;
    } else if georeference.is_ballpark() {
        let crs = georeference.crs_name();
        options.progress.note(&format!(
            "no datum shift from {crs} to WGS84 is known here; none is applied"
        ));
    }
    Ok(georeference)
}

/// A file's name without its folder.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// A height in metres as it is kept, and whether it had to be voided.
fn checked_height(metres: f64) -> (f32, bool) {
    if metres.is_nan() {
        (f32::NAN, false)
    } else if metres.abs() >= HIGHEST {
        (f32::NAN, true)
    } else {
        (metres as f32, false)
    }
}

#[cfg(test)]
#[path = "raster_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "raster/several_tests.rs"]
mod several_tests;
