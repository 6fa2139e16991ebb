//! Every level of detail of one tile against the source.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use terrain_core::levels::partition;
use terrain_core::{Mesh, mesh};
use terrain_tiles::ellipsoid::{Geodetic, to_earth_centred};
use terrain_tiles::tile::{Detail, Tile};

use super::deviation::{Worst, along_edges, visit_posts};
use super::outline::Outline;
use super::reference::{Post, Reference};
use super::report::{ROUNDING, Violation};
use super::sides::{SideEdges, Sides, side_edges};
use super::space::{Earth, Foot};
use super::surface::Surface;
use super::window::{Window, turn};

/// Lattice units around the Earth as a power of two, less one, that are whole numbers of an `f64` with room to spare.
const MOST_BITS: u8 = 48;

/// Part of a cell by which an outline may exceed its claim: the rounding of the raster's own place on the Earth.
const CELL_SLACK: f64 = 1e-3;

/// What is needed to measure any tile.
pub(super) struct Source<'a> {
    pub(super) reference: &'a Reference<'a>,
    pub(super) normals: &'a [DVec3],
    /// Whether errors are claimed between samples, too.
    pub(super) between_samples: bool,
}

/// What one tile claims, shows and breaks.
#[derive(Debug, Default)]
pub(super) struct Measured {
    /// Triangles of the finest surface.
    pub(super) triangles: usize,
    /// From the coarsest to the finest.
    pub(super) levels: Vec<LevelMeasured>,
    pub(super) sides: Sides,
    pub(super) violations: Vec<Violation>,
}

/// Claims and measurements of one level, metres.
#[derive(Debug, Default)]
pub(super) struct LevelMeasured {
    pub(super) claimed: f64,
    pub(super) measured: f64,
    pub(super) claimed_outline: f64,
    pub(super) measured_outline: f64,
    triangles: usize,
    sides: [SideEdges; 4],
    violations: Vec<Violation>,
}

/// Measures every level of `tile`: the interior ones with coarse sides, and the finest with all sides fine.
/// `neighbours` says across which sides there is a tile of the same zoom.
pub(super) fn measure(source: &Source, tile: &Tile, neighbours: [bool; 4]) -> Measured {
    if let Some(what) = unsound(tile) {
        return Measured {
            violations: vec![Violation::of_tile(what, tile.address)],
            ..Measured::default()
        };
    }
    let turn = turn(source.reference, tile.address);
    let earth = Earth {
        reference: source.reference,
        normals: source.normals,
        middle_longitude: tile.address.west() + tile.address.degrees() / 2.0 + turn,
    };
    let window = Window::new(source.reference, tile.address, turn);
    let check = TileCheck {
        source,
        tile,
        earth,
        turn,
        window,
        neighbours,
    };
    let interior = (0..tile.interior_levels()).map(|k| {
        (
            k,
            Detail {
                interior: k,
                fine_sides: [false; 4],
            },
        )
    });
    let details: Vec<_> = interior
        .chain([(tile.partition.levels.len() - 1, tile.finest())])
        .collect();
    let mut levels: Vec<_> = details
        .into_par_iter()
        .map(|(index, detail)| check.level(index, detail))
        .collect();
    let mut violations: Vec<_> = levels
        .iter_mut()
        .flat_map(|level| std::mem::take(&mut level.violations))
        .collect();
    let (Some(first), Some(last)) = (levels.first(), levels.last()) else {
        return Measured::default();
    };
    let changes = levels[..levels.len() - 1]
        .iter()
        .position(|level| level.sides != first.sides);
    if let Some(level) = changes {
        violations.push(check.violation("its coarse sides are not those of level 0", level));
    }
    let sides = Sides {
        extent_bits: tile.extent_bits,
        coarse: first.sides.clone(),
        fine: last.sides.clone(),
    };
    Measured {
        triangles: last.triangles,
        levels,
        sides,
        violations,
    }
}

/// What keeps a tile from being drawn at all.
fn unsound(tile: &Tile) -> Option<String> {
    if let Err(error) = partition::validate(&tile.partition) {
        return Some(format!("is no Surface Partition: {error}"));
    }
    let levels = tile.partition.levels.len();
    if levels < 5 || tile.outline_errors.len() != levels {
        return Some(format!(
            "has {levels} levels and {} outline errors",
            tile.outline_errors.len()
        ));
    }
    let finite = |value: &f64| value.is_finite();
    let claims_are_finite = tile.partition.levels.iter().all(|level| finite(&level.error));
    if !claims_are_finite || !tile.outline_errors.iter().all(finite) {
        return Some("claims an error that is no number of metres".to_owned());
    }
    if tile.address.zoom + tile.extent_bits > MOST_BITS {
        return Some(format!(
            "has a lattice of {} bits",
            tile.address.zoom + tile.extent_bits
        ));
    }
    let extent = (1_u64 << tile.extent_bits) as f64;
    let in_square = |p: &DVec3| {
        [p.x, p.y]
            .iter()
            .all(|v| (0.0..=extent).contains(v) && v.fract() == 0.0)
    };
    let all_in_square = tile
        .partition
        .positions
        .iter()
        .chain(&tile.partition.blue_positions)
        .all(in_square);
    (!all_in_square).then(|| "has a vertex off its lattice".to_owned())
}

