//! A small archive made by hand: 17 × 17 samples around 0° north, 90° east, where four tiles of zoom 1 meet, and their
//! parent. Each leaf is the grid of its samples; its two inner sides lose one vertex each, and one inner vertex goes,
//! lifting the one it goes to by a step, on the way to its coarsest surface.

use std::collections::{BTreeMap, HashMap};

use glam::{DVec2, DVec3};
use terrain_codec::address::{Side, TileAddress};
use terrain_codec::filled::Filled;
use terrain_codec::tile::{Lineage, Tile};
use terrain_core::{Band, Collapse, CollapseLog, Mesh, SurfacePartition};
use terrain_tiles::metadata::{Asked, FORMAT, Metadata, Source, VERSION, Zoom};

use super::super::tiles::Tiles;
use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;

pub(in crate::verify) const SAMPLES: usize = 17;
pub(in crate::verify) const MIDDLE: usize = 8;
pub(in crate::verify) const CLAIMED: f64 = 1.0;
pub(in crate::verify) const HEIGHT_STEP: f64 = 1.0 / 64.0;
/// North-west of the middle.
pub(in crate::verify) const LEAF: TileAddress = TileAddress { zoom: 1, x: 2, y: 1 };
pub(in crate::verify) const ROOT: TileAddress = TileAddress { zoom: 0, x: 1, y: 0 };
/// Lattice units from sample to sample.
const SPACING: f64 = 128.0;
/// `extent_bits` of the root.
const BITS: u8 = 24;

pub(in crate::verify) struct Sample {
    pub(in crate::verify) grid: HeightGrid,
    pub(in crate::verify) metadata: Metadata,
    pub(in crate::verify) tiles: BTreeMap<TileAddress, Tile>,
}

impl Tiles for Sample {
    fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    fn addresses(&self) -> Vec<TileAddress> {
        self.tiles.keys().copied().collect()
    }

    fn tile(&self, address: TileAddress) -> Result<Tile, String> {
        self.tiles
            .get(&address)
            .cloned()
            .ok_or_else(|| "is not there".to_owned())
    }
}

impl Sample {
    /// Of a sloping plane.
    pub(in crate::verify) fn new() -> Self {
        Self::of(|column, row| (column + 2 * row) as f32)
    }

    pub(in crate::verify) fn of(height: impl Fn(usize, usize) -> f32) -> Self {
        Self::build(height, None)
    }

    /// A plane at height 0 with one void, the cells around it left out of the meshes.
    pub(in crate::verify) fn with_void(column: usize, row: usize) -> Self {
        let height = |x, y| if (x, y) == (column, row) { f32::NAN } else { 0.0 };
        Self::build(height, Some((column, row)))
    }

    fn build(height: impl Fn(usize, usize) -> f32, void: Option<(usize, usize)>) -> Self {
        let step = SPACING * 180.0 / f64::from(1_u32 << BITS);
        let first = DVec2::new(90.0, 0.0) + DVec2::new(-(MIDDLE as f64), MIDDLE as f64) * step;
        let grid = HeightGrid {
            columns: SAMPLES,
            rows: SAMPLES,
            heights: (0..SAMPLES * SAMPLES)
                .map(|index| height(index % SAMPLES, index / SAMPLES))
                .collect(),
            georeference: GeoReference::wgs84(SAMPLES, SAMPLES, first, DVec2::new(step, -step)),
        };
        let leaves: Vec<Tile> = ROOT.children().map(|address| leaf(address, &grid, void)).to_vec();
        let root = root(&leaves);
        let tiles: BTreeMap<_, _> = leaves
            .into_iter()
            .chain([root])
            .map(|tile| (tile.address, tile))
            .collect();
        Self {
            metadata: metadata(&tiles),
            grid,
            tiles,
        }
    }

    pub(in crate::verify) fn tile_mut(&mut self, address: TileAddress) -> &mut Tile {
        self.tiles.get_mut(&address).unwrap()
    }

