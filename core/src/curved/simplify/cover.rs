//! What a patch stands for: pieces of the model, each over a triangle of the patch's domain.
//!
//! ```text
//!        C                    every merge maps domains affinely, so that a piece stays a triangle;
//!       ╱│╲                   where a swapped diagonal runs through a piece, the piece is cut;
//!      ╱ │ ╲                  then corners of pieces slide to where the new patch is nearest to them
//!     ╱ ╱ ╲ ╲
//!    ╱╱     ╲╲                error of a patch: over all its pieces, the largest distance of a control point of the piece
//!   A─────────B               from that of the patch's own part over the same triangle
//! ```
//! Pieces and parts with the same coordinates correspond, so that no point of a piece is farther from the patch than the error,
//! by the convex hull of differences. Nor is one of the patch from the pieces, since these cover its domain whatever their corners
//! do: corners on a side stay on it, the patch's own corners stay where they are, and a corner that pieces share has one place. The
//! map from the pieces to the domain is therefore continuous and takes the border once round the border, so that it leaves no point
//! out (its degree is 1). Nothing is summed up from level to level.

use std::collections::HashMap;

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use crate::curved::patch::{CENTRE, CubicPatch};

/// Coordinates nearer to a line are on it.
const ON_LINE: f64 = 1e-12;

/// A part of the model that is curved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) points: CubicPatch,
    /// How far it is from the model itself.
    pub(super) error: f64,
}

/// A piece that is the flat triangle between its corners is no part of those that are kept.
pub(super) const FLAT: u32 = u32::MAX;

/// All parts of the model that ever were a piece, and where corners of pieces are.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) curved: Vec<Part>,
    pub(super) corners: Vec<DVec3>,
}

impl Parts {
    pub(super) fn counts(&self) -> [usize; 2] {
        [self.curved.len(), self.corners.len()]
    }

    pub(super) fn truncate(&mut self, [curved, corners]: [usize; 2]) {
        self.curved.truncate(curved);
        self.corners.truncate(corners);
    }

    /// The centre of a part with three corners.
    pub(super) fn centre(&self, part: u32, corners: [DVec3; 3]) -> DVec3 {
        match part {
            FLAT => corners.into_iter().sum::<DVec3>() / 3.0,
            curved => self.curved[curved as usize].points.points[CENTRE],
        }
    }

    /// The part's control points, and how far it is from the model.
    pub(super) fn part(&self, part: u32, corners: [DVec3; 3]) -> Part {
        match part {
            FLAT => Part {
                points: CubicPatch::flat_between(corners),
                error: 0.0,
            },
            curved => self.curved[curved as usize],
        }
    }

    /// The part over a triangle in the coordinates of another one.
    fn cut(&mut self, part: u32, corners: [DVec3; 3]) -> u32 {
        if part == FLAT {
            return FLAT;
        }
        let Part { points, error } = self.curved[part as usize];
        self.curved.push(Part {
            points: points.part(corners),
            error,
        });
        self.curved.len() as u32 - 1
    }
}

/// A corner of pieces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its number among all corners.
    pub(super) corner: u32,
    /// Where it is in the domain of the patch, barycentric.
    pub(super) at: DVec3,
}

/// A part of the model where a patch stands for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Its number among curved parts, or [`FLAT`].
    pub(super) part: u32,
    /// Its corners among the places.
    pub(super) places: [u32; 3],
}

/// Pieces over all of a patch's domain.
#[derive(Clone, Debug, Default)]
pub(super) struct Cover {
    pub(super) places: Vec<Place>,
    pub(super) pieces: Vec<Piece>,
}

/// An affine map of a face's domain into that of a new patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Map {
    /// The new patch, as its side counts them.
    pub(super) target: usize,
    /// Where the corners of the face go, in the order of the face.
    pub(super) images: [DVec3; 3],
}

impl Map {
    fn apply(&self, at: DVec3) -> DVec3 {
        let image = at.x * self.images[0] + at.y * self.images[1] + at.z * self.images[2];
        // What is as good as on a side is on it.
        image.map(|coordinate| if coordinate.abs() <= ON_LINE { 0.0 } else { coordinate })
    }
}

