//! The rules that a collapse must pass, one function each; the simplifier composes them.

use glam::DVec3;

use crate::mesh::plan_orientation;
use crate::reference::Bound;
use crate::simplify::{Simplifier, VertexKind};

/// An edge collapse under consideration, and the neighbours of its endpoints.
pub(crate) struct Candidate<'a> {
    pub(crate) blue: u32,
    pub(crate) red: u32,
    pub(crate) around_blue: &'a [u32],
    pub(crate) around_red: &'a [u32],
}

/// The table of [`VertexKind`].
pub(crate) fn kinds_allow(simplifier: &Simplifier, blue: u32, red: u32) -> bool {
    let (from, to) = (simplifier.positions[blue as usize], simplifier.positions[red as usize]);
    let target = simplifier.kinds[red as usize];
    match simplifier.kinds[blue as usize] {
        _ if target == VertexKind::Border => false,
        VertexKind::Free => true,
        VertexKind::OnColumn => from.x == to.x && matches!(target, VertexKind::OnColumn | VertexKind::Fixed),
        VertexKind::OnRow => from.y == to.y && matches!(target, VertexKind::OnRow | VertexKind::Fixed),
        VertexKind::Outline => is_boundary_edge(simplifier, blue, red),
        VertexKind::Fixed | VertexKind::Border => false,
    }
}

/// The link condition with its boundary part (T. Dey et al., *Topology preserving edge contraction*, 1999): endpoints
/// share no neighbour but those of the edge's own triangles, no interior edge joins two vertices of the boundary, and
/// the last triangle stays.
pub(crate) fn link_allows(simplifier: &Simplifier, candidate: &Candidate) -> bool {
    let &Candidate {
        blue,
        red,
        around_blue,
        around_red,
    } = candidate;
    let shared = around_blue.iter().filter(|vertex| around_red.contains(vertex)).count();
    let on_edge = simplifier.star(blue).filter(|corners| corners.contains(&red)).count();
    let (star_of_blue, star_of_red) = (simplifier.star(blue).count(), simplifier.star(red).count());
    let is_boundary = |star: usize, around: &[u32]| star != around.len();
    let pinches = on_edge == 2 && is_boundary(star_of_blue, around_blue) && is_boundary(star_of_red, around_red);
    let is_last = star_of_blue == on_edge && star_of_red == on_edge;
    shared == on_edge && !pinches && !is_last
}

/// Every triangle that stays is counter-clockwise and at least `least_altitude` high in plan view.
pub(crate) fn stays_upright(simplifier: &Simplifier, blue: u32, red: u32, least_altitude: f64) -> bool {
    let moved = simplifier.star(blue).filter(|corners| !corners.contains(&red));
    moved
        .map(|corners| corners.map(|corner| if corner == blue { red } else { corner }))
        .all(|corners| {
            let [a, b, c] = corners.map(|corner| simplifier.positions[corner as usize]);
            plan_orientation(a, b, c) > 0.0 && altitude(a, b, c) >= least_altitude
        })
}

/// A height of the red vertex with which every point of the new star stays within the tolerance: of those the one of
/// least squares; none if there is no such height.
pub(crate) fn allowed_height(simplifier: &Simplifier, candidate: &Candidate, tolerance: f64) -> Option<f64> {
    let &Candidate { blue, red, .. } = candidate;
    let spokes = spokes(candidate);
    let is_movable = !matches!(simplifier.kinds[red as usize], VertexKind::Fixed | VertexKind::Border);
    let present = simplifier.positions[red as usize].z;
    let mut interval = Interval::new(tolerance);
    if !is_movable {
        (interval.low, interval.high) = (present, present);
    }
    constrain_by_samples(simplifier, blue, red, is_movable, &mut interval);
    if simplifier.reference.bound == Bound::Surface {
        constrain_by_edges(simplifier, red, &spokes, &mut interval);
    }
    let height = interval.best(present, |height| simplifier.stepped(height), simplifier.height_step())?;
    let holds = simplifier.reference.bound == Bound::Samples
        || spokes.iter().all(|&end| {
            let mut centre = simplifier.grid_point(red);
            centre.height = height;
            simplifier
                .reference
                .edge_deviation(centre, simplifier.grid_point(end))
                .size
                <= tolerance
        });
    holds.then_some(height)
}

