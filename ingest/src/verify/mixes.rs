//! Mixes of zooms, levels and sides, as a client may draw them, must be watertight: any that are admissible, at random, and
//! those that the selection chooses for cameras ([`super::views`]).
//!
//! ```text
//! descend from the roots, always towards one random leaf, elsewhere by chance
//! split what is more than one zoom coarser than a tile across a side
//! next to finer tiles: finest interior, that side fine; elsewhere a random interior level
//! sides between equals: both fine or both coarse by chance, fine only where both show their finest interior
//! every edge on a side must be met by the tile across it
//! ```

use std::collections::{BTreeMap, BTreeSet, HashSet};

use anyhow::Result;
use fastrand::Rng;
use terrain_codec::address::{Side, TileAddress};

use super::drawing::{Shown, draw, no_surface};
use super::report::Violation;
use super::sides::{NodeEdge, is_one_sided, opposite, side_edges};
use super::source::Source;
use super::tiles::Tiles;

/// Tiles of an archive by address, with their number of interior levels.
pub(super) type Interiors = BTreeMap<TileAddress, usize>;

/// A mix by chance.
pub(super) fn random(interiors: &Interiors, seed: u64) -> BTreeMap<TileAddress, Shown> {
    let mut random = Rng::with_seed(seed);
    Selection::new(interiors, &mut random).shown(interiors, &mut random)
}

/// Draws a mix and returns how many tiles it has and where it is not watertight.
///
/// # Errors
/// When samples cannot be read.
pub(super) fn check(
    tiles: &dyn Tiles,
    source: &Source,
    mix: &BTreeMap<TileAddress, Shown>,
    name: &str,
) -> Result<(usize, Vec<Violation>)> {
    let selection = Selection {
        tiles: mix.keys().copied().collect(),
    };
    let mut violations = Vec::new();
    let mut drawn = Vec::new();
    for (&address, &shown) in mix {
        // Tiles that cannot be read have been reported by whoever counted their levels.
        let Ok(tile) = tiles.tile(address) else { continue };
        let drawing = draw(&tile, shown);
        if let Some(fault) = no_surface(&drawing) {
            let what = format!("drawn as {shown:?} is no surface: {fault}");
            violations.push(Violation::of_tile(what, address));
        }
        drawn.push((address, tile.extent_bits, side_edges(&tile, &drawing)));
    }
    let all: HashSet<NodeEdge> = drawn
        .iter()
        .flat_map(|(_, _, sides)| sides.iter().flatten().copied())
        .collect();
    for (address, bits, sides) in &drawn {
        for side in Side::ALL {
            let open = sides[side as usize].iter().filter(|[a, b]| !all.contains(&[*b, *a]));
            let mut gaps = 0;
            for &edge in open.filter(|&&edge| selection.has_tile_across(*address, side, edge, *bits)) {
                gaps += usize::from(!is_one_sided(source, *address, *bits, side, edge)?);
            }
            if gaps > 0 {
                let what = format!("{side:?} side: {gaps} edges that the tile across does not meet in {name}");
                violations.push(Violation::of_tile(what, *address));
            }
        }
    }
    Ok((drawn.len(), violations))
}

/// What is across a side of a selected tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Across {
    Nothing,
    Coarser,
    Equal,
    Finer,
}

/// Tiles that cover what the archive covers, each place once, zooms differing by at most one across a side.
struct Selection {
    tiles: BTreeSet<TileAddress>,
}

impl Selection {
    fn new(exist: &Interiors, random: &mut Rng) -> Self {
        const SPLIT_ELSEWHERE: f64 = 0.4;
        let mut selection = Self { tiles: BTreeSet::new() };
        let target = random.choice(exist.keys().copied().collect::<Vec<_>>());
        let mut waiting: Vec<_> = exist.keys().copied().filter(|address| address.zoom == 0).collect();
        while let Some(address) = waiting.pop() {
            let children = children(exist, address);
            let leads_to_target = target.is_some_and(|target| ancestors(target).any(|other| other == address));
            if !children.is_empty() && (leads_to_target || random.f64() < SPLIT_ELSEWHERE) {
                waiting.extend(children);
            } else {
                selection.tiles.insert(address);
            }
        }
        while let Some(coarse) = selection.too_coarse() {
            selection.tiles.remove(&coarse);
            selection.tiles.extend(children(exist, coarse));
        }
        selection
    }

