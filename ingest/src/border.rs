//! The sides of tiles as curves: a pure function of the raster along the side, so that both neighbours, and every zoom,
//! have the same vertices without asking each other.
//!
//! ```text
//! leaf side:    breakpoints where the side crosses the raster's grid lines, rounded to the lattice
//!               fine   ← fewest of them within the leaf's tolerance
//! every side:   coarse ← fewest of `fine` within twice that tolerance, measured against all breakpoints
//! parent side:  its halves' curves in a row; fine ← what its halves call coarse
//! ```
//! A side is cut into runs where the raster's outline meets it; the ends of runs are kept for ever, and so are a vertex one
//! strip's width from each end of the side, and those at which breaklines leave it.

use glam::DVec2;
use terrain_codec::ellipsoid::MEAN_RADIUS;
use terrain_core::height_field::chain::fewest_vertices;
use terrain_core::height_field::scan::crossings;
use terrain_core::height_field::triangulate::stepped;

use crate::lattice::{Edge, Lattice, STRIP};
use crate::raster_outline::{BorderSource, crossing, is_bounded};
use crate::strips::{out_of_strips, stops};

/// Places beside a side that may tell whether there is surface.
const PLACES_ACROSS: i32 = 12;
/// Lattice units between them.
const PLACE_APART: f64 = (4 * STRIP) as f64;

/// A side's runs from its start to its end.
#[derive(Clone, Debug, Default)]
pub(crate) struct BorderCurve {
    pub(crate) runs: Vec<Run>,
}

/// A stretch of a side along which the same of its two squares have surface.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// West or south of the side, and east or north of it.
    pub(crate) has_surface: [bool; 2],
    /// All breakpoints: global lattice coordinate along the side, and height.
    points: Vec<(i64, f64)>,
    /// Where breaklines leave the side, growing.
    stops: Vec<i64>,
    /// Indices of the vertices of this zoom, and of the parent's.
    fine: Vec<usize>,
    coarse: Vec<usize>,
}

impl Run {
    /// Vertices of this zoom: coordinate along the side, height, and whether the parent has it, too.
    pub(crate) fn vertices(&self) -> impl DoubleEndedIterator<Item = (i64, f64, bool)> + '_ {
        let vertex = |&index: &usize| {
            let (along, height) = self.points[index];
            (along, height, self.coarse.binary_search(&index).is_ok())
        };
        self.fine.iter().map(vertex)
    }

    /// Coordinates of the first and the last vertex.
    pub(crate) fn ends(&self) -> [i64; 2] {
        [self.points[0].0, self.points[self.points.len() - 1].0]
    }
}

impl BorderCurve {
    /// The curve of a leaf's side; `tolerance` in metres is that of its fine vertices.
    pub(crate) fn of_leaf(source: &BorderSource, edge: Edge, tolerance: f64) -> Self {
        let length = source.lattice.extent(edge.zoom);
        let start = edge.along * length;
        let stops = source.stops(edge);
        let mut breakpoints = source.breakpoints(edge);
        breakpoints.extend(&stops);
        breakpoints.sort_unstable();
        breakpoints.dedup();
        let mut runs = source.stretches(edge);
        for (run, [first, last]) in &mut runs {
            let between = breakpoints
                .iter()
                .copied()
                .filter(|along| (*first + 1..*last).contains(along));
            let all = [*first].into_iter().chain(between).chain([*last]);
            run.points = all.map(|along| source.point(edge, along)).collect();
            run.stops = stops
                .iter()
                .copied()
                .filter(|along| (*first..=*last).contains(along))
                .collect();
        }
        let mut runs: Vec<Run> = runs.into_iter().map(|(run, _)| run).collect();
        for run in &mut runs {
            source.keep_ends_clear(edge, run, [start, start + length]);
            run.fine = (0..run.points.len()).collect();
            run.fine = simplified(source.lattice, edge, run, tolerance);
            run.coarse = simplified(source.lattice, edge, run, 2.0 * tolerance);
        }
        Self { runs }
    }

    /// The curve of a side that is no leaf's, from its halves'; `tolerance` as in [`BorderCurve::of_leaf`].
    pub(crate) fn of_halves(lattice: Lattice, edge: Edge, halves: [&Self; 2], tolerance: f64) -> Self {
        let mut runs: Vec<Run> = Vec::new();
        let length = lattice.extent(edge.zoom);
        let joint = edge.along * length + length / 2;
        for run in halves.into_iter().flat_map(|half| &half.runs) {
            match runs.last_mut() {
                Some(last)
                    if last.has_surface == run.has_surface && last.ends()[1] == joint && run.ends()[0] == joint =>
                {
                    let offset = last.points.len() - 1;
                    last.points.extend(&run.points[1..]);
                    last.stops.extend(&run.stops);
                    last.fine.extend(run.coarse[1..].iter().map(|index| index + offset));
                }
                _ => runs.push(Run {
                    fine: run.coarse.clone(),
                    coarse: Vec::new(),
                    ..run.clone()
                }),
            }
        }
        for run in &mut runs {
            run.coarse = simplified(lattice, edge, run, 2.0 * tolerance);
        }
        Self { runs }
    }
}

