//! What a collapse makes of the star of its edge, for any place of the red vertex.
//!
//! ```text
//!        x ─── c ─── y                 x ─── c ─── y
//!        │   ╱ │ ╲   │                 │  ╲  │   ╱ │
//!        │ blue ▶ red│        ▶        │   place   │        facets: place x c, place c y, …
//!        │   ╲ │ ╱   │                 │  ╱  │   ╲ │
//!        … ─── d ─── …                 … ─── d ─── …
//! ```

use glam::DVec3;

use super::samples::{Sample, SampleLists};
use crate::space::distance::{squared_to_box, squared_to_segment, squared_to_triangle};
use crate::topology::half_edges::{self, HalfEdges};

/// Cosine of the largest angle by which a triangle may turn in one collapse: 78°.
const LEAST_COSINE: f64 = 0.2;
/// Altitude over longest side of the flattest triangle that a collapse may make.
const LEAST_ALTITUDE: f64 = 1e-4;
/// Steps along a spoke from one point that is looked at to the next.
const FEWEST_STEPS: usize = 3;
const MOST_STEPS: usize = 6;

/// A triangle that the collapse leaves, with the red vertex and two others.
#[derive(Clone, Copy, Debug)]
struct Facet {
    triangle: u32,
    /// The other two vertices, counter-clockwise.
    others: [u32; 2],
    at: [DVec3; 2],
    /// Where the third one was before.
    before: DVec3,
    /// Whether the boundary runs along the edge between the other two.
    is_rim: bool,
}

/// An edge of the boundary, in a triangle of the star: both ends, or the red vertex and one.
#[derive(Clone, Copy, Debug)]
struct Rim {
    triangle: u32,
    from: Option<DVec3>,
    to: DVec3,
}

/// The star, the samples under it, and its boundary edges.
#[derive(Clone, Debug, Default)]
pub(crate) struct Star {
    facets: Vec<Facet>,
    rims: Vec<Rim>,
    removed: Vec<u32>,
    /// Those under the star, once they are needed.
    samples: Vec<Sample>,
    has_samples: bool,
}

impl Star {
    /// Looks at the edge between two neighbours.
    pub(crate) fn gather(&mut self, connectivity: &HalfEdges, positions: &[DVec3], [blue, red]: [u32; 2]) {
        self.facets.clear();
        self.removed.clear();
        self.gather_facets(connectivity, positions, blue, red);
        self.gather_facets(connectivity, positions, red, blue);
        self.gather_rims();
        self.samples.clear();
        self.has_samples = false;
    }

    fn gather_samples(&mut self, lists: &SampleLists) {
        if !std::mem::replace(&mut self.has_samples, true) {
            let facets = self.facets.iter().map(|facet| facet.triangle);
            let removed = self.removed.iter().copied();
            facets
                .chain(removed)
                .for_each(|triangle| lists.gather(triangle, &mut self.samples));
        }
    }

    fn gather_facets(&mut self, connectivity: &HalfEdges, positions: &[DVec3], centre: u32, other_end: u32) {
        for edge in connectivity.leaving(centre) {
            let others = [connectivity.end(edge), connectivity.apex(edge)];
            let at = others.map(|vertex| positions[vertex as usize]);
            let before = positions[centre as usize];
            if !others.contains(&other_end) {
                self.facets.push(Facet {
                    triangle: edge / 3,
                    others,
                    at,
                    before,
                    is_rim: connectivity.twin(half_edges::next(edge)) == half_edges::NONE,
                });
            } else if centre < other_end {
                self.removed.push(edge / 3);
            }
        }
    }

    /// A spoke that only one facet has is an edge of the boundary.
    fn gather_rims(&mut self) {
        self.rims.clear();
        for facet in &self.facets {
            let rim = |from, to| Rim {
                triangle: facet.triangle,
                from,
                to,
            };
            if facet.is_rim {
                self.rims.push(rim(Some(facet.at[0]), facet.at[1]));
            }
            for (mine, theirs) in [(0, 1), (1, 0)] {
                let is_shared = |other: &Facet| other.others[theirs] == facet.others[mine];
                if !self.facets.iter().any(is_shared) {
                    self.rims.push(rim(None, facet.at[mine]));
                }
            }
        }
    }

