//! What is drawn for any camera, whatever is loaded, is one surface without a gap: real archives, random views.
//!
//! ```text
//! of each tile and level of detail that is drawn: triangles that are counter-clockwise in plan, by whole numbers; the edges
//!     that no other triangle of the tile has in reverse
//! of each view: those edges cancel out against the neighbours', vertices being one if all bits of their places in space are
//! of what is left, nothing along a side of a tile has a surface on both sides
//! where the data have no voids, it is one closed curve that does not touch itself
//! ```
//!
//! Triangles that all turn one way, with a simple closed curve around them, cover what is inside it once: no gap, no overlap.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::PathBuf;

use fastrand::Rng;
use glam::{DVec2, DVec3};
use tempfile::TempDir;
use terrain_codec::LevelLimits;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid;
use terrain_codec::spt;
use terrain_codec::tile::{Detail, Tile};
use terrain_core::Mesh;
use terrain_core::selection::camera::Camera;
use terrain_core::selection::hierarchy::Hierarchy;
use terrain_core::selection::select::{Choice, Demand, Selection, select};
use terrain_ingest::raster::Rasters;
use terrain_ingest::store::Store;
use terrain_ingest::{HeightGrid, Progress, ReadOptions, pyramid, raster};
use terrain_tests::selection::random;
use terrain_tests::{sample, shared_data};
use terrain_tiles::archive::Reader;
use terrain_tiles::pyramid::{Pyramid, Summary};

/// Metres that a camera is above the ground at most.
const HIGHEST: f64 = 300_000.0;

/// A vertex by the bits of its Earth-centred coordinates.
type Place = [u64; 3];
type Edge = [Place; 2];

/// An edge along a side of a tile, on the lattice of the whole Earth.
#[derive(Clone, Copy)]
struct Run {
    is_vertical: bool,
    /// Of the line that it is on.
    at: u64,
    /// Along the line, in the direction of the edge.
    ends: [u64; 2],
}

/// A tile at one level of detail.
struct Drawn {
    /// Edges of one triangle only.
    open: Vec<(Edge, Option<Run>)>,
    /// Largest vertical distance from the samples that were looked at, metres.
    error: f64,
}

/// An archive, and what has been drawn of it so far.
struct Scene {
    tiles: BTreeMap<TileAddress, Tile>,
    pyramid: Pyramid,
    grid: HeightGrid,
    has_voids: bool,
    drawn: HashMap<(TileAddress, usize, [bool; 4]), Drawn>,
}

impl Scene {
    fn new(files: &[PathBuf], max_error: f64) -> Self {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("archive.pmtiles");
        let options = pyramid::Options {
            max_error: Some(max_error),
            ..pyramid::Options::default()
        };
        let build = pyramid::Build {
            raster: &Rasters::open(files, &ReadOptions::default()).unwrap(),
            options: &options,
            store: &Store::open(&folder.path().join("store").display().to_string()).unwrap(),
            earlier: None,
            progress: &Progress::silent(),
        };
        build.run(&path).unwrap();
        let reader = Reader::open(&path).unwrap();
        let read = |address: TileAddress| {
            let bytes = reader.tile(address).unwrap().unwrap();
            (address, spt::decode(&bytes, &LevelLimits::default()).unwrap())
        };
        let tiles: BTreeMap<TileAddress, Tile> = reader.addresses().map(read).collect();
        let summaries = tiles
            .iter()
            .map(|(&address, tile)| (address, Summary::of(tile, 1).unwrap()));
        let grid = raster::read(files, &ReadOptions::default()).unwrap();
        Self {
            pyramid: Pyramid::new(summaries),
            tiles,
            has_voids: grid.heights.iter().any(|height| height.is_nan()),
            grid,
            drawn: HashMap::new(),
        }
    }

    fn drawn(&mut self, choice: &Choice<TileAddress>) -> &Drawn {
        let key = (choice.node, choice.level, choice.fine_sides);
        let (tiles, grid) = (&self.tiles, &self.grid);
        self.drawn
            .entry(key)
            .or_insert_with(|| draw(&tiles[&choice.node], choice, grid))
    }

