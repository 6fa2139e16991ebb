//! What the star of a vertex says about the vertex that is about to be split off it.
//!
//! Everything is arithmetic of IEEE 754 doubles, each operation rounded by itself and in the order that `docs/formats/spm.md`
//! gives, so that every decoder comes to the same bits.

use glam::DVec3;

use super::surface::{Cuts, Ring, Side, Surface};

/// The coordinates of a star in the order in which they are coded: two across the surface and the third, its height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Axes([usize; 3]);

impl Axes {
    /// Those of a height field.
    pub(super) const PLAN: Self = Self([0, 1, 2]);

    /// The axis nearest to the normal last, the others so that the surface is counter-clockwise seen from its front.
    fn across(normal: DVec3) -> Self {
        let size = normal.abs();
        let height = if size.z >= size.x && size.z >= size.y {
            2
        } else if size.y >= size.x {
            1
        } else {
            0
        };
        let [first, second] = [(height + 1) % 3, (height + 2) % 3];
        if normal[height] >= 0.0 {
            Self([first, second, height])
        } else {
            Self([second, first, height])
        }
    }

    pub(super) fn ordered(self, position: DVec3) -> DVec3 {
        DVec3::from_array(self.0.map(|axis| position[axis]))
    }

    pub(super) fn restored(self, ordered: DVec3) -> DVec3 {
        let mut position = DVec3::ZERO;
        for (index, axis) in self.0.into_iter().enumerate() {
            position[axis] = ordered[index];
        }
        position
    }
}

/// The neighbours of a vertex, as differences from it.
#[derive(Debug, Default)]
pub(super) struct Star {
    pub(super) spokes: Vec<DVec3>,
    is_closed: bool,
}

impl Star {
    pub(super) fn gather(&mut self, surface: &Surface, vertex: u32, ring: &Ring) {
        let centre = surface.positions[vertex as usize];
        self.is_closed = ring.is_closed();
        self.spokes.clear();
        let spoke = |&neighbour: &u32| surface.positions[neighbour as usize] - centre;
        self.spokes.extend(ring.vertices.iter().map(spoke));
    }

    /// Reorders coordinates, so that the star is counter-clockwise seen along the last axis.
    pub(super) fn turn(&mut self) -> Axes {
        let axes = Axes::across(self.pairs().fold(DVec3::ZERO, |sum, [a, b]| sum + a.cross(b)));
        for spoke in &mut self.spokes {
            *spoke = axes.ordered(*spoke);
        }
        axes
    }

    /// Spokes that follow each other: the triangles.
    fn pairs(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        let wrap = self
            .is_closed
            .then(|| [self.spokes[self.spokes.len() - 1], self.spokes[0]]);
        self.spokes.windows(2).map(|pair| [pair[0], pair[1]]).chain(wrap)
    }

    /// The spokes that tell how far the new vertex may be: all, or that along the boundary.
    pub(super) fn toward(&self, side: Side) -> &[DVec3] {
        match side {
            Side::Front => &self.spokes[..1],
            Side::Back => &self.spokes[self.spokes.len() - 1..],
            Side::Inner | Side::Outer => &self.spokes,
        }
    }

    /// Height of the star's triangles at a place in plan, against the centre's.
    pub(super) fn height_at(&self, side: Side, place: DVec3) -> f64 {
        if let Side::Front | Side::Back = side {
            let along = self.toward(side)[0];
            let length = along.x * along.x + along.y * along.y;
            let share = (along.x * place.x + along.y * place.y) / length;
            return if length > 0.0 { share * along.z } else { 0.0 };
        }
        for [a, b] in self.pairs() {
            let (from_a, to_b) = (cross(a, place), cross(place, b));
            let area = cross(a, b);
            if from_a >= 0.0 && to_b > 0.0 && area > 0.0 {
                return (to_b * a.z + from_a * b.z) / area;
            }
        }
        0.0
    }

    /// How ill a neighbour is placed to be where the star is cut: the cotangent of the angle under which it sees the new edge,
    /// from where `red` is to where `blue` is, and more where it is on the wrong side.
    pub(super) fn misfit(&self, place: usize, [red, blue]: [DVec3; 2], is_second: bool) -> f64 {
        let (to_red, to_blue) = (red - self.spokes[place], blue - self.spokes[place]);
        let area = if is_second {
            cross(to_red, to_blue)
        } else {
            cross(to_blue, to_red)
        };
        let dot = to_red.x * to_blue.x + to_red.y * to_blue.y;
        if area > 0.0 { dot / area } else { WRONG_SIDE + dot.abs() }
    }
}

/// More than any cotangent of lattice points.
const WRONG_SIDE: f64 = 1e30;

/// Twice the area in plan of the triangle from the origin over `a` to `b`.
pub(super) fn cross(a: DVec3, b: DVec3) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Whether a place in the ring can be the cut that is asked for, given the first that was told.
pub(super) fn is_candidate(cuts: Cuts, place: usize, is_closed: bool) -> bool {
    match cuts.side {
        Side::Inner if is_closed => place != cuts.first,
        Side::Inner | Side::Outer => place > cuts.first,
        Side::Front | Side::Back => true,
    }
}
