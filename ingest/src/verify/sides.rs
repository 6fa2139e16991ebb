//! The sides of tiles on the lattice of the whole Earth, and whether neighbours agree on them.

use std::collections::BTreeSet;

use anyhow::Result;
use glam::{DVec2, DVec3};
use terrain_codec::address::{Side, TileAddress};
use terrain_codec::tile::Tile;

use super::drawing::{Drawing, boundary_edges, coarse_sided, draw, finest};
use super::report::Violation;
use super::source::Source;
use super::square::turn;

/// Lattice units by which an outline may be moved onto a side, and one more.
pub(super) const MOVED_ONTO_A_SIDE: f64 = 5.0;

/// A vertex by its place on the lattice of the whole Earth and the bits of its height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Node {
    /// Lattice units east of the antimeridian.
    pub(super) x: u64,
    /// Lattice units north of the south pole.
    pub(super) y: u64,
    height: u64,
}

/// A directed edge of a mesh.
pub(super) type NodeEdge = [Node; 2];

/// Edges along one side of a tile, directed as its triangles have them.
pub(super) type SideEdges = BTreeSet<NodeEdge>;

/// A tile's sides in the order of [`Side::ALL`].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sides {
    pub(super) address: TileAddress,
    pub(super) extent_bits: u8,
    pub(super) coarse: [SideEdges; 4],
    pub(super) fine: [SideEdges; 4],
}

impl Sides {
    /// Of a sound tile.
    pub(super) fn of(tile: &Tile) -> Self {
        Self {
            address: tile.address,
            extent_bits: tile.extent_bits,
            coarse: side_edges(tile, &draw(tile, coarse_sided(0))),
            fine: side_edges(tile, &draw(tile, finest(tile))),
        }
    }
}

/// The node of a lattice position of a tile. The antimeridian has one place, 0.
pub(super) fn node(tile: &Tile, position: DVec3) -> Node {
    let extent = 1_u64 << tile.extent_bits;
    let columns = 2_u64 << tile.address.zoom;
    Node {
        x: (u64::from(tile.address.x) * extent + position.x as u64) % (columns * extent),
        y: u64::from(tile.address.y) * extent + position.y as u64,
        // The sum turns −0 into 0.
        height: (position.z + 0.0).to_bits(),
    }
}

/// The side of the square that an edge between two lattice positions runs along, if any.
pub(super) fn side_of(tile: &Tile, [a, b]: [DVec3; 2]) -> Option<Side> {
    let extent = (1_u64 << tile.extent_bits) as f64;
    let along = [
        (Side::West, a.x == 0.0 && b.x == 0.0),
        (Side::South, a.y == 0.0 && b.y == 0.0),
        (Side::East, a.x == extent && b.x == extent),
        (Side::North, a.y == extent && b.y == extent),
    ];
    along.into_iter().find(|(_, on_it)| *on_it).map(|(side, _)| side)
}

/// The edges of a tile's surface along each side of its square.
pub(super) fn side_edges(tile: &Tile, drawing: &Drawing) -> [SideEdges; 4] {
    let mut sides: [SideEdges; 4] = Default::default();
    for edge in boundary_edges(&drawing.triangles) {
        let ends = edge.map(|end| drawing.positions[end as usize]);
        if let Some(side) = side_of(tile, ends) {
            sides[side as usize].insert(ends.map(|position| node(tile, position)));
        }
    }
    sides
}

/// The side of the neighbour that is this side of the tile.
pub(super) fn opposite(side: Side) -> Side {
    match side {
        Side::West => Side::East,
        Side::South => Side::North,
        Side::East => Side::West,
        Side::North => Side::South,
    }
}