    /// # Panics
    /// Where what is drawn has a gap or an overlap.
    fn check_surface(&mut self, choices: &[Choice<TileAddress>]) {
        let mut open: HashMap<Edge, Option<Run>> = HashMap::new();
        for choice in choices {
            for &(edge, run) in &self.drawn(choice).open {
                assert!(open.insert(edge, run).is_none(), "an edge is drawn twice: {choice:?}");
            }
        }
        let unmet: Vec<(Edge, Option<Run>)> = open
            .iter()
            .filter(|(edge, _)| !open.contains_key(&[edge[1], edge[0]]))
            .map(|(&edge, &run)| (edge, run))
            .collect();
        check_sides(unmet.iter().filter_map(|&(_, run)| run));
        if !self.has_voids {
            let outlines = closed_curves(unmet.iter().map(|&(edge, _)| edge));
            assert_eq!(outlines, usize::from(!choices.is_empty()), "there is a gap inside");
        }
    }

    /// All leaves, every side coarse.
    fn leaves(&self) -> Vec<Choice<TileAddress>> {
        let leaves = self
            .tiles
            .keys()
            .filter(|&&tile| self.pyramid.children(tile).next().is_none());
        let choice = |&node: &TileAddress| Choice {
            node,
            level: self.tiles[&node].interior_levels() - 1,
            fine_sides: [false; 4],
        };
        leaves.map(choice).collect()
    }

    /// Draws for random cameras, with all loaded or a part.
    fn check(&mut self, views: usize, seed: u64) -> Counts {
        self.check_surface(&self.leaves());
        let deepest = self.tiles.keys().next_back().unwrap().zoom;
        let places: Vec<TileAddress> = self.tiles.keys().copied().collect();
        let near: Vec<TileAddress> = places.iter().copied().filter(|tile| tile.zoom + 3 > deepest).collect();
        let mut random = Rng::with_seed(seed);
        let mut counts = Counts::default();
        let mut before = Vec::new();
        for _ in 0..views {
            let camera = random::camera(&near, HIGHEST, &mut random);
            let loaded = loaded(&places, &mut random);
            let demand = Demand {
                tolerance: *random.choice([&1.0, &2.0, &4.0, &16.0]).unwrap(),
                keep: 0.8,
                triangles: u64::MAX,
                bytes: u64::MAX,
            };
            let is_loaded = |tile| loaded.as_ref().is_none_or(|loaded| loaded.contains(&tile));
            let selection = select(&self.pyramid, &camera, &demand, is_loaded, &before);
            self.check_surface(&selection.choices);
            counts.add(&selection);
            if selection.requests.is_empty() {
                self.check_error(&selection, &camera, &mut counts);
            }
            before = selection.choices;
        }
        counts
    }

    /// What is in sight and has something finer below it is within the tolerance: as it claims, and as is measured.
    fn check_error(&mut self, selection: &Selection<TileAddress>, camera: &Camera, counts: &mut Counts) {
        for choice in &selection.choices {
            let bounds = self.pyramid.bounds(choice.node);
            let is_deepest = self.pyramid.children(choice.node).next().is_none();
            if is_deepest || !camera.sight().sees(&bounds) {
                continue;
            }
            let claimed = self.pyramid.levels(choice.node)[choice.level].error;
            let measured = self.drawn(choice).error;
            let distance = bounds.distance(camera.eye);
            assert!(
                camera.pixels(claimed, distance) <= selection.tolerance,
                "{choice:?} claims {claimed}"
            );
            assert!(
                measured <= claimed + 1e-4,
                "{choice:?} claims {claimed}, measured {measured}"
            );
            counts.measured += usize::from(measured > 0.0);
        }
    }
}

/// What the views had, so that a test can see that they were not all alike.
#[derive(Debug, Default)]
struct Counts {
    tiles: usize,
    fine_sides: usize,
    three_zooms: usize,
    partial: usize,
    measured: usize,
}

impl Counts {
    fn add(&mut self, selection: &Selection<TileAddress>) {
        let choices = &selection.choices;
        self.tiles += choices.len();
        self.fine_sides += choices
            .iter()
            .flat_map(|choice| choice.fine_sides)
            .filter(|&fine| fine)
            .count();
        let zooms: BTreeSet<u8> = choices.iter().map(|choice| choice.node.zoom).collect();
        self.three_zooms += usize::from(zooms.len() > 2);
        self.partial += usize::from(!selection.requests.is_empty());
    }
}

