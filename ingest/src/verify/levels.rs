//! Every level of detail of one tile against the source, block by block of its samples.
//!
//! ```text
//! draw every level; the region is what the tile's square and its triangles may touch
//! for each block of the region: fetch its samples
//!     for each level: deviation at its samples and along the edges in its cells; outlines
//! the worst of all blocks against the claims
//! ```

use std::collections::BTreeSet;

use anyhow::Result;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::METRES_IN_A_DEGREE;
use terrain_codec::tile::Tile;
use terrain_tiles::pyramid::Summary;

use super::beside::{Beside, around, outline_slack};
use super::breaklines::{Chains, Lines, Near, Stretch};
use super::deviation::{Worst, along_edges, is_covered, visit_posts};
use super::drawing::{Drawing, interior_levels, no_surface, unsound};
use super::drawn::{Level, drawings, earth, levels};
use super::farthest::{Far, Place, farthest};
use super::outline::plan_edges;
use super::report::{ROUNDING, Violation};
use super::sides::side_edges;
use super::source::{Block, Patch, Post, Source};
use super::source_outline::SourceOutline;
use super::space::{Earth, Space};
use super::square::Square;
use super::surface::Surface;
use super::tiles::Tiles;

/// Lattice units that a part of a line reaches at least from where it begins for an edge to be asked for.
const LEAST_LINE: f64 = 8.0;

/// What is needed to measure any tile.
pub(super) struct Measure<'a> {
    pub(super) source: Source<'a>,
    pub(super) tiles: &'a dyn Tiles,
    /// Where there is a tile.
    pub(super) exist: &'a BTreeSet<TileAddress>,
    pub(super) outline: &'a SourceOutline<'a>,
    pub(super) lines: &'a Lines,
    /// Whether errors are claimed between samples, too.
    pub(super) between_samples: bool,
    /// Posts along a side of the blocks that are looked at.
    pub(super) block_side: usize,
}

/// What one tile claims and breaks.
#[derive(Debug, Default)]
pub(super) struct Measured {
    /// Triangles of the finest surface.
    pub(super) triangles: usize,
    /// From the coarsest to the finest; none of a tile that cannot be drawn.
    pub(super) levels: Vec<LevelMeasured>,
    /// Lattice units around the Earth, as a power of two, less one.
    pub(super) lattice_bits: u8,
    /// What the selection asks of it.
    pub(super) summary: Option<Summary>,
    pub(super) violations: Vec<Violation>,
}

/// Claims and measurements of one level, metres.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LevelMeasured {
    pub(super) claimed: f64,
    pub(super) measured: f64,
    pub(super) claimed_outline: f64,
    pub(super) measured_outline: f64,
}

impl Measured {
    pub(super) fn broken(violation: Violation) -> Self {
        Self {
            violations: vec![violation],
            ..Self::default()
        }
    }
}

/// Worst figures of one level.
#[derive(Clone, Copy, Default)]
struct Figures {
    vertical: Worst,
    left_out: Worst,
    excess: Worst,
    /// Of lines from edges.
    lines: Worst,
}

impl Figures {
    fn max(self, other: Self) -> Self {
        Self {
            vertical: self.vertical.max(other.vertical),
            left_out: self.left_out.max(other.left_out),
            excess: self.excess.max(other.excess),
            lines: self.lines.max(other.lines),
        }
    }
}

impl Measure<'_> {
    /// Measures every level of `tile`: the interior ones with coarse sides, and the finest with all sides fine. Blocks are
    /// looked at by all threads if `spread`, by this one if not.
    ///
    /// # Errors
    /// When samples cannot be read.
    pub(super) fn tile(&self, tile: &Tile, spread: bool) -> Result<Measured> {
        if let Some(what) = unsound(tile) {
            return Ok(Measured::broken(Violation::of_tile(what, tile.address)));
        }
        let check = TileCheck {
            measure: self,
            tile,
            earth: earth(self.source, tile.address),
            square: Square::new(&self.source, tile.address),
            around: around(tile.address, self.exist),
        };
        check.run(spread)
    }

    /// Whether a tile has so many samples that all threads have something to do for it.
    pub(super) fn is_large(&self, address: TileAddress) -> bool {
        const BLOCKS: usize = 4;
        let posts = Square::new(&self.source, address).posts(&self.source);
        posts.is_some_and(|posts| posts.split(self.block_side).len() > BLOCKS)
    }
}

