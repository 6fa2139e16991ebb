//! The patch that is nearest to what it stands for: corners of pieces slide, then its centre is fitted.

use glam::DVec3;

use super::cover::{Cell, Cover, Parts, Piece, Place};
use crate::curved::patch::{CENTRE, CubicPatch};

/// Corners of pieces that are not on a side of the domain keep so far away from it.
const INSIDE: f64 = 1e-6;

/// How much of its own square is added to the steepness along which corners slide, so that they go nowhere far where a patch is
/// degenerate.
const DAMPING: f64 = 1e-4;

/// So many corners, more or less, tell where the centre is before corners slide.
const FIRST: usize = 24;

/// Where a patch is compared before its pieces are.
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

/// What is computed for each place and each piece of a cover, kept to be filled again.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// At each place: de Casteljau's last triangle but one.
    triangles: Vec<[DVec3; 3]>,
    /// For each piece: how far its centre is from that of the patch without its own, and how much of this is in it.
    centres: Vec<(DVec3, f64)>,
}

/// The patch that stands for pieces, given without its centre, whose corners slide to where it is nearest to them; and its
/// error.
///
/// # Errors
/// What the error is at least, more or less, where that is more than `limit`.
pub(super) fn fit(
    mut patch: CubicPatch,
    cover: &mut Cover,
    parts: &Parts,
    limit: f64,
    scratch: &mut Scratch,
) -> Result<(CubicPatch, f64), f64> {
    patch.points[CENTRE] = DVec3::ZERO;
    let without = patch;
    let some = cover.places.iter().step_by(cover.places.len() / FIRST + 1);
    let some = some.map(|place| (parts.corners[place.corner as usize], place.at));
    patch.points[CENTRE] = centre_through(&without, some);
    for Place { corner, at } in &mut cover.places {
        let (slid, distance) = slide(&patch, *at, parts.corners[*corner as usize]);
        *at = slid;
        if distance > limit {
            return Err(distance);
        }
    }
    patch.points[CENTRE] = fit_centre(&without, cover, parts, scratch);
    let error = error(&patch, cover, parts, limit, scratch)?;
    Ok((patch, error))
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

/// The centre of a patch, given with its other control points, with which corners and centres of pieces deviate least, in the sense
/// of least squares.
fn fit_centre(without: &CubicPatch, cover: &Cover, parts: &Parts, scratch: &mut Scratch) -> DVec3 {
    let Scratch { triangles, centres } = scratch;
    triangles.clear();
    centres.clear();
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for &Place { corner, at } in &cover.places {
        let triangle = without.corner_triangle(at);
        let share = 6.0 * at.x * at.y * at.z;
        sum += share * (parts.corners[corner as usize] - blend(triangle, at));
        weight += share * share;
        triangles.push(triangle);
    }
    for piece in &cover.pieces {
        let places = piece.places.map(|place| cover.places[place as usize].at);
        let given = parts.centre(piece.part, corners_of(piece, cover, parts));
        let (left, share) = (given - without.blossom(places), share_of_centre(places));
        sum += share * left;
        weight += share * share;
        centres.push((left, share));
    }
    sum / weight
}

#[inline]
fn corners_of(piece: &Piece, cover: &Cover, parts: &Parts) -> [DVec3; 3] {
    piece
        .places
        .map(|place| parts.corners[cover.places[place as usize].corner as usize])
}

/// The largest deviation of a control point of a piece.
///
/// # Errors
/// One that is more than `limit`.
fn error(
    patch: &CubicPatch,
    cover: &Cover,
    parts: &Parts,
    limit: f64,
    Scratch { triangles, centres }: &mut Scratch,
) -> Result<f64, f64> {
    let centre = patch.points[CENTRE];
    for (triangle, place) in triangles.iter_mut().zip(&cover.places) {
        let at = place.at;
        let shares = [at.y * at.z, at.z * at.x, at.x * at.y];
        for (point, share) in triangle.iter_mut().zip(shares) {
            *point += 2.0 * share * centre;
        }
    }
    let mut largest = 0.0_f64;
    for (piece, (left, share)) in cover.pieces.iter().zip(centres) {
        let given = parts.part(piece.part, corners_of(piece, cover, parts));
        let [a, b, c] = piece.places.map(|place| triangles[place as usize]);
        let [x, y, z] = piece.places.map(|place| cover.places[place as usize].at);
        let own = [
            blend(a, x),
            blend(a, y),
            blend(a, z),
            blend(b, x),
            given.points.points[CENTRE] - *left + *share * centre,
            blend(c, x),
            blend(b, y),
            blend(b, z),
            blend(c, y),
            blend(c, z),
        ];
        let error = given.points.deviation(&CubicPatch { points: own }) + given.error;
        if error > limit {
            return Err(error);
        }
        largest = largest.max(error);
    }
    Ok(largest)
}

/// How much of a patch's centre is in that of its part over a triangle: the blossom of 6uvw.
#[inline]
fn share_of_centre([a, b, c]: [DVec3; 3]) -> f64 {
    a.x * (b.y * c.z + b.z * c.y) + a.y * (b.x * c.z + b.z * c.x) + a.z * (b.x * c.y + b.y * c.x)
}

#[inline(always)]
fn blend([a, b, c]: [DVec3; 3], at: DVec3) -> DVec3 {
    at.x * a + at.y * b + at.z * c
}
