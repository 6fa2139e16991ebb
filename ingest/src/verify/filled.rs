//! Which ground of tiles was not measured: every post that was filled is in a cell that says so, no such cell is far from all of
//! them, and a parent says what its children say.

use std::collections::BTreeSet;

use anyhow::Result;
use glam::DVec2;
use terrain_codec::tile::Tile;

use super::report::Violation;
use super::source::Source;
use super::square::{Square, turn};

/// Cells along a side of a tile.
const CELLS: usize = 256;

/// Compares what a leaf says with the posts of the source, where it is known which of them were filled.
pub(super) fn check_leaf(source: &Source, leaf: &Tile) -> Result<Vec<Violation>> {
    let Some(block) = Square::new(source, leaf.address).posts(source) else {
        return Ok(Vec::new());
    };
    let Some(posts) = source.samples.filled(block.columns, block.rows)? else {
        return Ok(Vec::new());
    };
    let west = leaf.address.west() + turn(source, leaf.address);
    let corner = DVec2::new(west, leaf.address.south());
    let in_tile = |[column, row]: [usize; 2]| (source.geographic(column, row) - corner) / leaf.address.degrees();
    let mut unsaid = 0;
    let mut near = BTreeSet::new();
    for [column, row] in posts {
        let post = in_tile([column, row]);
        let is_inside = post.cmpge(DVec2::ZERO).all() && post.cmple(DVec2::ONE).all();
        unsaid += usize::from(is_inside && !leaf.filled.has(post));
        let before = in_tile([column.saturating_sub(1), row.saturating_sub(1)]);
        let behind = in_tile([column + 1, row + 1]);
        let reach = (before - post).abs().max((behind - post).abs()).max_element() * std::f64::consts::SQRT_2;
        near.extend(cells_between(post - reach, post + reach));
    }
    let strange = leaf.filled.cells().filter(|cell| !near.contains(cell)).count();
    let mut violations = Vec::new();
    if unsaid > 0 {
        let what = format!("{unsaid} samples that were filled are in cells that it says were measured");
        violations.push(Violation::of_tile(what, leaf.address));
    }
    if strange > 0 {
        let what = format!("{strange} cells that it says were filled are next to no sample that was");
        violations.push(Violation::of_tile(what, leaf.address));
    }
    Ok(violations)
}

/// Compares what a parent says with what its children say.
pub(super) fn check_parent(parent: &Tile, children: &[Tile]) -> Option<Violation> {
    let in_parent = |child: &Tile| {
        let first = [child.address.x, child.address.y].map(|at| at as usize % 2 * CELLS / 2);
        let cells: Vec<[usize; 2]> = child.filled.cells().collect();
        cells
            .into_iter()
            .map(move |[column, row]| [first[0] + column / 2, first[1] + row / 2])
    };
    let of_children: BTreeSet<[usize; 2]> = children.iter().flat_map(in_parent).collect();
    let own: BTreeSet<[usize; 2]> = parent.filled.cells().collect();
    let what = "says of other ground than its children that it was filled";
    (own != of_children).then(|| Violation::of_tile(what, parent.address))
}

/// Columns and rows of the cells that a rectangle reaches into, and of those around it.
fn cells_between(low: DVec2, high: DVec2) -> impl Iterator<Item = [usize; 2]> {
    let range = |low: f64, high: f64| {
        let first = (low * CELLS as f64).floor() - 1.0;
        let last = (high * CELLS as f64).floor() + 1.0;
        (first.max(0.0) as usize)..=(last.clamp(-1.0, CELLS as f64 - 1.0) as i64).max(0) as usize
    };
    let columns = range(low.x, high.x);
    range(low.y, high.y).flat_map(move |row| columns.clone().map(move |column| [column, row]))
}