    /// Whether no triangle turns over, or becomes flat, with the red vertex at `place`.
    pub(crate) fn keeps_sides(&self, place: DVec3) -> bool {
        self.facets.iter().all(|facet| {
            let [from, to] = facet.at;
            let normal = (from - place).cross(to - place);
            let before = (from - facet.before).cross(to - facet.before);
            let longest = from
                .distance_squared(to)
                .max(place.distance_squared(from))
                .max(place.distance_squared(to));
            let (area, area_before) = (normal.length(), before.length());
            area > LEAST_ALTITUDE * longest && normal.dot(before) >= LEAST_COSINE * area * area_before
        })
    }

    /// Points of the star with the red vertex at `place`, about as many as it has samples, but not many, in rows along its spokes.
    pub(crate) fn points(&self, place: DVec3) -> impl Iterator<Item = DVec3> + '_ {
        let each = self.samples.len() / self.facets.len().max(1);
        let steps = each.isqrt().clamp(FEWEST_STEPS, MOST_STEPS);
        let is_new = move |&(from, to): &(usize, usize)| from > 0 && from + to < steps;
        let grid = (0..steps).flat_map(move |to| (0..steps).map(move |from| (from, to)));
        let grid = grid.filter(is_new);
        self.facets.iter().flat_map(move |facet| {
            let [along_from, along_to] = facet.at.map(|at| (at - place) / steps as f64);
            grid.clone()
                .map(move |(from, to)| place + along_from * from as f64 + along_to * to as f64)
        })
    }

    /// Whether every sample is within `tolerance` of the star with the red vertex at `place`.
    ///
    /// # Errors
    /// The distance of the first that is not. It comes first from then on: it will be too far from the next place, too.
    pub(crate) fn keeps_samples(&mut self, place: DVec3, tolerance: f64, lists: &SampleLists) -> Result<(), f64> {
        self.gather_samples(lists);
        let squared_tolerance = tolerance * tolerance;
        let mut guess = 0;
        for index in 0..self.samples.len() {
            let (found, squared) = self.near_enough(&self.samples[index], place, squared_tolerance, guess);
            if squared > squared_tolerance {
                self.samples.swap(0, index);
                return Err(squared.sqrt());
            }
            guess = found;
        }
        Ok(())
    }

    /// The part of the star next to a sample, or the first, from `guess` on, that is near enough, and its distance squared.
    fn near_enough(&self, sample: &Sample, place: DVec3, enough: f64, guess: usize) -> (usize, f64) {
        let count = self.part_count(sample);
        let mut nearest = (guess % count, f64::INFINITY);
        for step in 0..count {
            let part = (guess + step) % count;
            let squared = self.squared_to_part(sample, place, part, nearest.1);
            if squared < nearest.1 {
                nearest = (part, squared);
            }
            if squared <= enough {
                break;
            }
        }
        nearest
    }

    fn is_measured_from_rims(&self, sample: &Sample) -> bool {
        sample.is_on_boundary && !self.rims.is_empty()
    }

    fn part_count(&self, sample: &Sample) -> usize {
        if self.is_measured_from_rims(sample) {
            self.rims.len()
        } else {
            self.facets.len()
        }
    }

    /// Distance of a sample from a part, squared, or anything from `limit` on if it is not below that.
    fn squared_to_part(&self, sample: &Sample, place: DVec3, part: usize, limit: f64) -> f64 {
        if self.is_measured_from_rims(sample) {
            let Rim { from, to, .. } = self.rims[part];
            squared_to_segment(sample.at, [from.unwrap_or(place), to])
        } else {
            let [from, to] = self.facets[part].at;
            let corners = [place, from, to];
            match squared_to_box(sample.at, corners) {
                squared if squared >= limit => squared,
                _ => squared_to_triangle(sample.at, corners),
            }
        }
    }

    /// Moves the samples into the lists of the triangles that are next to them, with the red vertex at `place`.
    pub(crate) fn lay_samples(&self, place: DVec3, lists: &mut SampleLists) {
        let removed = self.removed.iter().copied();
        let triangles = self.facets.iter().map(|facet| facet.triangle).chain(removed);
        triangles.for_each(|triangle| lists.clear(triangle));
        for sample in &self.samples {
            let (part, _) = self.near_enough(sample, place, f64::NEG_INFINITY, 0);
            let triangle = if self.is_measured_from_rims(sample) {
                self.rims[part].triangle
            } else {
                self.facets[part].triangle
            };
            lists.put(triangle, *sample);
        }
    }
}
