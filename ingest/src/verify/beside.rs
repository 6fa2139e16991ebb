//! Posts that a tile leaves to the tiles around it: an outline close to a side was moved onto it, and edges that are straight
//! in space bulge from a parallel. Somebody's mesh has to be as near to such a post as its tile claims.

use std::collections::{BTreeSet, HashMap};

use anyhow::Result;
use glam::DVec2;
use terrain_codec::address::TileAddress;

use super::deviation::visit_posts;
use super::drawing::{no_surface, unsound};
use super::drawn::{Level, drawings, earth, levels};
use super::source::{Block, Source};
use super::space::{Earth, Space};
use super::tiles::{Tiles, is_leaf};

/// Part of a cell by which an outline may exceed its claim: the rounding of the raster's own place on the Earth.
const CELL_SLACK: f64 = 1e-3;

/// What an outline may exceed its claim by, near a post.
pub(super) fn outline_slack(source: &Source, place: DVec2) -> f64 {
    source.georeference.cell_metres(place).max_element() * CELL_SLACK
}

/// Tiles that posts are asked about, one after the other.
pub(super) struct Beside<'a> {
    source: Source<'a>,
    tiles: &'a dyn Tiles,
    exist: &'a BTreeSet<TileAddress>,
    /// None of those that cannot be drawn: what is wrong with them is told when they are measured.
    drawn: HashMap<TileAddress, Option<Drawn<'a>>>,
}

struct Drawn<'a> {
    earth: Earth<'a>,
    levels: Vec<Level>,
    outline_claims: Vec<f64>,
}

impl<'a> Beside<'a> {
    pub(super) fn new(source: Source<'a>, tiles: &'a dyn Tiles, exist: &'a BTreeSet<TileAddress>) -> Self {
        Self {
            source,
            tiles,
            exist,
            drawn: HashMap::new(),
        }
    }

    pub(super) fn exists(&self, address: TileAddress) -> bool {
        self.exist.contains(&address)
    }

    /// Whether a tile is below one that has no children, which stands for all below it.
    pub(super) fn is_below_leaf(&self, address: TileAddress) -> bool {
        let above = std::iter::successors(address.parent(), |above| above.parent());
        let nearest = above.into_iter().find(|above| self.exists(*above));
        nearest.is_some_and(|nearest| is_leaf(self.exist, nearest))
    }

    /// Whether a tile that exists is as near to a post as it claims, at all levels with coarse or with fine sides.
    pub(super) fn keeps(&mut self, address: TileAddress, post: (usize, usize), has_fine_sides: bool) -> Result<bool> {
        let source = self.source;
        let (tiles, exist) = (self.tiles, self.exist);
        let drawn = self
            .drawn
            .entry(address)
            .or_insert_with(|| draw(source, tiles, exist, address));
        let Some(drawn) = drawn else { return Ok(false) };
        let place = DVec2::new(post.0 as f64, post.1 as f64);
        let (slack, on_ellipsoid) = (outline_slack(&source, place), source.on_ellipsoid(place));
        let asked = drawn
            .levels
            .iter()
            .filter(|level| level.has_fine_sides == has_fine_sides);
        for level in asked {
            let claim = drawn.outline_claims[level.claims] + slack;
            let distance = || level.outline.distance(&drawn.earth, &level.surface, on_ellipsoid);
            if !drawn.covers(level, post)? && distance() > claim {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl Drawn<'_> {
    fn covers(&self, level: &Level, (column, row): (usize, usize)) -> Result<bool> {
        let block = Block {
            columns: column..column + 1,
            rows: row..row + 1,
        };
        let patch = self.earth.source.patch(&block)?;
        let verticals = self.earth.verticals(&[(column, row)]);
        let mut is_covered = false;
        visit_posts(&self.earth, &patch, &verticals, &level.surface, |_, _, _| {
            is_covered = true
        });
        Ok(is_covered)
    }
}

fn draw<'a>(
    source: Source<'a>,
    tiles: &dyn Tiles,
    exist: &BTreeSet<TileAddress>,
    address: TileAddress,
) -> Option<Drawn<'a>> {
    if !exist.contains(&address) {
        return None;
    }
    let tile = tiles.tile(address).ok().filter(|tile| unsound(tile).is_none())?;
    let drawings = drawings(&tile);
    let earth = earth(source, address);
    drawings
        .iter()
        .all(|drawing| no_surface(drawing).is_none())
        .then(|| Drawn {
            levels: levels(&tile, &earth, &drawings, exist),
            earth,
            outline_claims: tile.outline_errors,
        })
}

/// The tiles of one zoom around one, as far as they exist.
pub(super) fn around(address: TileAddress, exist: &BTreeSet<TileAddress>) -> Vec<TileAddress> {
    use terrain_codec::address::Side::{East, North, South, West};
    let ways = [
        vec![West],
        vec![East],
        vec![South],
        vec![North],
        vec![West, South],
        vec![West, North],
        vec![East, South],
        vec![East, North],
    ];
    let go = |way: Vec<_>| {
        way.into_iter()
            .try_fold(address, |at: TileAddress, side| at.neighbour(side))
    };
    ways.into_iter()
        .filter_map(go)
        .filter(|other| exist.contains(other))
        .collect()
}
