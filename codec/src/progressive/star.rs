//! What the star of a vertex says about the vertex that is about to be split off it.
//!
//! Everything is arithmetic of IEEE 754 doubles, each operation rounded by itself and in the order that `docs/formats/spm.md`
//! gives, so that every decoder comes to the same bits.

use glam::DVec3;

use super::ring::{Ring, Side, Spoke};

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

/// Reorders the coordinates of a star, so that it is counter-clockwise seen along the last axis.
pub(super) fn turn(ring: &mut Ring) -> Axes {
    let axes = Axes::across(triangles(ring).fold(DVec3::ZERO, |sum, [a, b]| sum + a.cross(b)));
    for spoke in &mut ring.spokes {
        spoke.to = axes.ordered(spoke.to);
    }
    axes
}

/// Spokes that follow each other: the triangles.
fn triangles(ring: &Ring) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    let spokes = &ring.spokes;
    let wrap = ring.is_closed().then(|| [spokes[spokes.len() - 1].to, spokes[0].to]);
    spokes.windows(2).map(|pair| [pair[0].to, pair[1].to]).chain(wrap)
}

/// The edge of the boundary along which the new vertex is split off, if it is.
pub(super) fn along(ring: &Ring, side: Side) -> Option<DVec3> {
    let spoke = match side {
        Side::Front => ring.spokes.first(),
        Side::Back => ring.spokes.last(),
        _ => None,
    };
    spoke.map(|spoke| spoke.to)
}

/// Height of the star's triangles at a place in plan, against the centre's.
pub(super) fn height_at(ring: &Ring, side: Side, place: DVec3) -> f64 {
    if let Some(along) = along(ring, side) {
        let length = along.x * along.x + along.y * along.y;
        let share = (along.x * place.x + along.y * place.y) / length;
        return if length > 0.0 { share * along.z } else { 0.0 };
    }
    let (mut a, mut from_a) = match ring.spokes.last() {
        Some(last) if ring.is_closed() => (last.to, cross(last.to, place)),
        _ => (DVec3::ZERO, f64::NEG_INFINITY),
    };
    for &Spoke { to: b, .. } in &ring.spokes {
        let from_b = cross(b, place);
        if (from_a >= 0.0) & (from_b < 0.0) {
            let area = cross(a, b);
            if area > 0.0 {
                return (from_a * b.z - from_b * a.z) / area;
            }
        }
        (a, from_a) = (b, from_b);
    }
    0.0
}

/// How ill a neighbour is placed to be where the star is cut first, and second: the cotangent of the angle under which it sees
/// the new edge, from where `red` is to where `blue` is, and more where it is on the wrong side.
#[inline]
pub(super) fn misfits(spoke: DVec3, [red, blue]: [DVec3; 2]) -> [f64; 2] {
    let (to_red, to_blue) = (red - spoke, blue - spoke);
    let area = cross(to_red, to_blue);
    let dot = to_red.x * to_blue.x + to_red.y * to_blue.y;
    let (cotangent, wrong) = (dot / area, WRONG_SIDE + dot.abs());
    [
        if area < 0.0 { -cotangent } else { wrong },
        if area > 0.0 { cotangent } else { wrong },
    ]
}

/// More than any cotangent of lattice points.
const WRONG_SIDE: f64 = 1e30;

/// Twice the area in plan of the triangle from the origin over `a` to `b`.
pub(super) fn cross(a: DVec3, b: DVec3) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The nearest whole number, the even one of two; for numbers below 2^51 in size.
pub(super) fn nearest(number: f64) -> f64 {
    const HALVES_ARE_LOST: f64 = 6_755_399_441_055_744.0;
    (number + HALVES_ARE_LOST) - HALVES_ARE_LOST
}
