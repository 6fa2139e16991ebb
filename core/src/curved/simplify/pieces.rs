//! What a patch stands for: pieces of the model's own patches, each with the triangle of the patch's domain that it lies over.
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
//! do: corners on a side stay on it, the patch's own corners stay where they are, and what several pieces have in common slides
//! as one. The map from the pieces to the domain is therefore continuous and takes the border once round the border, so that it
//! leaves no point out (its degree is 1). Nothing is summed up from level to level.

use glam::DVec3;

use crate::curved::patch::{CENTRE, CORNERS, CubicPatch};

/// Coordinates nearer to a line are on it.
const ON_LINE: f64 = 1e-12;

/// Corners of pieces that are not on a side of the domain keep so far away from it.
const INSIDE: f64 = 1e-6;

/// How much of its own square is added to the steepness along which corners slide, so that they go nowhere far where a patch is
/// degenerate.
const DAMPING: f64 = 1e-4;

/// A part of one of the model's patches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) points: CubicPatch,
    /// How far it is from the model itself.
    pub(super) error: f64,
}

/// A part of the model where a patch stands for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Its number among all parts.
    pub(super) part: u32,
    /// Its corners in the domain of the patch that stands for it, barycentric.
    pub(super) at: [DVec3; 3],
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
        at.x * self.images[0] + at.y * self.images[1] + at.z * self.images[2]
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

impl Piece {
    /// A part that is all of a patch.
    pub(super) fn whole(part: u32) -> Self {
        Self {
            part,
            at: [DVec3::X, DVec3::Y, DVec3::Z],
        }
    }

    fn mapped(&self, map: &Map) -> Self {
        Self {
            at: self.at.map(|at| snapped(map.apply(at))),
            ..*self
        }
    }

    /// The piece over a triangle in the piece's own coordinates; its part is added to the others.
    fn cut(&self, corners: [DVec3; 3], parts: &mut Vec<Part>) -> Self {
        let given = &parts[self.part as usize];
        let part = Part {
            points: given.points.part(corners),
            error: given.error,
        };
        parts.push(part);
        let at = |local: DVec3| local.x * self.at[0] + local.y * self.at[1] + local.z * self.at[2];
        Self {
            part: parts.len() as u32 - 1,
            at: corners.map(at),
        }
    }
}

/// What is as good as on a side is on it.
fn snapped(at: DVec3) -> DVec3 {
    at.map(|coordinate| if coordinate.abs() <= ON_LINE { 0.0 } else { coordinate })
}

impl Cell {
    /// Adds a face's piece, or what it is cut into, to the pieces of the new patches.
    pub(super) fn carry(&self, piece: &Piece, parts: &mut Vec<Part>, targets: &mut [Vec<Piece>]) {
        match self {
            Self::Whole(map) => targets[map.target].push(piece.mapped(map)),
            Self::Cut { ends, t, maps } => {
                let beyond = piece.at.map(|at| at[ends[1]] * (1.0 - t) - at[ends[0]] * t);
                cut(piece, beyond, parts, |part, is_far| {
                    let map = &maps[usize::from(is_far)];
                    targets[map.target].push(part.mapped(map));
                });
            }
        }
    }
}

impl Cell {
    /// Which new patch a place of a face goes to, and where in it.
    fn image(&self, at: DVec3) -> (usize, DVec3) {
        let map = match self {
            Self::Whole(map) => map,
            Self::Cut { ends, t, maps } => &maps[usize::from(at[ends[1]] * (1.0 - t) > at[ends[0]] * t)],
        };
        (map.target, snapped(map.apply(at)))
    }
}

/// Places of a patch where it is compared before its pieces are.
const SAMPLES: [DVec3; 7] = [
    DVec3::new(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0),
    DVec3::new(0.5, 0.5, 0.0),
    DVec3::new(0.0, 0.5, 0.5),
    DVec3::new(0.5, 0.0, 0.5),
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
];

/// Points of the surface as it is, with where they go.
pub(super) fn samples(face: &CubicPatch, cell: &Cell, samples: &mut [Vec<(DVec3, DVec3)>]) {
    for at in SAMPLES {
        let (target, place) = cell.image(at);
        samples[target].push((face.point(at), place));
    }
}

