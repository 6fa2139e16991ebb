#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec2;
use tempfile::TempDir;

use super::*;
use crate::chunk_view::ChunkView;
use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;
use crate::intake::Intake;
use crate::raster::{OwnGrid, ReadError};
use crate::samples::{Extremes, Faults, Provenance, Rectangle};
use terrain_core::height_field::chunks::Chunks;

/// A raster whose first sample is not the first one of its lattice, and that counts how often it is read.
struct Shifted {
    grid: HeightGrid,
    origin: [i64; 2],
    reads: AtomicUsize,
}

impl Shifted {
    /// Hills with a hole, more than a chunk wide.
    fn new(columns: usize, rows: usize, origin: [i64; 2]) -> Self {
        let height = |index: usize| {
            let (column, row) = (index % columns, index / columns);
            let is_void = (40..70).contains(&column) && (20..50).contains(&row);
            let hills =
                (column as f32 / 9.0).sin() * 40.0 + (row as f32 / 5.0).cos() * 25.0 + (column * row % 7) as f32;
            if is_void { f32::NAN } else { hills }
        };
        let grid = HeightGrid {
            columns,
            rows,
            heights: (0..columns * rows).map(height).collect(),
            georeference: GeoReference::wgs84(columns, rows, DVec2::new(10.0, 50.0), DVec2::new(0.001, -0.001)),
        };
        Self {
            grid,
            origin,
            reads: AtomicUsize::new(0),
        }
    }
}

impl Raster for Shifted {
    fn size(&self) -> [usize; 2] {
        Raster::size(&self.grid)
    }

    fn origin(&self) -> [i64; 2] {
        self.origin
    }

    fn extents(&self) -> Vec<[Range<usize>; 2]> {
        self.grid.extents()
    }

    fn coarseness(&self) -> Vec<f64> {
        self.grid.coarseness()
    }

    fn block_rows(&self) -> usize {
        self.grid.block_rows()
    }

    fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Rectangle, ReadError> {
        self.reads.fetch_add(1, Ordering::Relaxed);
        self.grid.read(columns, rows)
    }

    fn read_own(&self, own: &OwnGrid, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f32>, ReadError> {
        self.grid.read_own(own, columns, rows)
    }

    fn georeference(&self) -> &GeoReference {
        self.grid.georeference()
    }

    fn provenance(&self) -> Provenance {
        self.grid.provenance()
    }

    fn remark(&self, extremes: Option<Extremes>, faults: &[Faults]) -> Result<(), ReadError> {
        self.grid.remark(extremes, faults)
    }

    fn stamps(&self) -> Vec<String> {
        self.grid.stamps()
    }
}

fn taken(raster: &Shifted, store: &Store) -> ChunkedRaster {
    let intake = Intake::new(raster, store);
    let taken = intake.take(&intake.bands(), &Progress::silent()).unwrap();
    ChunkedRaster::new(raster, store, taken, 1 << 24).unwrap()
}

/// All of it, counted as the raster counts.
fn whole(chunked: &ChunkedRaster) -> ChunkView<'_> {
    let [columns, rows] = Samples::size(chunked);
    ChunkView::new(chunked, &[0..columns, 0..rows], chunked.top())
}

fn store() -> (TempDir, Store) {
    let folder = TempDir::new().unwrap();
    let store = Store::open(&folder.path().display().to_string()).unwrap();
    (folder, store)
}

fn same(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
}

#[test]
fn windows_across_chunks_are_those_of_the_raster_wherever_it_lies_on_the_lattice() {
    let (_folder, store) = store();
    for origin in [[0, 0], [-300, 70], [1000, -1]] {
        let raster = Shifted::new(600, 300, origin);
        let chunked = taken(&raster, &store);
        let [left, top] = chunked.before();
        for [columns, rows] in [
            [0..600, 0..300],
            [250..260, 17..299],
            [599..600, 0..1],
            [30..80, 10..60],
        ] {
            let moved = chunked
                .window(
                    columns.start + left..columns.end + left,
                    rows.start + top..rows.end + top,
                )
                .unwrap();
            let own = raster.grid.window(columns, rows).unwrap();
            assert_eq!(moved.first, [own.first[0] + left, own.first[1] + top]);
            assert!(same(&moved.heights, &own.heights), "{origin:?}");
        }
    }
}

#[test]
fn what_was_read_is_not_read_again_and_another_place_on_the_lattice_is_another_name() {
    let (_folder, store) = store();
    let raster = Shifted::new(600, 300, [0, 0]);
    let names = taken(&raster, &store).names;
    let reads = raster.reads.load(Ordering::Relaxed);
    assert_eq!(reads, 2, "two bands of 256 rows");
    assert_eq!(taken(&raster, &store).names, names);
    assert_eq!(raster.reads.load(Ordering::Relaxed), reads);
    let shifted = Shifted::new(600, 300, [1, 0]);
    assert_ne!(taken(&shifted, &store).names, names);
}

