//! What a patch stands for: pieces of the model's own patches, each with the triangle of the patch's domain that it became.
//!
//! ```text
//!        C                    every merge maps domains affinely, so that a piece stays a triangle;
//!       ╱│╲                   where a swapped diagonal runs through a piece, the piece is cut
//!      ╱ │ ╲
//!     ╱ ╱ ╲ ╲                 error of a patch: over all its pieces, the largest distance of a control point of the piece
//!    ╱╱     ╲╲                from that of the patch's own part over the same triangle
//!   A─────────B
//! ```
//! Pieces and parts with the same coordinates correspond, and the pieces cover the patch: so the error bounds the distance both
//! ways, by the convex hull of differences, and nothing is summed up. A patch of too many pieces becomes its own single piece;
//! from then on its error is added to what comes.

use glam::DVec3;

use crate::curved::patch::CubicPatch;

/// So many pieces at most are kept for a patch.
pub(super) const MOST_PIECES: usize = 32;

/// Coordinates nearer to a line are on it.
const ON_LINE: f64 = 1e-12;

/// A piece of the model, or of a patch that stands for a part of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) points: CubicPatch,
    /// How far it is from the model itself.
    pub(super) error: f64,
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
    /// A patch as its own piece.
    pub(super) fn whole(points: CubicPatch, error: f64) -> Self {
        Self {
            points,
            error,
            at: [DVec3::X, DVec3::Y, DVec3::Z],
        }
    }

    fn mapped(&self, map: &Map) -> Self {
        Self {
            at: self.at.map(|at| map.apply(at)),
            ..*self
        }
    }

    /// The part over a triangle in the piece's own coordinates.
    fn part(&self, corners: [DVec3; 3]) -> Self {
        let at = |local: DVec3| local.x * self.at[0] + local.y * self.at[1] + local.z * self.at[2];
        Self {
            points: self.points.part(corners),
            error: self.error,
            at: corners.map(at),
        }
    }
}

impl Cell {
    /// Adds a face's piece, or its parts, to the pieces of the new patches.
    pub(super) fn carry(&self, piece: &Piece, targets: &mut [Vec<Piece>]) {
        match self {
            Self::Whole(map) => targets[map.target].push(piece.mapped(map)),
            Self::Cut { ends, t, maps } => {
                let beyond = piece.at.map(|at| at[ends[1]] * (1.0 - t) - at[ends[0]] * t);
                cut(piece, beyond, |part, is_far| {
                    let map = &maps[usize::from(is_far)];
                    targets[map.target].push(part.mapped(map));
                });
            }
        }
    }
}

/// Cuts a piece where `beyond` changes its sign, given at its corners.
fn cut(piece: &Piece, beyond: [f64; 3], mut push: impl FnMut(Piece, bool)) {
    let is_near = beyond.iter().all(|&far| far <= ON_LINE);
    if is_near || beyond.iter().all(|&far| far >= -ON_LINE) {
        return push(*piece, !is_near);
    }
    let corners = [DVec3::X, DVec3::Y, DVec3::Z];
    let crossing = |i: usize, j: usize| corners[i].lerp(corners[j], beyond[i] / (beyond[i] - beyond[j]));
    if let Some(on) = beyond.iter().position(|far| far.abs() <= ON_LINE) {
        let (i, j) = ((on + 1) % 3, (on + 2) % 3);
        let middle = crossing(i, j);
        push(piece.part([corners[on], corners[i], middle]), beyond[i] > 0.0);
        push(piece.part([corners[on], middle, corners[j]]), beyond[j] > 0.0);
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
    push(piece.part([corners[lone], to_i, to_j]), beyond[lone] > 0.0);
    push(piece.part([to_i, corners[i], corners[j]]), beyond[i] > 0.0);
    push(piece.part([to_i, corners[j], to_j]), beyond[i] > 0.0);
}

/// The centre of a patch that stands for pieces, given with its other control points: the one whose parts' control points
/// deviate least from those of the pieces, in the sense of least squares; and the patch's error with it.
pub(super) fn fit_centre(without: &CubicPatch, pieces: &[Piece], scratch: &mut Vec<(DVec3, f64, f64)>) -> (DVec3, f64) {
    scratch.clear();
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for piece in pieces {
        let part = without.part(piece.at);
        let shares = shares_of_centre(piece.at);
        for ((given, own), share) in piece.points.points.iter().zip(&part.points).zip(shares) {
            let left = *given - *own;
            sum += share * left;
            weight += share * share;
            scratch.push((left, share, piece.error));
        }
    }
    let centre = sum / weight;
    let deviations = scratch
        .iter()
        .map(|(left, share, error)| (*left - *share * centre).length() + error);
    (centre, deviations.fold(0.0, f64::max))
}

/// How much of a patch's centre is in each control point of its part over a triangle: the blossom of 6uvw.
fn shares_of_centre([x, y, z]: [DVec3; 3]) -> [f64; 10] {
    let blossom = |a: DVec3, b: DVec3, c: DVec3| {
        a.x * (b.y * c.z + b.z * c.y) + a.y * (b.x * c.z + b.z * c.x) + a.z * (b.x * c.y + b.y * c.x)
    };
    [
        blossom(x, x, x),
        blossom(x, x, y),
        blossom(x, x, z),
        blossom(x, y, y),
        blossom(x, y, z),
        blossom(x, z, z),
        blossom(y, y, y),
        blossom(y, y, z),
        blossom(y, z, z),
        blossom(z, z, z),
    ]
}