/// What a level's triangles cover.
struct Coverage {
    /// For each post of the tile's window.
    samples: Vec<bool>,
    /// Column and row of voids.
    voids: Vec<(usize, usize)>,
}

struct TileCheck<'a> {
    source: &'a Source<'a>,
    tile: &'a Tile,
    earth: Earth<'a>,
    turn: f64,
    window: Window,
    neighbours: [bool; 4],
}

impl TileCheck<'_> {
    fn level(&self, index: usize, detail: Detail) -> LevelMeasured {
        let mesh = self.tile.surface(detail);
        let mut result = LevelMeasured {
            claimed: self.tile.partition.levels[index].error,
            claimed_outline: self.tile.outline_errors[index],
            triangles: mesh.triangles.len(),
            sides: side_edges(self.tile, &mesh),
            ..LevelMeasured::default()
        };
        if let Err(error) = mesh::validate(&mesh) {
            result
                .violations
                .push(self.violation(format!("is no surface: {error}"), index));
            return result;
        }
        let surface = self.surface(&mesh);
        let (coverage, at_samples) = self.cover(&surface);
        let deviation = if self.source.between_samples {
            at_samples.max(along_edges(&self.earth, self.source.reference, &surface))
        } else {
            at_samples
        };
        let outline = Outline::new(self.tile, &self.earth, &mesh, &surface);
        let uncovered = outline.uncovered(&self.window, &coverage.samples, self.neighbours);
        let excess = outline.excess(&coverage.voids);
        result.measured = deviation.figure;
        result.measured_outline = uncovered.figure.max(excess.figure);
        let georeference = &self.source.reference.grid.georeference;
        let slack = georeference.cell_metres(uncovered.max(excess).place).max_element() * CELL_SLACK;
        let figures = [
            ("vertical error", deviation, result.claimed, ROUNDING),
            ("outline: a sample left out", uncovered, result.claimed_outline, slack),
            (
                "outline: the mesh ends where the source does not",
                excess,
                result.claimed_outline,
                slack,
            ),
        ];
        let broken = figures
            .into_iter()
            .filter(|(_, worst, claimed, slack)| worst.figure > claimed + slack);
        result.violations.extend(broken.map(|(what, worst, claimed, _)| {
            let place = georeference.geographic(worst.place);
            self.violation(what, index).at(place).figures(claimed, worst.figure)
        }));
        result
    }

    /// Which posts the triangles cover, and the worst deviation at them.
    fn cover(&self, surface: &Surface) -> (Coverage, Worst) {
        let mut coverage = Coverage {
            samples: vec![false; self.window.inside.len()],
            voids: Vec::new(),
        };
        let mut worst = Worst::default();
        visit_posts(&self.earth, self.source.reference, surface, |column, row, deviation| {
            match self.source.reference.post(column, row) {
                Post::Surface => worst.meet(deviation, DVec2::new(column as f64, row as f64)),
                Post::Lone => {}
                Post::Void => coverage.voids.push((column, row)),
            }
            if let Some(index) = self.window.index(column, row) {
                coverage.samples[index] = true;
            }
        });
        (coverage, worst)
    }

    fn violation(&self, what: impl Into<String>, index: usize) -> Violation {
        let finest = index + 1 == self.tile.partition.levels.len();
        let level = if finest { "finest".to_owned() } else { index.to_string() };
        Violation {
            level: Some(level),
            ..Violation::of_tile(what, self.tile.address)
        }
    }

    fn surface(&self, mesh: &Mesh) -> Surface {
        let unit = self.tile.address.degrees() / (1_u64 << self.tile.extent_bits) as f64;
        let origin = DVec2::new(self.tile.address.west(), self.tile.address.south());
        let feet = mesh.positions.iter().map(|position| {
            let geographic = origin + position.truncate() * unit;
            let grid = self
                .source
                .reference
                .grid
                .georeference
                .grid(geographic + DVec2::new(self.turn, 0.0));
            (
                geographic,
                Foot {
                    grid,
                    height: position.z,
                },
            )
        });
        let (geographic, feet): (Vec<DVec2>, Vec<Foot>) = feet.unzip();
        let positions = geographic.iter().zip(&feet).map(|(place, foot)| {
            to_earth_centred(Geodetic {
                longitude: place.x,
                latitude: place.y,
                height: foot.height,
            })
        });
        Surface {
            positions: positions.collect(),
            feet,
            triangles: mesh.triangles.clone(),
        }
    }
}
