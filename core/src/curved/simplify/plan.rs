//! What a removal does to the patches on a side of a mergeable pair, as affine maps of their domains.
//!
//! ```text
//!        p ──── q                 two faces:    T
//!       ╱ ╲    ╱ ╲                three faces:  one of V–p and V–q swapped, then T (Fig. 8)
//!      ╱   ╲  ╱   ╲                             p or q removed, too: 2T
//!     b ◀── ╲╱ ── a  of V                       both, with the face beyond p–q: T-in-T
//! ```
//! A side is swept counter-clockwise, from `a` to `b`. Its faces are (V, a, p), (V, p, q) and (V, q, b); the half-edges that
//! leave V name them. The merged patch is (b, a, x), with x across.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::cover::{Cell, Cover, Map};
use super::shared_curves::CurveUse;

const X: DVec3 = DVec3::X;
const Y: DVec3 = DVec3::Y;
const Z: DVec3 = DVec3::Z;

/// What is decided of a vertex, for one iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tag {
    Undecided,
    Retained,
    Removed,
}

/// What is removed, merged and decided together.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// Vertices that go, and a neighbour that stays, along each one's pair.
    pub(super) removed: SmallVec<[(u32, u32); 4]>,
    pub(super) sides: Vec<Side>,
    pub(super) curves: SmallVec<[NewCurve; 6]>,
    pub(super) tags: SmallVec<[(u32, Tag); 16]>,
    /// The largest deviation of a curve, of those that were given up, too.
    pub(super) deviation: f64,
}

/// A curve that arises.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewCurve {
    pub(super) ends: [u32; 2],
    pub(super) inner: [DVec3; 2],
    pub(super) is_crease: bool,
}

/// Faces, and what they become.
#[derive(Clone, Debug)]
pub(super) struct Side {
    /// The faces' places.
    pub(super) slots: SmallVec<[u32; 4]>,
    /// Where each face goes, in the order of its own corners.
    pub(super) cells: SmallVec<[Cell; 4]>,
    pub(super) targets: SmallVec<[Target; 2]>,
    /// The half-edge that is turned first.
    pub(super) flip: Option<u32>,
}

/// A patch that is to be: its corners, and its curves from each to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub(super) corners: [u32; 3],
    pub(super) curves: [CurveUse; 3],
}

/// What a target became.
#[derive(Clone, Debug)]
pub(super) struct Made {
    pub(super) centre: DVec3,
    pub(super) error: f64,
    pub(super) cover: Cover,
}

/// How long a plan was, to go back to.
pub(super) struct Mark([usize; 4]);

impl Plan {
    pub(super) fn mark(&self) -> Mark {
        Mark([self.removed.len(), self.sides.len(), self.curves.len(), self.tags.len()])
    }

    pub(super) fn back_to(&mut self, &Mark([removed, sides, curves, tags]): &Mark) {
        self.removed.truncate(removed);
        self.sides.truncate(sides);
        self.curves.truncate(curves);
        self.tags.truncate(tags);
    }

    pub(super) fn takes(&self, slot: u32) -> bool {
        self.sides.iter().any(|side| side.slots.contains(&slot))
    }

    pub(super) fn joins(&self, a: u32, b: u32) -> bool {
        self.curves
            .iter()
            .any(|curve| curve.ends == [a, b] || curve.ends == [b, a])
    }
}

/// A vertex on a curve that arises: the curve's direction of use, and where on it, from its start to its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct On {
    pub(super) curve: CurveUse,
    pub(super) t: f64,
}

impl On {
    /// The same from the curve's other end.
    pub(super) fn reversed(self) -> Self {
        Self {
            curve: self.curve.reversed(),
            t: 1.0 - self.t,
        }
    }
}

/// A swapped diagonal: where it crosses the old one, from that one's start, and the new one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) t: f64,
    pub(super) new: On,
}

/// A side while its cells are put together.
pub(super) struct SideOf {
    /// Half-edges that leave V, one a face.
    pub(super) faces: SmallVec<[u32; 3]>,
    /// The curve of each face across from V.
    pub(super) opposite: SmallVec<[CurveUse; 3]>,
    /// V on the curve from a to b.
    pub(super) middle: On,
    pub(super) ends: [u32; 2],
}