#[test]
fn chunks_of_every_level_hold_the_samples_at_their_corners_and_the_steepest_step() {
    let (_folder, store) = store();
    let raster = Shifted::new(600, 300, [-300, 70]);
    let chunked = taken(&raster, &store);
    chunked.make_relief(&Progress::silent()).unwrap();
    let [left, top] = chunked.before();
    let whole = whole(&chunked);
    let mut seams = 0;
    for level in 0..=chunked.top() {
        let step = 1 << level;
        for (column, row) in [(0, 0), (212, 186), (44, 96), (588, 250), (56, 40), (300, 186)] {
            let [x, y] = [left + column, top + row];
            if x % step > 0 || y % step > 0 {
                continue;
            }
            let [x, y] = [x / step, y / step];
            let chunk = whole.chunk(level, x / CHUNK, y / CHUNK).unwrap();
            let sample = chunk.sample(x % CHUNK, y % CHUNK);
            assert!(
                same(&[sample], &[raster.grid.height(column, row)]),
                "level {level}: {column}, {row}"
            );
            if x % CHUNK == 0 && column > 0 {
                // The chunk before has the corner, too.
                let chunk = whole.chunk(level, x / CHUNK - 1, y / CHUNK).unwrap();
                seams += 1;
                assert!(
                    same(&[chunk.sample(CHUNK, y % CHUNK)], &[sample]),
                    "level {level}: {column}"
                );
            }
        }
    }
    assert!(seams > 1, "{seams} corners between chunks");
    let heights = &raster.grid.heights;
    let across = heights
        .chunks(600)
        .flat_map(|row| row.windows(2))
        .map(|pair| (pair[1] - pair[0]).abs());
    let down = heights
        .iter()
        .zip(&heights[600..])
        .map(|(above, below)| (below - above).abs());
    assert_eq!(chunked.steepest().unwrap(), across.chain(down).fold(0.0, f32::max));
}

#[test]
fn a_view_counts_from_the_same_place_whatever_else_the_raster_holds() {
    let (_folder, store) = store();
    let (alone, beside) = (Shifted::new(600, 300, [0, 0]), Shifted::new(1500, 900, [-700, -500]));
    let [alone, beside] = [&alone, &beside].map(|raster| taken(raster, &store));
    // The same rectangle of the lattice in both.
    let in_raster = |raster: &ChunkedRaster, first: [usize; 2]| {
        [0, 1].map(|axis| raster.before()[axis] + first[axis]..raster.before()[axis] + first[axis] + 100)
    };
    let of_alone = in_raster(&alone, [300, 150]);
    let of_beside = in_raster(&beside, [1000, 650]);
    assert_eq!(alone.on_lattice(&of_alone), beside.on_lattice(&of_beside));
    for level in [0, 3, 9] {
        let views = [
            ChunkView::new(&alone, &of_alone, level),
            ChunkView::new(&beside, &of_beside, level),
        ];
        assert_eq!(views[0].origin(), views[1].origin(), "level {level}");
        assert_eq!(views[0].size(), views[1].size());
        assert_eq!(views[0].cells(&of_alone), views[1].cells(&of_beside));
    }
}

#[test]
fn a_chunk_that_is_gone_or_damaged_is_told() {
    let (folder, store) = store();
    let raster = Shifted::new(600, 300, [0, 0]);
    let chunked = taken(&raster, &store);
    chunked.make_relief(&Progress::silent()).unwrap();
    for damage in ["gone", "short"] {
        let again = taken(&raster, &store);
        for entry in std::fs::read_dir(folder.path().join("samples")).unwrap() {
            let path = entry.unwrap().path();
            match damage {
                "short" => std::fs::write(path, [0; 8]).unwrap(),
                _ => std::fs::write(path.with_extension("kept"), std::fs::read(&path).unwrap())
                    .and_then(|()| std::fs::remove_file(&path))
                    .unwrap(),
            }
        }
        assert!(again.window(0..9, 0..9).is_err(), "{damage}");
        assert!(again.check().is_ok());
        assert!(whole(&again).chunk(0, 0, 0).is_none());
        let told = again.check().unwrap_err().to_string();
        assert!(
            told.contains(if damage == "gone" { "is missing" } else { "is damaged" }),
            "{told}"
        );
        for entry in std::fs::read_dir(folder.path().join("samples")).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "kept") {
                std::fs::rename(&path, path.with_extension("")).unwrap();
            }
        }
    }
}
