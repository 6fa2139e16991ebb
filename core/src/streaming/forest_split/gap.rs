//! The gaps that open when a surface is cut along the marked edges, and the trees of triangles that fill them.
//!
//! ```text
//!      c0                c0            Walk along both sides of a tree with the surface on the left: c0 c1 c2 c3. Each
//!      ┃               ╱    ╲          visit of a vertex is a corner of the gap; the first one keeps the vertex, every
//!      ┃      ▶      c1      c3        other has a new vertex. Read backwards, c0 c3 c2 c1, the gap is a polygon to
//!      ┃               ╲    ╱          fill, counter-clockwise.
//!      c2                c2
//! ```
//!
//! The fill is a binary tree: the triangle on the edge from the polygon's last corner to its first has its third corner
//! somewhere between; what is left of it and right of it are polygons again.

use super::surface::ClosedSurface;
use crate::topology::half_edges::next;

/// A corner of a gap: the triangles of the surface that meet there.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GapCorner {
    /// The vertex before the cut.
    pub(super) vertex: u32,
    /// The half-edges that leave it into those triangles; none at a virtual vertex, which is a leaf of every tree.
    pub(super) sector: Vec<u32>,
}

/// Walks around each tree of marked half-edges, in the order of the trees' smallest edges; corners in the order visited.
pub(super) fn gaps(surface: &ClosedSurface, is_marked: &[bool]) -> Vec<Vec<GapCorner>> {
    let mut is_walked = vec![false; surface.half_edge_count()];
    let mut starts: Vec<u32> = (0..surface.half_edge_count() as u32)
        .filter(|&half_edge| is_marked[half_edge as usize] && surface.origin(half_edge) < surface.target(half_edge))
        .collect();
    starts.sort_unstable_by_key(|&half_edge| (surface.origin(half_edge), surface.target(half_edge)));
    let mut gaps = Vec::new();
    for start in starts {
        if !is_walked[start as usize] {
            gaps.push(walk(surface, is_marked, start, &mut is_walked));
        }
    }
    gaps
}

fn walk(surface: &ClosedSurface, is_marked: &[bool], start: u32, is_walked: &mut [bool]) -> Vec<GapCorner> {
    let mut corners = Vec::new();
    let mut half_edge = start;
    loop {
        is_walked[half_edge as usize] = true;
        let vertex = surface.target(half_edge);
        let sector = match surface.is_virtual(vertex) {
            true => Vec::new(),
            false => sector(surface, is_marked, half_edge),
        };
        half_edge = sector.last().copied().unwrap_or(surface.opposite(half_edge));
        corners.push(GapCorner { vertex, sector });
        if half_edge == start {
            corners.rotate_right(1);
            return corners;
        }
    }
}

/// The half-edges that leave the target of `arriving`, up to the next marked one.
fn sector(surface: &ClosedSurface, is_marked: &[bool], arriving: u32) -> Vec<u32> {
    let mut sector = Vec::new();
    for half_edge in surface.fan(next(arriving)) {
        sector.push(half_edge);
        if is_marked[half_edge as usize] {
            break;
        }
    }
    sector
}

/// The gap as the polygon to fill, counter-clockwise.
pub(super) fn polygon<T: Copy>(corners: &[T]) -> Vec<T> {
    let mut polygon = corners.to_vec();
    if let Some((_, rest)) = polygon.split_first_mut() {
        rest.reverse();
    }
    polygon
}

/// A triangle of a fill: whether others follow on its left and on its right edge.
pub(super) type Branches = [bool; 2];

/// The triangles of a fill, as places in its polygon; None where `fill` is no tree of as many triangles as the polygon
/// needs. `fill` has each triangle before those on its left, and those before the ones on its right.
pub(super) fn fill_triangles(polygon_length: usize, fill: &[Branches]) -> Option<Vec<[usize; 3]>> {
    if fill.len() + 2 != polygon_length {
        return None;
    }
    let sizes = subtree_sizes(fill)?;
    let mut triangles = Vec::with_capacity(fill.len());
    let mut edges = vec![(0, polygon_length - 1)];
    for (index, &[left, right]) in fill.iter().enumerate() {
        let (first, last) = edges.pop()?;
        let left_size = if left { sizes[index + 1] } else { 0 };
        let apex = first + 1 + left_size;
        triangles.push([first, apex, last]);
        edges.extend(right.then_some((apex, last)));
        edges.extend(left.then_some((first, apex)));
    }
    Some(triangles)
}

/// How many triangles each subtree has; None where `fill` is not one whole tree.
fn subtree_sizes(fill: &[Branches]) -> Option<Vec<usize>> {
    let mut sizes = vec![1; fill.len()];
    let mut complete: Vec<usize> = Vec::new();
    for (index, branches) in fill.iter().enumerate().rev() {
        for _ in branches.iter().filter(|branch| **branch) {
            sizes[index] += complete.pop()?;
        }
        complete.push(sizes[index]);
    }
    (complete.len() == 1).then_some(sizes)
}

/// The fill of a polygon of which `apex` tells the place of the third corner over the edge from place `last` to place
/// `first`; None where it knows none.
pub(super) fn find_fill(
    polygon_length: usize,
    mut apex: impl FnMut(usize, usize) -> Option<usize>,
) -> Option<Vec<Branches>> {
    let mut fill = Vec::with_capacity(polygon_length.saturating_sub(2));
    let mut edges = vec![(0, polygon_length.checked_sub(1)?)];
    while let Some((first, last)) = edges.pop() {
        if last < first + 2 {
            continue;
        }
        let apex = apex(first, last).filter(|apex| (first + 1..last).contains(apex))?;
        fill.push([apex > first + 1, last > apex + 1]);
        edges.extend([(apex, last), (first, apex)]);
    }
    Some(fill)
}

#[cfg(test)]
#[path = "gap_tests.rs"]
mod tests;