impl BorderSource<'_> {
    /// Grid coordinates of a place on a side.
    fn grid_at(&self, edge: Edge, along: f64) -> DVec2 {
        let place = global(self.lattice, edge, along, 0.0);
        self.georeference.grid(self.lattice.geographic(place))
    }

    fn point(&self, edge: Edge, along: i64) -> (i64, f64) {
        let height = self.height_at(global(self.lattice, edge, along as f64, 0.0));
        (along, stepped(height, self.lattice.height_step()))
    }

    /// The stretches of a side between the places where the raster's outline meets it, as far as there is surface beside
    /// them; still without points, but with their ends.
    fn stretches(&self, edge: Edge) -> Vec<(Run, [i64; 2])> {
        let length = self.lattice.extent(edge.zoom);
        let (start, line) = (edge.along * length, edge.line * length);
        let ends = [0, length].map(|along| global(self.lattice, edge, (start + along) as f64, 0.0));
        // Seen from a parallel, what was left is right.
        let seen = |[x, y]: [i64; 2]| {
            if edge.is_meridian {
                [x - line, y - start]
            } else {
                [y - line, x - start]
            }
        };
        let turned = |[from, to]: [[i64; 2]; 2]| if edge.is_meridian { [from, to] } else { [to, from] };
        let steps: Vec<[[i64; 2]; 2]> = self
            .steps_around(ends[0], ends[1])
            .iter()
            .map(|step| turned(step.ends.map(seen)))
            .collect();
        let mut stops: Vec<i64> = steps.iter().flat_map(|&step| meetings(step)).collect();
        stops.retain(|along| (0..=length).contains(along));
        stops.extend([0, length]);
        stops.sort_unstable();
        stops.dedup();
        let stretch = |pair: &[i64]| {
            let along = (pair[0] + pair[1]).div_euclid(2) as f64 + 0.5;
            let run = Run {
                has_surface: [false, true].map(|positive| self.is_surface(edge, &steps, along, positive)),
                points: Vec::new(),
                stops: Vec::new(),
                fine: Vec::new(),
                coarse: Vec::new(),
            };
            (run.has_surface != [false; 2]).then_some((run, [start + pair[0], start + pair[1]]))
        };
        stops.windows(2).filter_map(stretch).collect()
    }

    /// Whether there is surface next to a place on the side, west or south of it or else east or north.
    fn is_surface(&self, edge: Edge, steps: &[[[i64; 2]; 2]], along: f64, positive: bool) -> bool {
        // Steps are known in cells around the side. Beside a pole these reach over many meridians, but not over all: what is across
        // from the place far away may have steps before it that are not known.
        let reach = f64::from(PLACES_ACROSS) * PLACE_APART;
        is_bounded(steps, along, positive, reach).unwrap_or_else(|| {
            // No outline is across from the place, so that any point there tells, the farthest from all steps best.
            let from_steps = |sideways: &f64| {
                let at = DVec2::new(*sideways, along);
                let distances = steps.iter().map(|step| distance_to_step(at, step));
                distances.fold(f64::INFINITY, f64::min)
            };
            let places = (1..=PLACES_ACROSS).map(|number| f64::from(number) * PLACE_APART);
            let sideways = places.map(|place| if positive { place } else { -place });
            let best = sideways.max_by(|a, b| {
                from_steps(a)
                    .total_cmp(&from_steps(b))
                    .then(b.abs().total_cmp(&a.abs()))
            });
            let start = (edge.along * self.lattice.extent(edge.zoom)) as f64;
            let place = global(self.lattice, edge, start + along, best.unwrap_or(0.0));
            let cell = self.georeference.grid(self.lattice.geographic(place)).floor();
            self.heights.cell_is_valid(cell.x as i64, cell.y as i64)
        })
    }

    /// The side's ends and where it crosses grid lines, in lattice units along it, growing.
    fn breakpoints(&self, edge: Edge) -> Vec<i64> {
        let length = self.lattice.extent(edge.zoom);
        let (start, end) = (edge.along * length, (edge.along + 1) * length);
        let cells = (self.grid_at(edge, end as f64) - self.grid_at(edge, start as f64))
            .abs()
            .max_element();
        let stretches = cells.ceil().clamp(1.0, 65_536.0);
        let mut found = vec![start, end];
        let mut from = self.grid_at(edge, start as f64);
        for stretch in 0..stretches as i64 {
            let at = |stretch: i64| start as f64 + length as f64 * stretch as f64 / stretches;
            let to = self.grid_at(edge, at(stretch + 1));
            for t in crossings(from.x, to.x).chain(crossings(from.y, to.y)) {
                found.push((at(stretch) + t * (at(stretch + 1) - at(stretch))).round() as i64);
            }
            from = to;
        }
        found.retain(|along| (start..=end).contains(along));
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Where breaklines leave a side or end on it, or turn.
    fn stops(&self, edge: Edge) -> Vec<i64> {
        let length = self.lattice.extent(edge.zoom);
        let ends = [0, length].map(|along| global(self.lattice, edge, (edge.along * length + along) as f64, 0.0));
        let steps = self.breaklines_around(ends[0], ends[1]);
        let edges: Vec<_> = steps.iter().flat_map(|step| out_of_strips(step.ends, length)).collect();
        stops(&edges, usize::from(!edge.is_meridian), edge.line * length)
    }

    /// Puts a vertex one strip's width from each end of the side that the run reaches, and takes out those closer.
    fn keep_ends_clear(&self, edge: Edge, run: &mut Run, [start, end]: [i64; 2]) {
        let [first, last] = run.ends();
        let mut inner = Vec::new();
        if first == start && last > start + STRIP {
            inner.push(start + STRIP);
        }
        if last == end && first < end - STRIP {
            inner.push(end - STRIP);
        }
        let clear = start + STRIP + 1..end - STRIP;
        run.points
            .retain(|&(along, _)| along == first || along == last || clear.contains(&along));
        run.points
            .extend(inner.into_iter().map(|along| self.point(edge, along)));
        run.points.sort_unstable_by_key(|&(along, _)| along);
        run.points.dedup_by_key(|&mut (along, _)| along);
    }
}