/// How far a patch, given without its centre, is from samples, more or less.
pub(super) fn rough_error(mut patch: CubicPatch, samples: &[(DVec3, DVec3)]) -> f64 {
    patch.points[CENTRE] = DVec3::ZERO;
    patch.points[CENTRE] = centre_through(&patch, samples.iter().copied());
    let distances = samples.iter().map(|&(point, at)| slide(&patch, at, point).1);
    distances.fold(0.0, f64::max)
}

/// Cuts a piece where `beyond` changes its sign, given at its corners.
fn cut(piece: &Piece, beyond: [f64; 3], parts: &mut Vec<Part>, mut push: impl FnMut(Piece, bool)) {
    let is_near = beyond.iter().all(|&far| far <= ON_LINE);
    if is_near || beyond.iter().all(|&far| far >= -ON_LINE) {
        return push(*piece, !is_near);
    }
    let corners = [DVec3::X, DVec3::Y, DVec3::Z];
    let crossing = |i: usize, j: usize| corners[i].lerp(corners[j], beyond[i] / (beyond[i] - beyond[j]));
    if let Some(on) = beyond.iter().position(|far| far.abs() <= ON_LINE) {
        let (i, j) = ((on + 1) % 3, (on + 2) % 3);
        let middle = crossing(i, j);
        push(piece.cut([corners[on], corners[i], middle], parts), beyond[i] > 0.0);
        push(piece.cut([corners[on], middle, corners[j]], parts), beyond[j] > 0.0);
        return;
    }
    let is_lone = |i: &usize| {
        (beyond[*i] > 0.0) != (beyond[(i + 1) % 3] > 0.0) && (beyond[*i] > 0.0) != (beyond[(i + 2) % 3] > 0.0)
    };
    let lone = (0..3)
        .find(is_lone)
        .expect("of three signs that are not the same, one is alone");
    let (i, j) = ((lone + 1) % 3, (lone + 2) % 3);
    let [to_i, to_j] = [crossing(lone, i), crossing(lone, j)];
    push(piece.cut([corners[lone], to_i, to_j], parts), beyond[lone] > 0.0);
    push(piece.cut([to_i, corners[i], corners[j]], parts), beyond[i] > 0.0);
    push(piece.cut([to_i, corners[j], to_j], parts), beyond[i] > 0.0);
}

/// The patch that stands for pieces, given without its centre, whose corners slide to where it is nearest to them; and its
/// error.
///
/// # Errors
/// What the error is at least, more or less, where that is more than `limit`.
pub(super) fn fit(
    without: CubicPatch,
    pieces: &mut [Piece],
    parts: &[Part],
    limit: f64,
    scratch: &mut Vec<(DVec3, f64, f64)>,
) -> Result<(CubicPatch, f64), f64> {
    let mut patch = without;
    patch.points[CENTRE] = DVec3::ZERO;
    let without = patch;
    let firsts = pieces
        .iter()
        .map(|piece| (parts[piece.part as usize].points.points[0], piece.at[0]));
    patch.points[CENTRE] = centre_through(&without, firsts);
    let mut farthest = 0.0_f64;
    for piece in pieces.iter_mut() {
        let points = &parts[piece.part as usize].points.points;
        for (at, corner) in piece.at.iter_mut().zip(CORNERS) {
            let (slid, distance) = slide(&patch, *at, points[corner]);
            *at = slid;
            farthest = farthest.max(distance);
        }
    }
    if farthest > limit {
        return Err(farthest);
    }
    let (centre, error) = fit_centre(&without, pieces, parts, scratch);
    patch.points[CENTRE] = centre;
    if error > limit { Err(error) } else { Ok((patch, error)) }
}

/// The centre with which a patch is nearest to points at places, in the sense of least squares; or where these do not tell, the
/// one that makes a patch of quadratic curves quadratic (G. Farin).
fn centre_through(without: &CubicPatch, points: impl Iterator<Item = (DVec3, DVec3)>) -> DVec3 {
    let p = &without.points;
    let quadratic = (p[1] + p[2] + p[3] + p[5] + p[7] + p[8]) / 4.0 - (p[0] + p[6] + p[9]) / 6.0;
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for (point, at) in points {
        let share = 6.0 * at.x * at.y * at.z;
        if share > 0.0 {
            sum += share * (point - without.point(at));
            weight += share * share;
        }
    }
    if weight > 0.0 { sum / weight } else { quadratic }
}