struct TileCheck<'a> {
    measure: &'a Measure<'a>,
    tile: &'a Tile,
    earth: Earth<'a>,
    square: Square,
    around: Vec<TileAddress>,
}

impl TileCheck<'_> {
    fn run(&self, spread: bool) -> Result<Measured> {
        let drawings = drawings(self.tile);
        let mut violations = self.sides_that_change(&drawings);
        let faults = drawings.iter().enumerate().map(|(k, drawing)| (k, no_surface(drawing)));
        let faults: Vec<_> = faults.filter_map(|(k, fault)| fault.map(|fault| (k, fault))).collect();
        if !faults.is_empty() {
            let violation = |(k, fault): &(usize, String)| self.violation(format!("is no surface: {fault}"), *k);
            violations.extend(faults.iter().map(violation));
            return Ok(Measured {
                violations,
                ..Measured::default()
            });
        }
        let levels = levels(self.tile, &self.earth, &drawings, self.measure.exist);
        let mut figures = self.figures(&levels, spread)?;
        self.measure_lines(&levels, &mut figures)?;
        let placeless = |level: &Level| level.surface.feet.iter().any(|foot| !foot.grid.is_finite());
        if let Some(k) = levels.iter().position(placeless) {
            violations.push(self.violation("has a vertex that is nowhere in the raster's system", k));
        }
        let measured: Vec<_> = levels
            .iter()
            .zip(&figures)
            .enumerate()
            .map(|(k, (level, figures))| self.compared(k, level, figures))
            .collect();
        violations.extend(measured.iter().flat_map(|(_, violations)| violations.iter().cloned()));
        Ok(Measured {
            triangles: drawings.last().map_or(0, |drawing| drawing.triangles.len()),
            levels: measured.into_iter().map(|(level, _)| level).collect(),
            lattice_bits: self.tile.address.zoom + self.tile.extent_bits,
            summary: Summary::of(self.tile, 1),
            violations,
        })
    }

    fn sides_that_change(&self, drawings: &[Drawing]) -> Vec<Violation> {
        let coarse = &drawings[..drawings.len() - 1];
        let first = side_edges(self.tile, &coarse[0]);
        let changed = coarse
            .iter()
            .position(|drawing| side_edges(self.tile, drawing) != first);
        changed
            .map(|k| self.violation("its coarse sides are not those of level 0", k))
            .into_iter()
            .collect()
    }

    /// The posts that the tile's square or its triangles may touch.
    fn region(&self, levels: &[Level]) -> Block {
        const BESIDE: f64 = 2.0;
        let source = &self.measure.source;
        let touched = levels.iter().filter_map(|level| level.surface.extent());
        let touched = touched.map(|(low, high)| Block::between(low - BESIDE, high + BESIDE, source.size()));
        let all = touched.chain(self.square.posts(source)).reduce(|a, b| a.union(&b));
        all.unwrap_or_else(|| Block::between(DVec2::ZERO, DVec2::ZERO, source.size()))
    }

    /// The worst of each level.
    fn figures(&self, levels: &[Level], spread: bool) -> Result<Vec<Figures>> {
        let region = self.region(levels);
        let Measure { source, block_side, .. } = self.measure;
        let blocks = source.blocks(&region, *block_side, |block| {
            source.may_hold(block) || is_under(levels, block)
        });
        let of_block = |block: &Block| self.block(block, &region, levels);
        let nothing = || vec![Figures::default(); levels.len()];
        let worse = |a: Vec<Figures>, b: Vec<Figures>| Ok(a.into_iter().zip(b).map(|(a, b)| a.max(b)).collect());
        if spread {
            blocks.par_iter().map(of_block).try_reduce(nothing, worse)
        } else {
            blocks
                .iter()
                .map(of_block)
                .try_fold(nothing(), |all, block| worse(all, block?))
        }
    }

    fn block(&self, block: &Block, region: &Block, levels: &[Level]) -> Result<Vec<Figures>> {
        let source = &self.measure.source;
        let patch = source.patch(block)?;
        let posts = patch.posts();
        let verticals = self.earth.verticals(&posts);
        let is_ours = |post: &(usize, usize)| {
            patch.post(post.0, post.1) == Post::Surface && self.square.has_post(source, &patch, *post)
        };
        let ours: Vec<bool> = posts.iter().map(is_ours).collect();
        let mut near = self.measure.outline.near();
        let mut beside = Beside::new(*source, self.measure.tiles, self.measure.exist);
        let place = |grid: DVec2| Place {
            grid,
            on_ellipsoid: source.on_ellipsoid(grid),
        };
        let of_level = |level: &Level| {
            let Level { surface, outline, .. } = level;
            let covered = self.cover(&patch, &verticals, surface);
            let left_out = (0..posts.len()).filter(|&index| ours[index] && !covered.posts[index]);
            let left_out = left_out.map(|index| place(DVec2::new(posts[index].0 as f64, posts[index].1 as f64)));
            let mut mesh = FarFromMesh {
                check: self,
                level,
                beside: &mut beside,
            };
            let beyond = covered.voids.iter().copied().chain(outline.beyond(&patch, region));
            Ok(Figures {
                vertical: if self.measure.between_samples {
                    along_edges(&self.earth, &patch, surface, covered.worst)
                } else {
                    covered.worst
                },
                left_out: farthest(left_out.collect(), &mut mesh)?,
                excess: farthest(beyond.map(place).collect(), &mut near)?,
                lines: Worst::default(),
            })
        };
        levels.iter().map(of_level).collect()
    }

    /// How far lines are from chains of edges, on each level.
    fn measure_lines(&self, levels: &[Level], figures: &mut [Figures]) -> Result<()> {
        let source = &self.measure.source;
        let Some(block) = self.square.posts(source) else {
            return Ok(());
        };
        let is_here = |at: DVec2| self.square.holds(source.georeference.geographic(at));
        let most = self.tile.outline_errors.iter().copied().fold(0.0, f64::max);
        let on_grid = self.measure.lines.stretches(source, &block, most, is_here)?;
        if on_grid.iter().all(|stretch| stretch.pieces().next().is_none()) {
            return Ok(());
        }
        let place = |stretch: &Stretch<DVec2>| stretch.placed(|at| source.on_ellipsoid(at));
        let stretches: Vec<Stretch<DVec3>> = on_grid.iter().map(place).collect();
        let unit = self.tile.address.degrees() / (1_u64 << self.tile.extent_bits) as f64 * METRES_IN_A_DEGREE;
        let all = on_grid
            .iter()
            .flat_map(Stretch::pieces)
            .zip(stretches.iter().flat_map(Stretch::pieces));
        let is_long = |points: &[DVec3]| points.iter().any(|at| at.distance(points[0]) > LEAST_LINE * unit);
        let pieces: Vec<(&[DVec2], &[DVec3])> = all.filter(|(_, points)| is_long(points)).collect();
        let Some(&(first, _)) = pieces.first() else {
            return Ok(());
        };
        let lines = Near::to(&stretches);
        for (level, figures) in levels.iter().zip(figures) {
            let edges = plan_edges(&self.earth, &level.surface);
            let within = self.tile.outline_errors[level.claims] + outline_slack(source, first[0]);
            let chains = Chains::near(&lines, &edges, within);
            for (grid, piece) in &pieces {
                let (metres, index) = chains.farthest(piece);
                figures.lines.meet(metres, grid[index]);
            }
        }
        Ok(())
    }

    /// Which posts the triangles cover, and the worst deviation at them.
    fn cover(&self, patch: &Patch, verticals: &[DVec3], surface: &Surface) -> Covered {
        let mut covered = Covered {
            posts: vec![false; verticals.len()],
            voids: Vec::new(),
            worst: Worst::default(),
        };
        let source = &self.measure.source;
        visit_posts(
            &self.earth,
            patch,
            verticals,
            surface,
            |(column, row), index, deviation| {
                if source.is_twice(source.geographic(column, row)) {
                    return;
                }
                match patch.post(column, row) {
                    Post::Surface => covered.worst.meet(deviation, DVec2::new(column as f64, row as f64)),
                    Post::Lone => {}
                    Post::Void => covered.voids.push(DVec2::new(column as f64, row as f64)),
                }
                covered.posts[index] = true;
            },
        );
        covered
            .voids
            .extend(self.covered_middles(patch, surface, &covered.voids));
        covered
    }

    /// The middles of those cells of nothing but voids that triangles cover; the first post of each is one of `voids`. In a wide void
    /// they may be further from its edge than all posts.
    fn covered_middles(&self, patch: &Patch, surface: &Surface, voids: &[DVec2]) -> Vec<DVec2> {
        let is_void = |post: DVec2| !patch.height(post.x as usize, post.y as usize).is_finite();
        let others = [DVec2::X, DVec2::Y, DVec2::ONE];
        let cells = voids
            .iter()
            .filter(|&&first| others.into_iter().all(|other| is_void(first + other)));
        cells
            .map(|first| first + 0.5)
            .filter(|&middle| is_covered(&self.earth, surface, middle))
            .collect()
    }

    /// A level's claims beside what was found.
    fn compared(&self, k: usize, level: &Level, figures: &Figures) -> (LevelMeasured, Vec<Violation>) {
        let georeference = self.measure.source.georeference;
        let outline = figures.left_out.max(figures.excess).max(figures.lines);
        let level = LevelMeasured {
            claimed: self.tile.partition.levels[level.claims].error,
            measured: figures.vertical.figure,
            claimed_outline: self.tile.outline_errors[level.claims],
            measured_outline: outline.figure,
        };
        let slack = outline_slack(&self.measure.source, outline.place);
        let compared = [
            ("vertical error", figures.vertical, level.claimed, ROUNDING),
            (
                "outline: a sample left out",
                figures.left_out,
                level.claimed_outline,
                slack,
            ),
            (
                "outline: the mesh ends where the source does not",
                figures.excess,
                level.claimed_outline,
                slack,
            ),
            (
                "breakline: no chain of edges is along it",
                figures.lines,
                level.claimed_outline,
                slack,
            ),
        ];
        let broken = compared
            .into_iter()
            .filter(|(_, worst, claimed, slack)| worst.figure > claimed + slack || slack.is_nan());
        let violation = |(what, worst, claimed, _): (&str, Worst, f64, f64)| {
            let place = georeference.geographic(worst.place);
            self.violation(what, k).at(place).figures(claimed, worst.figure)
        };
        (level, broken.map(violation).collect())
    }

    fn violation(&self, what: impl Into<String>, index: usize) -> Violation {
        let level = if index >= interior_levels(self.tile) {
            "finest".to_owned()
        } else {
            index.to_string()
        };
        Violation {
            level: Some(level),
            ..Violation::of_tile(what, self.tile.address)
        }
    }
}