/// Global lattice position of a place on a side, moved sideways by some units.
fn global(lattice: Lattice, edge: Edge, along: f64, sideways: f64) -> DVec2 {
    let across = (edge.line * lattice.extent(edge.zoom)) as f64 + sideways;
    if edge.is_meridian {
        DVec2::new(across, along)
    } else {
        DVec2::new(along, across)
    }
}

/// The fewest of the run's fine vertices within a tolerance, the kept ones among them.
fn simplified(lattice: Lattice, edge: Edge, run: &Run, tolerance: f64) -> Vec<usize> {
    let length = lattice.extent(edge.zoom);
    let (start, end) = (edge.along * length, (edge.along + 1) * length);
    let hang = sagitta_per_square_unit(lattice, edge);
    let dropped = |&(along, height): &(i64, f64)| {
        let from_start = (along - start) as f64;
        DVec2::new(from_start, height - hang * from_start * from_start)
    };
    let points: Vec<DVec2> = run.points.iter().map(dropped).collect();
    let is_kept = |&index: &usize| {
        let along = run.points[index].0;
        let is_at_strip = along == start + STRIP || along == end - STRIP;
        index == 0 || index + 1 == points.len() || is_at_strip || run.stops.binary_search(&along).is_ok()
    };
    let mut kept = Vec::new();
    let mut from = 0;
    for to in 1..run.fine.len() {
        if is_kept(&run.fine[to]) {
            kept.extend(fewest_vertices(&points, &run.fine[from..=to], tolerance));
            from = to;
        }
    }
    kept.dedup();
    kept
}

/// Metres by which a chord of one unit hangs below the ellipsoid, times four: kx or ky of the lattice.
fn sagitta_per_square_unit(lattice: Lattice, edge: Edge) -> f64 {
    let start = global(lattice, edge, (edge.along * lattice.extent(edge.zoom)) as f64, 0.0);
    let latitude = lattice.geographic(start).y;
    let shrink = if edge.is_meridian {
        1.0
    } else {
        latitude.to_radians().cos()
    };
    let metres = lattice.degrees_per_unit().to_radians() * MEAN_RADIUS * shrink;
    metres * metres / (2.0 * MEAN_RADIUS)
}

/// Where a step, in (across, along), meets the line `across = 0` from one of its sides.
fn meetings(step: [[i64; 2]; 2]) -> impl Iterator<Item = i64> {
    let [from, to] = step;
    let ends = [(from, to), (to, from)].map(|(end, other)| (end[0] == 0 && other[0] != 0).then_some(end[1]));
    ends.into_iter().flatten().chain(crossing(step, 0, 0))
}

fn distance_to_step(at: DVec2, &[from, to]: &[[i64; 2]; 2]) -> f64 {
    let [from, to] = [from, to].map(|end| DVec2::new(end[0] as f64, end[1] as f64));
    let way = to - from;
    let share = (at - from).dot(way) / way.length_squared().max(1.0);
    at.distance(from + way * share.clamp(0.0, 1.0))
}

#[cfg(test)]
#[path = "border_tests.rs"]
mod tests;
