//! The triangle next to a point, by a binary tree of boxes in one flat array.
//!
//! ```text
//! boxes    ┌ all ┬ left half ┬ … ┬ right half ┬ … ┐     a node, all of its left child, all of its right child
//! facets   └ in the order of the leaves ──────────┘     so that neighbours in the array are neighbours in space
//! ```

use std::ops::Range;

use glam::DVec3;

use crate::space::distance::{squared_to_box, squared_to_triangle};

/// A triangle's corners.
pub(crate) type Facet = [DVec3; 3];

/// Facets of a leaf, at most.
const LEAF: usize = 4;

/// Triangles and boxes around them.
pub(crate) struct FacetTree {
    facets: Vec<Facet>,
    nodes: Vec<Node>,
}

/// A box around facets that follow each other.
#[derive(Clone)]
struct Node {
    low: DVec3,
    high: DVec3,
    facets: Range<u32>,
    /// The right child; the left one is the next node. None in a leaf.
    right: Option<u32>,
}

/// A facet and how far it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    pub(crate) facet: u32,
    pub(crate) squared: f64,
}

impl FacetTree {
    /// The facets, and the place among `facets` of each.
    pub(crate) fn new(facets: &[Facet]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..).take(facets.len()).collect();
        let mut nodes = Vec::with_capacity(facets.len());
        let middles: Vec<DVec3> = facets.iter().map(|&[a, b, c]| a + b + c).collect();
        if !facets.is_empty() {
            add_nodes(facets, &middles, &mut order, 0, &mut nodes);
        }
        let facets = order.iter().map(|&facet| facets[facet as usize]).collect();
        (Self { facets, nodes }, order)
    }

    pub(crate) fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// The facet next to `point`, or the first found at most `enough`, squared, away; `expected` is looked at before all
    /// others. None where there is no facet.
    pub(crate) fn nearest(&self, point: DVec3, expected: u32, enough: f64) -> Option<Nearest> {
        let facet = self.facets.get(expected as usize).map_or(0, |_| expected);
        let squared = squared_to_triangle(point, *self.facets.get(facet as usize)?);
        let mut nearest = Nearest { facet, squared };
        self.look(0, point, enough, &mut nearest);
        Some(nearest)
    }

    fn look(&self, node: usize, point: DVec3, enough: f64, nearest: &mut Nearest) {
        let Node { facets, right, .. } = &self.nodes[node];
        let Some(right) = *right else {
            return self.look_at(facets, point, nearest);
        };
        let mut children = [node + 1, right as usize].map(|child| (self.nodes[child].squared_distance(point), child));
        if children[1].0 < children[0].0 {
            children.swap(0, 1);
        }
        for (squared, child) in children {
            if squared < nearest.squared && nearest.squared > enough {
                self.look(child, point, enough, nearest);
            }
        }
    }

    fn look_at(&self, facets: &Range<u32>, point: DVec3, nearest: &mut Nearest) {
        for facet in facets.clone() {
            let corners = self.facets[facet as usize];
            if squared_to_box(point, corners) < nearest.squared {
                let squared = squared_to_triangle(point, corners);
                if squared < nearest.squared {
                    *nearest = Nearest { facet, squared };
                }
            }
        }
    }
}

impl Node {
    fn squared_distance(&self, point: DVec3) -> f64 {
        (self.low - point)
            .max(point - self.high)
            .max(DVec3::ZERO)
            .length_squared()
    }
}

/// Adds the node of the facets of `order`, which follow `first` others, and all below it.
fn add_nodes(facets: &[Facet], middles: &[DVec3], order: &mut [u32], first: u32, nodes: &mut Vec<Node>) {
    let corners = order.iter().flat_map(|&facet| facets[facet as usize]);
    let (low, high) = bounds(corners);
    let node = nodes.len();
    nodes.push(Node {
        low,
        high,
        facets: first..first + order.len() as u32,
        right: None,
    });
    if order.len() <= LEAF {
        return;
    }
    let (low, high) = bounds(order.iter().map(|&facet| middles[facet as usize]));
    let axis = (high - low).max_position();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&one, &other| {
        let along = |facet: u32| middles[facet as usize][axis];
        along(one).total_cmp(&along(other)).then(one.cmp(&other))
    });
    let (left, right) = order.split_at_mut(half);
    add_nodes(facets, middles, left, first, nodes);
    nodes[node].right = Some(nodes.len() as u32);
    add_nodes(facets, middles, right, first + half as u32, nodes);
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.fold(nowhere, |(low, high), point| (low.min(point), high.max(point)))
}

#[cfg(test)]
#[path = "facet_tree_tests.rs"]
mod tests;