/// Where a face goes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cell {
    /// To one patch.
    Whole(Map),
    /// To two: it is cut from the point at `t` between the corners `ends` to the third corner.
    Cut {
        ends: [usize; 2],
        t: f64,
        /// For the part at each of the ends.
        maps: [Map; 2],
    },
}

impl Cell {
    /// Which new patch a place of a face goes to, and where in it.
    pub(super) fn image(&self, at: DVec3) -> (usize, DVec3) {
        let map = match self {
            Self::Whole(map) => map,
            Self::Cut { ends, t, maps } => &maps[usize::from(at[ends[1]] * (1.0 - t) > at[ends[0]] * t)],
        };
        (map.target, map.apply(at))
    }
}

impl Cover {
    /// One part is all of a patch.
    pub(super) fn whole(part: u32, corners: [u32; 3]) -> Self {
        let ats = [DVec3::X, DVec3::Y, DVec3::Z];
        Self {
            places: corners
                .into_iter()
                .zip(ats)
                .map(|(corner, at)| Place { corner, at })
                .collect(),
            pieces: vec![Piece {
                part,
                places: [0, 1, 2],
            }],
        }
    }
}

/// Puts covers of new patches together from those of faces.
#[derive(Debug, Default)]
pub(super) struct Carrier {
    /// For each corner, and each of two covers: when it was last put there, and which place it got.
    seen: Vec<[Seen; 2]>,
    now: u32,
    /// Corners that arose between two others.
    between: HashMap<[u32; 2], u32>,
    /// For each place of a face: where it went, or how far it is beyond the cut.
    went: Vec<u32>,
    beyond: Vec<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    when: u32,
    place: u32,
}

/// A corner of a piece that is cut, in the piece's own coordinates and in those of the face.
#[derive(Clone, Copy, Debug)]
struct Corner {
    number: u32,
    own: DVec3,
    at: DVec3,
    is_on_cut: bool,
}