/// The mesh of a level, which left out some posts. Those count that no tile around it is as near to as it claims.
struct FarFromMesh<'a, 'b> {
    check: &'a TileCheck<'a>,
    level: &'a Level,
    beside: &'a mut Beside<'b>,
}

impl Far for FarFromMesh<'_, '_> {
    fn distance(&mut self, on_ellipsoid: DVec3) -> Result<f64> {
        let Level { outline, surface, .. } = self.level;
        Ok(outline.distance(&self.check.earth, surface, on_ellipsoid))
    }

    fn add(&mut self, places: &[Place], worst: &mut Worst) -> Result<()> {
        let claim = self.check.tile.outline_errors[self.level.claims];
        for place in places {
            let distance = self.distance(place.on_ellipsoid)?;
            let is_beyond = distance > claim + outline_slack(&self.check.measure.source, place.grid);
            let post = (place.grid.x as usize, place.grid.y as usize);
            let mut kept = false;
            for &other in self.check.around.iter().filter(|_| is_beyond) {
                kept = kept || self.beside.keeps(other, post, self.level.has_fine_sides)?;
            }
            if !kept {
                worst.meet(distance, place.grid);
            }
        }
        Ok(())
    }
}

/// Whether some triangle may lie over a block.
fn is_under(levels: &[Level], block: &Block) -> bool {
    levels.iter().any(|level| level.surface.over(block).next().is_some())
}

/// What a level's triangles cover of a block.
struct Covered {
    /// Of each post that is looked at, whether.
    posts: Vec<bool>,
    /// Places without a height.
    voids: Vec<DVec2>,
    worst: Worst,
}
