//! The sides of a tile, as the tiles around measured them: where data end at a side, the tile across has the same points there.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::EXTENT;
use super::measured::{Measured, Place, Point, seen_at};

/// What tiles beside one measured on its sides.
#[derive(Default)]
pub(super) struct Sides {
    pub(super) points: Vec<Point>,
    /// The parts of sides along which they end.
    edges: Vec<[Place; 2]>,
    /// Ends of edges along sides, these or others at its corners, that are measured in one tile and not in the tile across: both have
    /// these at the data's height, though ground be elsewhere.
    raised: HashSet<Place>,
}

impl Sides {
    pub(super) fn new(own: &Measured, beside: &[([i64; 2], Measured)]) -> Self {
        let inside = |along: i64| u16::try_from(along).ok().filter(|&along| along <= EXTENT);
        let is_on_side = |place: &Place| place.iter().any(|&along| along == 0 || along == i64::from(EXTENT));
        let points = beside.iter().flat_map(|(offset, tile)| {
            let places = tile.points.iter().map(|&point| (point, seen_at(*offset, point)));
            let on_side = places.filter(|(_, place)| is_on_side(place));
            on_side.filter_map(|(point, [u, v])| {
                let (u, v) = (inside(u)?, inside(v)?);
                Some(Point { u, v, ..point })
            })
        });
        let edges: Vec<[Place; 2]> = beside
            .iter()
            .flat_map(|(offset, tile)| tile.edges_along_sides(*offset))
            .collect();
        let mut measured: HashMap<[Place; 2], u32> = HashMap::new();
        for [a, b] in edges.iter().copied().chain(own.edges_along_sides([0; 2])) {
            *measured.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
        let of_one = measured.iter().filter(|&(_, &tiles)| tiles == 1);
        Self {
            points: points.collect(),
            edges,
            raised: of_one.flat_map(|(edge, _)| *edge).collect(),
        }
    }

    pub(super) fn has_edge_at(&self, [u, v]: [u16; 2]) -> bool {
        let place = [i64::from(u), i64::from(v)];
        let is_between = |a: i64, at: i64, b: i64| a.min(b) <= at && at <= a.max(b);
        let is_at = |[a, b]: &[Place; 2]| (0..2).all(|axis| is_between(a[axis], place[axis], b[axis]));
        self.edges.iter().any(is_at)
    }

    /// Places so far inwards from points on sides that are at the data's height: there the slope from these down to the ground ends.
    pub(super) fn feet_of_slopes(&self, inwards: u16) -> BTreeSet<[u16; 2]> {
        let within = |place: &Place| -> Option<[u16; 2]> {
            let [u, v] = place.map(|along| u16::try_from(along).ok().filter(|&along| along <= EXTENT));
            Some([u?, v?])
        };
        let moved = |along: u16| match along {
            0 => inwards,
            EXTENT => EXTENT - inwards,
            between => between,
        };
        let raised = self.raised.iter().filter_map(within);
        raised.map(|place| place.map(moved)).collect()
    }

    pub(super) fn is_raised(&self, point: Point) -> bool {
        self.raised.contains(&seen_at([0; 2], point))
    }
}