/// Where a patch is nearest to a point, from a place nearby, which is not left if it is a corner, and along the side alone that
/// it is on; and how far the patch is from the point there, more or less. One step of Gauss and Newton.
#[inline]
fn slide(patch: &CubicPatch, at: DVec3, point: DVec3) -> (DVec3, f64) {
    let [a, b, c] = patch.corner_triangle(at);
    let left = point - (at.x * a + at.y * b + at.z * c);
    let zeros = at.to_array().map(|coordinate| coordinate == 0.0);
    match zeros {
        [false, false, false] => {
            let (along_b, along_c) = (3.0 * (b - a), 3.0 * (c - a));
            let (bb, bc, cc) = (along_b.dot(along_b), along_b.dot(along_c), along_c.dot(along_c));
            let damping = DAMPING * (bb + cc);
            let (bb_damped, cc_damped) = (bb + damping, cc + damping);
            let determinant = bb_damped * cc_damped - bc * bc;
            if determinant <= 0.0 {
                return (at, left.length());
            }
            let (to_b, to_c) = (along_b.dot(left), along_c.dot(left));
            let y = (cc_damped * to_b - bc * to_c) / determinant;
            let z = (bb_damped * to_c - bc * to_b) / determinant;
            let distance = (left - y * along_b - z * along_c).length();
            (inside(at + DVec3::new(-y - z, y, z)), distance)
        }
        [false, false, true] => slide_along(at, left, [0, 1], 3.0 * (b - a)),
        [true, false, false] => slide_along(at, left, [1, 2], 3.0 * (c - b)),
        [false, true, false] => slide_along(at, left, [2, 0], 3.0 * (a - c)),
        _ => (at, left.length()),
    }
}

/// The same along a side from one of its ends to the other.
fn slide_along(at: DVec3, left: DVec3, [from, to]: [usize; 2], along: DVec3) -> (DVec3, f64) {
    let square = along.length_squared();
    if square == 0.0 {
        return (at, left.length());
    }
    let step = along.dot(left) / square;
    let t = (at[to] + step).clamp(INSIDE, 1.0 - INSIDE);
    let mut slid = DVec3::ZERO;
    slid[from] = 1.0 - t;
    slid[to] = t;
    (slid, (left - step * along).length())
}

/// A place inside the domain, near to the given one.
fn inside(at: DVec3) -> DVec3 {
    let held = at.max(DVec3::splat(INSIDE));
    held / held.element_sum()
}

/// The centre of a patch that stands for pieces, given with its other control points: the one whose parts' control points
/// deviate least from those of the pieces, in the sense of least squares; and the patch's error with it.
fn fit_centre(
    without: &CubicPatch,
    pieces: &[Piece],
    parts: &[Part],
    scratch: &mut Vec<(DVec3, f64, f64)>,
) -> (DVec3, f64) {
    scratch.clear();
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for piece in pieces {
        let given = &parts[piece.part as usize];
        let part = without.part(piece.at);
        let shares = shares_of_centre(piece.at);
        for ((point, own), share) in given.points.points.iter().zip(&part.points).zip(shares) {
            let left = *point - *own;
            sum += share * left;
            weight += share * share;
            scratch.push((left, share, given.error));
        }
    }
    let centre = sum / weight;
    let deviations = scratch
        .iter()
        .map(|(left, share, error)| (*left - *share * centre).length() + error);
    (centre, deviations.fold(0.0, f64::max))
}

/// How much of a patch's centre is in each control point of its part over a triangle: the blossom of 6uvw.
#[inline]
fn shares_of_centre([x, y, z]: [DVec3; 3]) -> [f64; 10] {
    let [by_x, by_y] = [x, y].map(|a| move |b: DVec3, c: DVec3| blossom(a, b, c));
    [
        by_x(x, x),
        by_x(x, y),
        by_x(x, z),
        by_x(y, y),
        by_x(y, z),
        by_x(z, z),
        by_y(y, y),
        by_y(y, z),
        by_y(z, z),
        blossom(z, z, z),
    ]
}

#[inline]
fn blossom(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    a.x * (b.y * c.z + b.z * c.y) + a.y * (b.x * c.z + b.z * c.x) + a.z * (b.x * c.y + b.y * c.x)
}
