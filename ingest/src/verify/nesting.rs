//! A tile's coarsest surface must be its parent's finest over the same square, triangle for triangle and bit for bit.

use std::collections::BTreeSet;

use terrain_codec::address::TileAddress;
use terrain_codec::tile::Tile;

use super::drawing::{Shown, coarse_sided, draw, finest};
use super::filled;
use super::report::Violation;
use super::sides::{Node, node};

/// A triangle that begins with its smallest corner.
type NodeTriangle = [Node; 3];

/// Compares `parent` with those of its children that exist.
pub(super) fn check(parent: &Tile, children: &[Tile]) -> Vec<Violation> {
    let of_parent = triangles(parent, finest(parent));
    let mut violations = Vec::new();
    let mut claimed = 0;
    for child in children {
        let of_child = triangles(child, coarse_sided(0));
        claimed += of_child.len();
        let strange = of_child.difference(&of_parent).count();
        if strange > 0 {
            let what = format!("{strange} triangles of its coarsest surface are not in its parent's finest");
            violations.push(Violation::of_tile(what, child.address));
        }
    }
    if violations.is_empty() && claimed != of_parent.len() {
        let what = format!(
            "{} triangles of its finest surface are in the coarsest of none of its children, or of two",
            of_parent.len().abs_diff(claimed)
        );
        violations.push(Violation::of_tile(what, parent.address));
    }
    violations.extend(filled::check_parent(parent, children));
    violations
}

/// Tiles of `exist` whose parent is not there.
pub(super) fn orphans(exist: &BTreeSet<TileAddress>) -> Vec<Violation> {
    let orphaned = exist
        .iter()
        .filter(|address| address.parent().is_some_and(|parent| !exist.contains(&parent)));
    orphaned
        .map(|&address| Violation::of_tile("has no parent in the archive", address))
        .collect()
}

fn triangles(tile: &Tile, shown: Shown) -> BTreeSet<NodeTriangle> {
    let drawing = draw(tile, shown);
    let nodes: Vec<Node> = drawing.positions.iter().map(|&position| node(tile, position)).collect();
    let turned = |[a, b, c]: NodeTriangle| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c]);
    drawing
        .triangles
        .iter()
        .map(|corners| turned(corners.map(|corner| nodes[corner as usize])))
        .collect()
}