/// All, or by chance more or fewer of those below the roots.
fn loaded(places: &[TileAddress], random: &mut Rng) -> Option<BTreeSet<TileAddress>> {
    if random.bool() {
        return None;
    }
    let share = 0.5 + 0.5 * random.f64();
    let is_loaded = |tile: &&TileAddress| tile.zoom == 0 || random.f64() < share;
    Some(places.iter().filter(is_loaded).copied().collect())
}

fn draw(tile: &Tile, choice: &Choice<TileAddress>, grid: &HeightGrid) -> Drawn {
    let surface = tile.surface(Detail {
        interior: choice.level,
        fine_sides: choice.fine_sides,
    });
    let places: Vec<Place> = surface
        .positions
        .iter()
        .map(|&position| place(tile, position))
        .collect();
    let mut edges = HashSet::new();
    for &corners in &surface.triangles {
        assert!(is_counter_clockwise(&surface, corners), "{choice:?}");
        let [a, b, c] = corners.map(|corner| places[corner as usize]);
        for edge in [[a, b], [b, c], [c, a]] {
            assert!(edges.insert(edge), "{choice:?} has an edge twice");
        }
    }
    let is_open = |&&[from, to]: &&Edge| !edges.contains(&[to, from]);
    let lattice: HashMap<Place, DVec3> = places.iter().copied().zip(surface.positions.iter().copied()).collect();
    let with_run = |&edge: &Edge| (edge, run(tile, edge.map(|end| lattice[&end])));
    Drawn {
        open: edges.iter().filter(is_open).map(with_run).collect(),
        error: measured_error(tile, &surface, grid),
    }
}

/// Of an edge, if it is along a side of its tile.
fn run(tile: &Tile, [a, b]: [DVec3; 2]) -> Option<Run> {
    let extent = 1_u64 << tile.extent_bits;
    let on_side = |from: f64, to: f64| from == to && (from == 0.0 || from == extent as f64);
    let column = |at: f64| u64::from(tile.address.x) * extent + at as u64;
    let row = |at: f64| u64::from(tile.address.y) * extent + at as u64;
    if on_side(a.x, b.x) {
        Some(Run {
            is_vertical: true,
            at: column(a.x),
            ends: [row(a.y), row(b.y)],
        })
    } else {
        on_side(a.y, b.y).then(|| Run {
            is_vertical: false,
            at: row(a.y),
            ends: [column(a.x), column(b.x)],
        })
    }
}

/// Edges along one line that nothing meets must all have their triangles on one side where they are beside each other.
fn check_sides(runs: impl Iterator<Item = Run>) {
    let mut lines: BTreeMap<(bool, u64), [Vec<[u64; 2]>; 2]> = BTreeMap::new();
    for run in runs {
        let [from, to] = run.ends;
        let line = lines.entry((run.is_vertical, run.at)).or_default();
        line[usize::from(from > to)].push([from.min(to), from.max(to)]);
    }
    for ((is_vertical, at), [mut forwards, mut backwards]) in lines {
        forwards.sort_unstable();
        backwards.sort_unstable();
        let (mut first, mut second) = (0, 0);
        while let (Some(a), Some(b)) = (forwards.get(first), backwards.get(second)) {
            let is_gap = a[0].max(b[0]) < a[1].min(b[1]);
            assert!(
                !is_gap,
                "a gap on line {at}, vertical: {is_vertical}, at {a:?} and {b:?}"
            );
            if a[1] < b[1] {
                first += 1;
            } else {
                second += 1;
            }
        }
    }
}

/// How many closed curves directed edges are.
fn closed_curves(edges: impl Iterator<Item = Edge>) -> usize {
    let mut next: HashMap<Place, Place> = HashMap::new();
    for [from, to] in edges {
        assert!(next.insert(from, to).is_none(), "an outline touches another");
    }
    let mut curves = 0;
    while let Some(&first) = next.keys().next() {
        let mut at = first;
        while let Some(to) = next.remove(&at) {
            at = to;
        }
        assert_eq!(at, first, "an outline does not end where it begins");
        curves += 1;
    }
    curves
}

fn place(tile: &Tile, position: DVec3) -> Place {
    tile.earth_centred(position)
        .to_array()
        .map(|coordinate| (coordinate + 0.0).to_bits())
}

/// Positions in plan are whole numbers below 2^31, so that this is exact.
fn is_counter_clockwise(surface: &Mesh, corners: [u32; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| {
        surface.positions[corner as usize]
            .truncate()
            .as_i64vec2()
            .to_array()
            .map(i128::from)
    });
    (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])
}