impl SideOf {
    fn v(&self) -> DVec3 {
        Y.lerp(X, self.middle.t)
    }

    fn merged(&self, x: u32, [to_x, from_x]: [CurveUse; 2]) -> Target {
        let [a, b] = self.ends;
        Target {
            corners: [b, a, x],
            curves: [self.middle.curve.reversed(), to_x, from_x],
        }
    }

    fn whole(&self, images: &[[DVec3; 3]], target: Target) -> Side {
        let cells = self.faces.iter().zip(images);
        Side {
            slots: self.faces.iter().map(|edge| edge / 3).collect(),
            cells: cells.map(|(&edge, &images)| whole(edge, 0, images)).collect(),
            targets: smallvec![target],
            flip: None,
        }
    }

    /// Faces (V, a, x) and (V, x, b).
    pub(super) fn t(&self, x: u32) -> Side {
        let target = self.merged(x, [self.opposite[0], self.opposite[1]]);
        self.whole(&[[self.v(), Y, Z], [self.v(), Z, X]], target)
    }

    /// p goes, too, on the curve from a to q.
    pub(super) fn two_t_first(&self, q: u32, p_on: On) -> Side {
        let p = Y.lerp(Z, p_on.t);
        let target = self.merged(q, [p_on.curve, self.opposite[2]]);
        self.whole(&[[self.v(), Y, p], [self.v(), p, Z], [self.v(), Z, X]], target)
    }

    /// q goes, too, on the curve from p to b.
    pub(super) fn two_t_second(&self, p: u32, q_on: On) -> Side {
        let q = Z.lerp(X, q_on.t);
        let target = self.merged(p, [self.opposite[0], q_on.curve]);
        self.whole(&[[self.v(), Y, Z], [self.v(), Z, q], [self.v(), q, X]], target)
    }

    /// p on the curve from a to x and q on that from x to b go, too; `beyond` runs from q to p in the face (q, p, x).
    pub(super) fn triangle_in_triangle(&self, x: u32, [p_on, q_on]: [On; 2], beyond: u32) -> Side {
        let [p, q] = [Y.lerp(Z, p_on.t), Z.lerp(X, q_on.t)];
        let target = self.merged(x, [p_on.curve, q_on.curve]);
        let mut side = self.whole(&[[self.v(), Y, p], [self.v(), p, q], [self.v(), q, X]], target);
        side.slots.push(beyond / 3);
        side.cells.push(whole(beyond, 0, [q, p, Z]));
        side
    }

    /// V–p becomes a–q, and then T.
    pub(super) fn swap_near(&self, [p, q]: [u32; 2], diagonal: &Crossing) -> Side {
        let (v, s) = (self.v(), diagonal.new.t);
        let (inner, outer) = (Y.lerp(Z, s), X.lerp(Z, s));
        let [a, _] = self.ends;
        let [first, second, third] = [self.faces[0], self.faces[1], self.faces[2]];
        Side {
            slots: self.faces.iter().map(|edge| edge / 3).collect(),
            cells: smallvec![
                cut(first, [0, 2], diagonal.t, [(0, [v, inner, Y]), (1, [Y, outer, X])]),
                cut(second, [0, 1], diagonal.t, [(0, [v, inner, Z]), (1, [Y, outer, Z])]),
                whole(third, 0, [v, Z, X]),
            ],
            targets: smallvec![
                self.merged(q, [diagonal.new.curve, self.opposite[2]]),
                Target {
                    corners: [a, p, q],
                    curves: [self.opposite[0], self.opposite[1], diagonal.new.curve.reversed()],
                },
            ],
            flip: Some(second),
        }
    }