    /// A selected tile two zooms or more coarser than one across a side.
    fn too_coarse(&self) -> Option<TileAddress> {
        let across = self
            .tiles
            .iter()
            .flat_map(|tile| Side::ALL.map(|side| tile.neighbour(side)).into_iter().flatten());
        across
            .filter_map(|place| {
                ancestors(place)
                    .find(|ancestor| self.tiles.contains(ancestor))
                    .map(|a| (place, a))
            })
            .find(|(place, ancestor)| place.zoom > ancestor.zoom + 1)
            .map(|(_, ancestor)| ancestor)
    }

    fn across(&self, address: TileAddress, side: Side) -> Across {
        let Some(place) = address.neighbour(side) else {
            return Across::Nothing;
        };
        if self.tiles.contains(&place) {
            Across::Equal
        } else if ancestors(place).any(|ancestor| self.tiles.contains(&ancestor)) {
            Across::Coarser
        } else if place.children().iter().any(|child| self.tiles.contains(child)) {
            Across::Finer
        } else {
            Across::Nothing
        }
    }

    /// How to draw each tile.
    fn shown(&self, exist: &Interiors, random: &mut Rng) -> BTreeMap<TileAddress, Shown> {
        let mut details: BTreeMap<TileAddress, Shown> = BTreeMap::new();
        for &address in &self.tiles {
            let finest = exist[&address].saturating_sub(1);
            let must_be_finest = Side::ALL
                .iter()
                .any(|&side| self.across(address, side) == Across::Finer);
            let interior = if must_be_finest || random.bool() {
                finest
            } else {
                random.usize(0..=finest)
            };
            details.insert(
                address,
                Shown {
                    interior,
                    fine_sides: [false; 4],
                },
            );
        }
        let is_finest = |details: &BTreeMap<TileAddress, Shown>, address: TileAddress| {
            details
                .get(&address)
                .is_some_and(|shown| shown.interior + 1 == exist[&address])
        };
        for (address, side) in self
            .tiles
            .iter()
            .flat_map(|&address| Side::ALL.map(|side| (address, side)))
        {
            let chance = random.bool();
            let equal = address
                .neighbour(side)
                .filter(|_| self.across(address, side) == Across::Equal);
            let fine = match self.across(address, side) {
                Across::Nothing => chance,
                Across::Coarser => false,
                Across::Finer => true,
                // The pair is decided by the western or southern one of the two.
                Across::Equal if matches!(side, Side::West | Side::South) => continue,
                Across::Equal => chance && equal.is_some_and(|other| is_finest(&details, other)),
            };
            let fine = fine && is_finest(&details, address);
            for (tile, side) in [Some((address, side)), equal.map(|other| (other, opposite(side)))]
                .into_iter()
                .flatten()
            {
                if let Some(shown) = details.get_mut(&tile) {
                    shown.fine_sides[side as usize] = fine;
                }
            }
        }
        details
    }

    /// Whether a selected tile should meet this edge of the tile at `address` from across its `side`.
    fn has_tile_across(&self, address: TileAddress, side: Side, edge: NodeEdge, extent_bits: u8) -> bool {
        match self.across(address, side) {
            Across::Nothing => false,
            Across::Coarser | Across::Equal => true,
            Across::Finer => {
                let half = doubled_middle(edge, side, address.zoom + extent_bits) >> extent_bits;
                let is_at = |child: &TileAddress| match side {
                    Side::West | Side::East => u64::from(child.y) == half,
                    Side::South | Side::North => u64::from(child.x) == half,
                };
                let touches = |child: &TileAddress| {
                    child.neighbour(opposite(side)).and_then(TileAddress::parent) == Some(address)
                };
                let children = address.neighbour(side).map(TileAddress::children).into_iter().flatten();
                children
                    .filter(|child| is_at(child) && touches(child))
                    .any(|child| self.tiles.contains(&child))
            }
        }
    }
}

/// Twice the place of an edge's middle along the side it lies on; the Earth is 2^(`bits` + 1) lattice units round.
fn doubled_middle([a, b]: NodeEdge, side: Side, bits: u8) -> u64 {
    if matches!(side, Side::West | Side::East) {
        return a.y + b.y;
    }
    let crosses_antimeridian = a.x.abs_diff(b.x) > 1 << bits;
    a.x + b.x + if crosses_antimeridian { 2 << bits } else { 0 }
}

fn children(exist: &Interiors, address: TileAddress) -> Vec<TileAddress> {
    address
        .children()
        .into_iter()
        .filter(|child| exist.contains_key(child))
        .collect()
}

fn ancestors(address: TileAddress) -> impl Iterator<Item = TileAddress> {
    std::iter::successors(address.parent(), |address| address.parent())
}