/// Whether the source has a surface on one side only of an edge that runs along a side of a tile: the edge is then
/// an outline, and nothing has to meet it.
pub(super) fn is_one_sided(
    source: &Source,
    address: TileAddress,
    extent_bits: u8,
    side: Side,
    edge: NodeEdge,
) -> Result<bool> {
    let extent = 1_u64 << extent_bits;
    let unit = address.degrees() / extent as f64;
    let circle = (2_u64 << address.zoom) * extent;
    let [a, b] = edge.map(|node| {
        let x = (node.x + circle - u64::from(address.x) * extent) % circle;
        DVec2::new(x as f64, (node.y - u64::from(address.y) * extent) as f64)
    });
    let middle = (a + b) / 2.0 * unit;
    let outwards = match side {
        Side::West => -DVec2::X,
        Side::South => -DVec2::Y,
        Side::East => DVec2::X,
        Side::North => DVec2::Y,
    };
    let place = DVec2::new(address.west() + turn(source, address), address.south()) + middle;
    let covers = |place: DVec2| source.has_cell(source.georeference.grid(place));
    Ok(covers(place - outwards * MOVED_ONTO_A_SIDE * unit)? && !covers(place + outwards * MOVED_ONTO_A_SIDE * unit)?)
}

/// Compares two tiles of one zoom on their common side, the `side` of the first.
pub(super) fn check_pair(source: &Source, first: &Sides, side: Side, second: &Sides) -> Result<Vec<Violation>> {
    let other = opposite(side);
    let pairs = [
        ("coarse", &first.coarse[side as usize], &second.coarse[other as usize]),
        ("fine", &first.fine[side as usize], &second.fine[other as usize]),
    ];
    let mut violations = Vec::new();
    for (name, of_first, of_second) in pairs {
        let mut count = 0;
        for (is_first, edge) in unmatched(of_first, of_second) {
            let (tile, side) = if is_first { (first, side) } else { (second, other) };
            count += usize::from(!is_one_sided(source, tile.address, tile.extent_bits, side, edge)?);
        }
        if count > 0 {
            let what = format!(
                "{side:?} side, {name}: {count} edges are not shared with tile {}",
                second.address
            );
            violations.push(Violation::of_tile(what, first.address));
        }
    }
    Ok(violations)
}

/// What one tile shows on its sides must fit together and be its parent's.
pub(super) fn check_own(sides: &Sides, parent: Option<&Sides>) -> Vec<Violation> {
    let address = sides.address;
    let mut violations = Vec::new();
    for side in Side::ALL {
        let (coarse, fine) = (&sides.coarse[side as usize], &sides.fine[side as usize]);
        if !nodes(coarse).is_subset(&nodes(fine)) {
            let what = format!("{side:?} side: coarse vertices that the fine side lacks");
            violations.push(Violation::of_tile(what, address));
        }
        let of_parent = match side {
            Side::West => address.x.is_multiple_of(2),
            Side::South => address.y.is_multiple_of(2),
            Side::East => !address.x.is_multiple_of(2),
            Side::North => !address.y.is_multiple_of(2),
        };
        let Some(parent) = parent.filter(|_| of_parent) else {
            continue;
        };
        if !coarse.is_subset(&parent.fine[side as usize]) {
            let what = format!("{side:?} side: coarse edges that are not its parent's fine ones");
            violations.push(Violation::of_tile(what, address));
        }
    }
    violations
}

/// Edges of two tiles along their common side that the other lacks; `true` for those of the first.
fn unmatched(of_first: &SideEdges, of_second: &SideEdges) -> Vec<(bool, NodeEdge)> {
    let lacking = |edges: &SideEdges, others: &SideEdges| -> Vec<NodeEdge> {
        edges
            .iter()
            .copied()
            .filter(|&[a, b]| !others.contains(&[b, a]))
            .collect()
    };
    let first = lacking(of_first, of_second).into_iter().map(|edge| (true, edge));
    first
        .chain(lacking(of_second, of_first).into_iter().map(|edge| (false, edge)))
        .collect()
}

fn nodes(edges: &SideEdges) -> BTreeSet<Node> {
    edges.iter().flatten().copied().collect()
}

#[cfg(test)]
#[path = "sides_tests.rs"]
mod tests;