    /// The vertex of a tile that is at a sample.
    pub(in crate::verify) fn vertex_at(&self, address: TileAddress, column: usize, row: usize) -> usize {
        let place = lattice(address, column, row);
        let positions = &self.tiles[&address].partition.positions;
        positions
            .iter()
            .position(|position| position.truncate() == place)
            .unwrap()
    }
}

/// Where a sample is on a tile's lattice.
fn lattice(address: TileAddress, column: usize, row: usize) -> DVec2 {
    let root_place = f64::from(1_u32 << (BITS - 1))
        + DVec2::new(column as f64 - MIDDLE as f64, MIDDLE as f64 - row as f64) * SPACING;
    let extent = f64::from(1_u32 << (BITS - address.zoom));
    let root_x = f64::from(address.x) - f64::from(ROOT.x << address.zoom);
    root_place - DVec2::new(root_x, f64::from(address.y)) * extent
}

fn leaf(address: TileAddress, grid: &HeightGrid, void: Option<(usize, usize)>) -> Tile {
    let first = (
        if address.x == 2 { 0 } else { MIDDLE },
        if address.y == 1 { 0 } else { MIDDLE },
    );
    let width = MIDDLE + 1;
    let samples = || (0..width * width).map(|i| (first.0 + i % width, first.1 + i / width));
    let height = |(column, row): (usize, usize)| f64::from(grid.height(column, row));
    let height = |sample| if height(sample).is_nan() { 0.0 } else { height(sample) };
    let positions = samples()
        .map(|sample| lattice(address, sample.0, sample.1).extend(height(sample)))
        .collect();
    let at = |column: usize, row: usize| (row * width + column) as u32;
    let near_void = |column: usize, row: usize| {
        void.is_some_and(|(x, y)| (column + first.0).abs_diff(x) <= 1 && (row + first.1).abs_diff(y) <= 1)
            && void.is_some_and(|(x, y)| column + first.0 <= x && row + first.1 <= y)
    };
    let cells = (0..MIDDLE * MIDDLE)
        .map(|i| (i % MIDDLE, i / MIDDLE))
        .filter(|&(x, y)| !near_void(x, y));
    let triangles = cells.flat_map(|(x, y)| {
        [
            [at(x, y), at(x, y + 1), at(x + 1, y + 1)],
            [at(x, y), at(x + 1, y + 1), at(x + 1, y)],
        ]
    });
    let mesh = used_vertices(&Mesh {
        positions,
        triangles: triangles.collect(),
    });
    // One collapse on each of the two sides that lie among the samples, in the order from the finest: north, east,
    // south, west; then one inside.
    let inner = |column: usize, row: usize| lattice(address, column + first.0, row + first.1);
    let (on_row, on_column) = (
        if address.y == 1 { MIDDLE } else { 0 },
        if address.x == 2 { MIDDLE } else { 0 },
    );
    let along_row = (inner(4, on_row), inner(3, on_row));
    let along_column = (inner(on_column, 4), inner(on_column, 3));
    let collapses = [
        (address.y == 0).then_some(along_row),
        (address.x == 2).then_some(along_column),
        (address.y == 1).then_some(along_row),
        (address.x == 3).then_some(along_column),
        Some((inner(2, 2), inner(1, 1))),
    ];
    tile(address, &mesh, &collapses)
}

fn root(leaves: &[Tile]) -> Tile {
    let mut numbers = HashMap::new();
    let mut mesh = Mesh::default();
    for leaf in leaves {
        let surface = leaf.surface(leaf.coarsest());
        let extent = f64::from(1_u32 << leaf.extent_bits);
        let origin = DVec2::new(f64::from(leaf.address.x % 2), f64::from(leaf.address.y)) * extent;
        let weld: Vec<u32> = surface
            .positions
            .iter()
            .map(|position| {
                let place = *position + origin.extend(0.0);
                *numbers.entry(place.to_array().map(f64::to_bits)).or_insert_with(|| {
                    mesh.positions.push(place);
                    mesh.positions.len() as u32 - 1
                })
            })
            .collect();
        mesh.triangles.extend(
            surface
                .triangles
                .iter()
                .map(|triangle| triangle.map(|corner| weld[corner as usize])),
        );
    }
    tile(
        ROOT,
        &mesh,
        &[
            None,
            None,
            None,
            None,
            Some((lattice(ROOT, 13, 13), lattice(ROOT, 12, 12))),
        ],
    )
}

