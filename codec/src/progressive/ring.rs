//! The walk around a vertex, and the places where it may be cut open to split another vertex off.
//!
//! Half-edge `4t + k` starts at the `k`th corner of triangle `t`. A walk is counter-clockwise; on the boundary it begins at the
//! half-edge that has nothing to its right.

use glam::DVec3;

/// Stands for no half-edge.
pub(super) const NONE: u32 = u32::MAX;

pub(super) fn next(edge: u32) -> u32 {
    if edge & 3 == 2 { edge - 2 } else { edge + 1 }
}

pub(super) fn previous(edge: u32) -> u32 {
    if edge & 3 == 0 { edge + 2 } else { edge - 1 }
}

/// Which part of the triangles around a vertex goes over to the vertex that is split off it.
///
/// ```text
///   Inner              Front              Back               Outer
///    b ─── …            b ─── …          ══ a ─── …         ══ a ─── …
///   ╱ ╲   ╱            ╱ ╲   ╱             ╱ ╲   ╱             ╱ ╲   ╱
///  … blue─red         ═ blue═red          red ═ blue ═       … red─blue ═
///   ╲ ╱   ╲                                                     ╲ ╱   ╲
///    a ─── …            ═ boundary                           ══ b ─── …
///
///   HoleFirst          HoleSecond
///    b ─── …            b ─── …
///   ╱ ╲   ╱            ╱ ║   ╱
///  … blue═red         … blue═red
///   ╲ ║   ╲            ╲ ╱   ╲
///    a ─── …            a ─── …
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Side {
    /// Those between two cuts: blue is inside the surface.
    #[default]
    Inner,
    /// Those from the beginning of the walk to a cut: both are on the boundary.
    Front,
    /// Those from a cut to the end of the walk: both are on the boundary.
    Back,
    /// Those before the first cut and after the second: red is inside the surface.
    Outer,
    /// As inner, but at the first cut no triangle is made: a hole of three vertices is there, and both are on the boundary.
    HoleFirst,
    /// The same at the second cut.
    HoleSecond,
}

impl Side {
    /// Those of a vertex on the boundary.
    pub(super) const OF_BOUNDARY: [Self; 4] = [Self::Inner, Self::Front, Self::Back, Self::Outer];

    pub(super) fn has_first_cut(self) -> bool {
        self != Self::Front
    }

    pub(super) fn has_second_cut(self) -> bool {
        self != Self::Back
    }

    pub(super) fn opens_hole(self) -> bool {
        matches!(self, Self::HoleFirst | Self::HoleSecond)
    }
}

/// Where the star of a vertex is cut open: places in the walk around it, the first where blue's triangles begin (red's, if
/// outer), the second where they end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cuts {
    pub(super) side: Side,
    pub(super) first: usize,
    pub(super) second: usize,
}

impl Cuts {
    /// Place of the third vertex of the hole that is opened.
    pub(super) fn hole(self) -> Option<usize> {
        match self.side {
            Side::HoleFirst => Some(self.first),
            Side::HoleSecond => Some(self.second),
            _ => None,
        }
    }
}

/// A neighbour of a vertex, as the walk around that comes to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spoke {
    /// The half-edge to it; none for the last one on the boundary.
    pub(super) edge: u32,
    /// Its number.
    pub(super) vertex: u32,
    /// Where it is, as a difference from the vertex in the middle.
    pub(super) to: DVec3,
}

/// The walk around a vertex.
#[derive(Debug, Default)]
pub(super) struct Ring {
    pub(super) spokes: Vec<Spoke>,
    /// Sum of the neighbours' roughness.
    pub(super) roughness: f64,
    /// Sums of the spokes' coordinates and of their sizes.
    pub(super) sum: DVec3,
    pub(super) sizes: DVec3,
    pub(super) is_open: bool,
}

impl Ring {
    pub(super) fn is_closed(&self) -> bool {
        !self.is_open
    }

    /// The half-edge that leaves the vertex at a place of the walk.
    pub(super) fn edge_at(&self, place: usize) -> u32 {
        self.spokes.get(place).map_or(NONE, |spoke| spoke.edge)
    }

    /// The half-edge back to the vertex, of the triangle before a place of the walk.
    pub(super) fn edge_before(&self, place: usize) -> u32 {
        let before = match place {
            0 if self.is_open => return NONE,
            0 => self.spokes.len() - 1,
            _ => place - 1,
        };
        previous(self.spokes[before].edge)
    }
}

/// Whether cuts leave each vertex at least a triangle of the ring, where it needs one. Where they open a hole, its third vertex has
/// to be inside the surface besides.
pub(super) fn are_possible(cuts: Cuts, ring: &Ring) -> bool {
    let count = ring.spokes.len();
    let in_ring = cuts.first < count && cuts.second < count;
    let is_boundary = !ring.is_closed();
    in_ring
        && match cuts.side {
            Side::Inner | Side::HoleFirst | Side::HoleSecond if !is_boundary => cuts.first != cuts.second,
            Side::HoleFirst | Side::HoleSecond => false,
            Side::Inner | Side::Outer => is_boundary && cuts.first < cuts.second,
            Side::Front | Side::Back => is_boundary,
        }
}