/// Heights that the red vertex may take, and the sums for the best of them.
struct Interval {
    tolerance: f64,
    low: f64,
    high: f64,
    weights: f64,
    weighted: f64,
}

impl Interval {
    fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            weights: 0.0,
            weighted: 0.0,
        }
    }

    fn is_empty(&self) -> bool {
        self.low > self.high
    }

    /// `weight · height` must come within the tolerance of `target`.
    fn constrain(&mut self, weight: f64, target: f64) {
        if weight > 1e-9 {
            self.low = self.low.max((target - self.tolerance) / weight);
            self.high = self.high.min((target + self.tolerance) / weight);
            self.weights += weight * weight;
            self.weighted += weight * target;
        } else if target.abs() > self.tolerance {
            self.high = f64::NEG_INFINITY;
        }
    }

    fn best(&self, present: f64, stepped: impl Fn(f64) -> f64, step: f64) -> Option<f64> {
        if self.is_empty() {
            return None;
        }
        if self.low == self.high {
            return Some(self.low);
        }
        let wanted = if self.weights > 0.0 {
            self.weighted / self.weights
        } else {
            present
        };
        let nearest = stepped(wanted.clamp(self.low, self.high));
        let candidates = [nearest, nearest + step, nearest - step];
        candidates
            .into_iter()
            .find(|height| (self.low..=self.high).contains(height))
    }
}

fn constrain_by_samples(simplifier: &Simplifier, blue: u32, red: u32, with_red_star: bool, interval: &mut Interval) {
    let moved = simplifier.star(blue).filter(|corners| !corners.contains(&red));
    let stays = simplifier
        .star(red)
        .filter(|corners| with_red_star && !corners.contains(&blue));
    for corners in moved.chain(stays) {
        if interval.is_empty() {
            return;
        }
        let at = corners
            .iter()
            .position(|&corner| corner == blue || corner == red)
            .unwrap_or(0);
        let (second, third) = (corners[(at + 1) % 3], corners[(at + 2) % 3]);
        let points = [red, second, third].map(|vertex| simplifier.grid_point(vertex));
        simplifier
            .reference
            .visit_samples(points, |_, _, [weight, w1, w2], target| {
                interval.constrain(weight, target - w1 * points[1].height - w2 * points[2].height);
            });
    }
}

fn constrain_by_edges(simplifier: &Simplifier, red: u32, spokes: &[u32], interval: &mut Interval) {
    let centre = simplifier.grid_point(red);
    for &end in spokes {
        if interval.is_empty() {
            return;
        }
        let end = simplifier.grid_point(end);
        simplifier.reference.visit_edge(centre.grid, end.grid, |t, target| {
            interval.constrain(1.0 - t, target - t * end.height);
        });
    }
}

/// The neighbours of the red vertex after the collapse.
fn spokes(candidate: &Candidate) -> Vec<u32> {
    let &Candidate {
        blue,
        red,
        around_blue,
        around_red,
    } = candidate;
    let added = around_blue.iter().filter(|vertex| !around_red.contains(vertex));
    around_red
        .iter()
        .chain(added)
        .copied()
        .filter(|&vertex| vertex != blue && vertex != red)
        .collect()
}

fn is_boundary_edge(simplifier: &Simplifier, a: u32, b: u32) -> bool {
    simplifier.star(a).filter(|corners| corners.contains(&b)).count() == 1
}

fn altitude(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let [a, b, c] = [a, b, c].map(DVec3::truncate);
    let longest = a
        .distance_squared(b)
        .max(b.distance_squared(c))
        .max(c.distance_squared(a))
        .sqrt();
    (b - a).perp_dot(c - a) / longest
}