    /// V–q becomes p–b, and then T.
    pub(super) fn swap_far(&self, [p, q]: [u32; 2], diagonal: &Crossing) -> Side {
        let (v, s) = (self.v(), diagonal.new.t);
        let (inner, outer) = (Z.lerp(X, s), X.lerp(Z, s));
        let [_, b] = self.ends;
        let [first, second, third] = [self.faces[0], self.faces[1], self.faces[2]];
        Side {
            slots: self.faces.iter().map(|edge| edge / 3).collect(),
            cells: smallvec![
                whole(first, 0, [v, Y, Z]),
                cut(second, [0, 2], diagonal.t, [(0, [v, inner, Z]), (1, [Y, outer, X])]),
                cut(third, [0, 1], diagonal.t, [(0, [v, inner, X]), (1, [Y, outer, Z])]),
            ],
            targets: smallvec![
                self.merged(p, [self.opposite[0], diagonal.new.curve]),
                Target {
                    corners: [p, q, b],
                    curves: [self.opposite[1], self.opposite[2], diagonal.new.curve.reversed()],
                },
            ],
            flip: Some(third),
        }
    }
}

/// Faces (V, a, b), (V, b, c) and (V, c, a) as (a, b, c), with V at barycentric coordinates `at`.
pub(super) fn star(faces: [u32; 3], corners: [u32; 3], curves: [CurveUse; 3], at: DVec3) -> Side {
    let images = [[at, X, Y], [at, Y, Z], [at, Z, X]];
    let cells = faces.into_iter().zip(images);
    Side {
        slots: faces.iter().map(|edge| edge / 3).collect(),
        cells: cells.map(|(edge, images)| whole(edge, 0, images)).collect(),
        targets: smallvec![Target { corners, curves }],
        flip: None,
    }
}

/// Faces (E0, E1, F0) and (E1, E0, F1) as (F0, E0, F1) and (F1, E1, F0); `edge` and `twin` run along the old diagonal, the new
/// one from F0 to F1. `sides` are the curves F0–E0, E0–F1, F1–E1 and E1–F0.
pub(super) fn swap(
    [edge, twin]: [u32; 2],
    [e0, e1, f0, f1]: [u32; 4],
    sides: [CurveUse; 4],
    diagonal: &Crossing,
) -> Side {
    let s = diagonal.new.t;
    let (first, second) = (X.lerp(Z, s), Z.lerp(X, s));
    let new = diagonal.new.curve;
    Side {
        slots: smallvec![edge / 3, twin / 3],
        cells: smallvec![
            cut(edge, [0, 1], diagonal.t, [(0, [Y, first, X]), (1, [Y, second, Z])]),
            cut(
                twin,
                [0, 1],
                1.0 - diagonal.t,
                [(1, [Y, second, X]), (0, [Y, first, Z])]
            ),
        ],
        targets: smallvec![
            Target {
                corners: [f0, e0, f1],
                curves: [sides[0], sides[1], new.reversed()],
            },
            Target {
                corners: [f1, e1, f0],
                curves: [sides[2], sides[3], new],
            },
        ],
        flip: Some(edge),
    }
}

/// A face goes to one patch; `images` of its corners, from the start of `edge` on.
fn whole(edge: u32, target: usize, images: [DVec3; 3]) -> Cell {
    Cell::Whole(Map {
        target,
        images: in_order_of_face(edge, images),
    })
}

/// A face is cut from the point S at `t` between two corners, counted from the start of `edge`, to the third. For each end:
/// the target, and the images there of the end, of S and of the third corner.
fn cut(edge: u32, [i, j]: [usize; 2], t: f64, parts: [(usize, [DVec3; 3]); 2]) -> Cell {
    let k = 3 - i - j;
    let [near, far] = parts;
    // The map that takes S to its image takes the other end so far beyond it.
    let map = |(target, [end, s, third]): (usize, [DVec3; 3]), own: usize, other: usize, share: f64| {
        let mut images = [DVec3::ZERO; 3];
        images[own] = end;
        images[other] = (s - (1.0 - share) * end) / share;
        images[k] = third;
        Map {
            target,
            images: in_order_of_face(edge, images),
        }
    };
    let turn = edge as usize % 3;
    Cell::Cut {
        ends: [(i + turn) % 3, (j + turn) % 3],
        t,
        maps: [map(near, i, j, t), map(far, j, i, 1.0 - t)],
    }
}

/// Images of corners counted from the start of a half-edge, in the order of its face's own corners.
fn in_order_of_face(edge: u32, images: [DVec3; 3]) -> [DVec3; 3] {
    let turn = edge as usize % 3;
    [0, 1, 2].map(|corner| images[(corner + 3 - turn) % 3])
}