fn tile(address: TileAddress, mesh: &Mesh, collapses: &[Option<(DVec2, DVec2)>]) -> Tile {
    let vertex = |place: DVec2| {
        mesh.positions
            .iter()
            .position(|position| position.truncate() == place)
            .unwrap()
    };
    let mut log = CollapseLog::default();
    for (band, collapse) in collapses.iter().enumerate() {
        let lift = if band == Side::ALL.len() { HEIGHT_STEP } else { 0.0 };
        log.collapses.extend(collapse.map(|(blue, red)| {
            let (blue, red) = (vertex(blue), vertex(red));
            let red_before = mesh.positions[red];
            let red_after = red_before + DVec3::Z * lift;
            Collapse {
                blue: blue as u32,
                red: red as u32,
                red_before,
                red_after,
                closes_hole: false,
            }
        }));
        log.bands.push(Band {
            end: log.collapses.len(),
            error: CLAIMED,
        });
    }
    let partition = SurfacePartition::from_log(mesh, &log, CLAIMED).unwrap();
    assert_eq!(partition.levels.len(), 2 + Side::ALL.len());
    let outline_errors = vec![1.0; partition.levels.len()];
    Tile {
        address,
        extent_bits: BITS - address.zoom,
        height_exponent: -6,
        sampling: None,
        lineage: Lineage::default(),
        breaklines: Vec::new(),
        filled: Filled::default(),
        partition,
        outline_errors,
    }
}

fn used_vertices(mesh: &Mesh) -> Mesh {
    let mut numbers = vec![None; mesh.positions.len()];
    let mut used = Mesh::default();
    for triangle in &mesh.triangles {
        used.triangles.push(triangle.map(|corner| {
            *numbers[corner as usize].get_or_insert_with(|| {
                used.positions.push(mesh.positions[corner as usize]);
                used.positions.len() as u32 - 1
            })
        }));
    }
    used
}

fn metadata(tiles: &BTreeMap<TileAddress, Tile>) -> Metadata {
    let zoom = |zoom: u8, available: [u32; 4]| {
        let of_zoom = || tiles.values().filter(|tile| tile.address.zoom == zoom);
        Zoom {
            zoom,
            tiles: of_zoom().count(),
            triangles: of_zoom().map(|tile| tile.partition.triangles.len()).sum(),
            finest_error: CLAIMED,
            leaves: if zoom == 1 { of_zoom().count() } else { 0 },
            leaf_error: if zoom == 1 { CLAIMED } else { 0.0 },
            coarsest_error: CLAIMED,
            outline_error: 1.0,
            available: vec![available],
        }
    };
    Metadata {
        format: FORMAT.to_owned(),
        version: VERSION,
        scheme: "geographic-tms".to_owned(),
        bounds: [89.0, -1.0, 91.0, 1.0],
        heights: [0.0, 100.0],
        min_zoom: 0,
        max_zoom: 1,
        bound: "surface".to_owned(),
        max_error: CLAIMED,
        asked: Asked::default(),
        plan: String::new(),
        source: Source {
            files: Vec::new(),
            crs: "EPSG:4326".to_owned(),
            vertical_datum: "unspecified".to_owned(),
            heights_above: String::new(),
            geoid: None,
            samples: [SAMPLES, SAMPLES],
            heights: None,
        },
        generator: "test".to_owned(),
        outside: terrain_tiles::outside::Outside::default(),
        water: terrain_tiles::water::Water::default(),
        zooms: vec![zoom(0, [1, 0, 1, 0]), zoom(1, [2, 0, 3, 1])],
    }
}