/// Largest vertical distance of a surface, flat between its vertices in space, from the samples next to its triangles' middles.
fn measured_error(tile: &Tile, surface: &Mesh, grid: &HeightGrid) -> f64 {
    let of_triangle = |corners: &[u32; 3]| {
        let positions = corners.map(|corner| surface.positions[corner as usize]);
        let middle = tile.geodetic((positions[0] + positions[1] + positions[2]) / 3.0);
        let place = grid
            .georeference
            .grid(DVec2::new(middle.longitude, middle.latitude))
            .round();
        let size = DVec2::new(grid.columns as f64, grid.rows as f64);
        if place.min_element() < 0.0 || !place.cmplt(size).all() {
            return None;
        }
        let height = f64::from(grid.height(place.x as usize, place.y as usize));
        let below = height_below(
            positions.map(|position| tile.earth_centred(position)),
            grid.georeference.geographic(place),
        )?;
        Some((below - height).abs()).filter(|error| error.is_finite())
    };
    surface.triangles.iter().filter_map(of_triangle).fold(0.0, f64::max)
}

/// Height of a triangle in space on the vertical line at a longitude and latitude, if that goes through it.
fn height_below([a, b, c]: [DVec3; 3], geographic: DVec2) -> Option<f64> {
    let up = ellipsoid::normal(geographic.x, geographic.y);
    let foot = ellipsoid::on_ellipsoid(geographic);
    let across = (b - a).cross(c - a);
    let height = across.dot(a - foot) / across.dot(up);
    let point = foot + up * height;
    let is_inside = [[a, b], [b, c], [c, a]]
        .iter()
        .all(|&[from, to]| (to - from).cross(point - from).dot(across) >= 0.0);
    is_inside.then_some(height)
}

#[test]
fn random_views_of_the_sample_have_no_gap_and_keep_the_tolerance() {
    let mut scene = Scene::new(&[sample("jacksboro_fault.tif")], 10.0);
    let counts = scene.check(4000, 1);
    println!("{counts:?}");
    assert!(
        counts.tiles > 15_000 && counts.fine_sides > 5000 && counts.three_zooms > 400,
        "{counts:?}"
    );
    assert!(counts.partial > 600 && counts.measured > 2000, "{counts:?}");
}

#[test]
fn a_side_that_is_coarse_where_its_neighbour_is_finer_is_a_gap() {
    let mut scene = Scene::new(&[sample("jacksboro_fault.tif")], 40.0);
    let whole = scene.leaves();
    scene.check_surface(&whole);
    let near: Vec<TileAddress> = whole.iter().map(|choice| choice.node).collect();
    let demand = Demand {
        tolerance: 2.0,
        keep: 1.0,
        triangles: u64::MAX,
        bytes: u64::MAX,
    };
    let has_fine_side = |choice: &Choice<TileAddress>| choice.fine_sides.contains(&true);
    let mut views = (0..).map(|seed| {
        let camera = random::camera(&near, HIGHEST, &mut Rng::with_seed(seed));
        select(&scene.pyramid, &camera, &demand, |_| true, &[]).choices
    });
    let mut choices = views.find(|choices| choices.iter().any(has_fine_side)).unwrap();
    scene.check_surface(&choices);
    let beside_finer = choices.iter_mut().find(|choice| has_fine_side(choice)).unwrap();
    beside_finer.fine_sides = [false; 4];
    let found = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| scene.check_surface(&choices)));
    assert!(found.is_err());
}

/// Of the Fraser valley: mountains, sea, voids; two files that meet in a meridian.
#[test]
#[ignore = "takes minutes: cargo nextest run --workspace --test watertight --run-ignored only"]
fn random_views_of_two_adjacent_files_have_no_gap_and_keep_the_tolerance() {
    let files = ["srtm/N49W124.tif", "srtm/N49W123.tif"].map(shared_data);
    let [Some(west), Some(east)] = files else { return };
    let mut scene = Scene::new(&[west, east], 20.0);
    let counts = scene.check(5000, 2);
    println!("{counts:?}");
    assert!(
        counts.tiles > 100_000 && counts.fine_sides > 20_000 && counts.three_zooms > 1000,
        "{counts:?}"
    );
    assert!(counts.partial > 1000 && counts.measured > 10_000, "{counts:?}");
}