impl Carrier {
    /// The covers of `count` new patches from faces, and where these go.
    pub(super) fn carried<'a>(
        &mut self,
        faces: impl Iterator<Item = (&'a Cover, &'a Cell)> + Clone,
        count: usize,
        parts: &mut Parts,
    ) -> SmallVec<[Cover; 2]> {
        self.now += 1;
        self.between.clear();
        let most = faces.clone().map(|(face, _)| face.pieces.len()).sum();
        let empty = |_| Cover {
            places: Vec::with_capacity(most),
            pieces: Vec::with_capacity(most),
        };
        let mut covers: SmallVec<[Cover; 2]> = (0..count).map(empty).collect();
        for (face, cell) in faces {
            match cell {
                Cell::Whole(map) => self.carry_whole(face, map, parts, &mut covers[map.target]),
                Cell::Cut { ends, t, maps } => self.carry_cut(face, *ends, *t, maps, parts, &mut covers),
            }
        }
        covers
    }

    fn carry_whole(&mut self, face: &Cover, map: &Map, parts: &Parts, cover: &mut Cover) {
        let mut went = std::mem::take(&mut self.went);
        went.clear();
        for place in &face.places {
            went.push(self.put(place.corner, map.target, parts, cover, || map.apply(place.at)));
        }
        cover.pieces.extend(face.pieces.iter().map(|piece| Piece {
            part: piece.part,
            places: piece.places.map(|place| went[place as usize]),
        }));
        self.went = went;
    }

    /// The place that a corner has in a cover, or gets there.
    fn put(&mut self, corner: u32, target: usize, parts: &Parts, cover: &mut Cover, at: impl FnOnce() -> DVec3) -> u32 {
        if self.seen.len() < parts.corners.len() {
            self.seen.resize(parts.corners.len(), [Seen::default(); 2]);
        }
        let seen = &mut self.seen[corner as usize][target];
        if seen.when != self.now {
            *seen = Seen {
                when: self.now,
                place: cover.places.len() as u32,
            };
            cover.places.push(Place { corner, at: at() });
        }
        seen.place
    }

    fn carry_cut(
        &mut self,
        face: &Cover,
        ends: [usize; 2],
        t: f64,
        maps: &[Map; 2],
        parts: &mut Parts,
        covers: &mut [Cover],
    ) {
        let mut beyond = std::mem::take(&mut self.beyond);
        beyond.clear();
        beyond.extend(face.places.iter().map(|place| {
            let far = place.at[ends[1]] * (1.0 - t) - place.at[ends[0]] * t;
            if far.abs() <= ON_LINE { 0.0 } else { far }
        }));
        for piece in &face.pieces {
            let far = piece.places.map(|place| beyond[place as usize]);
            let owns = [DVec3::X, DVec3::Y, DVec3::Z];
            let corners = [0, 1, 2].map(|index| {
                let place = face.places[piece.places[index] as usize];
                Corner {
                    number: place.corner,
                    own: owns[index],
                    at: place.at,
                    is_on_cut: far[index] == 0.0,
                }
            });
            let is_near = far.iter().all(|&far| far <= 0.0);
            if is_near || far.iter().all(|&far| far >= 0.0) {
                self.push(corners, &maps[usize::from(!is_near)], piece.part, parts, covers);
                continue;
            }
            for (triangle, is_far) in self.cut(corners, far, piece.part, parts) {
                let part = parts.cut(piece.part, triangle.map(|corner| corner.own));
                self.push(triangle, &maps[usize::from(is_far)], part, parts, covers);
            }
        }
        self.beyond = beyond;
    }

    fn push(&mut self, corners: [Corner; 3], map: &Map, part: u32, parts: &Parts, covers: &mut [Cover]) {
        let cover = &mut covers[map.target];
        let places = corners.map(|corner| {
            let at = || {
                let image = map.apply(corner.at);
                if corner.is_on_cut { onto_side(image) } else { image }
            };
            self.put(corner.number, map.target, parts, cover, at)
        });
        cover.pieces.push(Piece { part, places });
    }

    /// Cuts a piece where `far` changes its sign, given at its corners: triangles, and whether they are beyond the cut.
    fn cut(
        &mut self,
        corners: [Corner; 3],
        far: [f64; 3],
        part: u32,
        parts: &mut Parts,
    ) -> SmallVec<[([Corner; 3], bool); 3]> {
        let mut crossing = |i: usize, j: usize| {
            let share = far[i] / (far[i] - far[j]);
            self.between([corners[i], corners[j]], share, part, parts)
        };
        if let Some(on) = far.iter().position(|&far| far == 0.0) {
            let (i, j) = ((on + 1) % 3, (on + 2) % 3);
            let middle = crossing(i, j);
            return smallvec![
                ([corners[on], corners[i], middle], far[i] > 0.0),
                ([corners[on], middle, corners[j]], far[j] > 0.0),
            ];
        }
        let is_lone = |i: &usize| {
            let is_far = |place: usize| far[place % 3] > 0.0;
            is_far(*i) != is_far(i + 1) && is_far(*i) != is_far(i + 2)
        };
        let lone = (0..3)
            .find(is_lone)
            .expect("of three signs that are not the same, one is alone");
        let (i, j) = ((lone + 1) % 3, (lone + 2) % 3);
        let [to_i, to_j] = [crossing(lone, i), crossing(lone, j)];
        smallvec![
            ([corners[lone], to_i, to_j], far[lone] > 0.0),
            ([to_i, corners[i], corners[j]], far[i] > 0.0),
            ([to_i, corners[j], to_j], far[i] > 0.0),
        ]
    }

    /// The corner where the cut crosses a side of a piece; the piece on the other side has the same.
    fn between(&mut self, [from, to]: [Corner; 2], share: f64, part: u32, parts: &mut Parts) -> Corner {
        let own = from.own.lerp(to.own, share);
        let key = [from.number.min(to.number), from.number.max(to.number)];
        let number = *self.between.entry(key).or_insert_with(|| {
            let ends = [from, to].map(|corner| parts.corners[corner.number as usize]);
            let point = match part {
                FLAT => ends[0].lerp(ends[1], share),
                curved => parts.curved[curved as usize].points.point(own),
            };
            parts.corners.push(point);
            parts.corners.len() as u32 - 1
        });
        Corner {
            number,
            own,
            at: from.at.lerp(to.at, share),
            is_on_cut: true,
        }
    }
}

/// A place as good as on a side, on it.
fn onto_side(at: DVec3) -> DVec3 {
    let least = at.abs().min_element();
    at.map(|coordinate| if coordinate.abs() == least { 0.0 } else { coordinate })
}
