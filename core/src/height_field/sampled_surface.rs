//! A surface with the samples under each of its triangles, and the edits that keep the two together.
//!
//! ```text
//! edit: take the samples under the triangles that change out of their lists, change them, lay the samples under the new ones
//! ```

use glam::DVec2;

use crate::height_field::fan::Fan;
use crate::height_field::finer::SurfacePoint;
use crate::height_field::flat::GridPoint;
use crate::height_field::kept_chains::{KeptChains, Strays};
use crate::height_field::reference::Bound;
use crate::height_field::ring::Ring;
use crate::height_field::rules::VertexKind;
use crate::height_field::samples::{Sample, SampleLists};
use crate::height_field::surface::Surface;
use crate::topology::edge_collapse::Edge;

/// A surface, its samples, and what its vertices may do.
pub(crate) struct SampledSurface<'a> {
    pub(crate) surface: Surface<'a>,
    pub(crate) samples: SampleLists,
    pub(crate) kinds: Vec<VertexKind>,
    pub(crate) outline: KeptChains,
    /// Metres.
    pub(crate) outline_strayed: f64,
    pub(crate) breaklines: KeptChains,
    /// Metres.
    pub(crate) breaklines_strayed: f64,
    /// Around the vertex whose samples were laid last.
    pub(crate) ring: Ring,
    fan: Fan,
    /// Half-edges to the ring.
    spokes: Vec<u32>,
}

/// Samples taken from under the triangles around both ends of an edge.
#[derive(Default)]
pub(crate) struct Gathered {
    /// Around the blue one.
    pub(crate) around_blue: Vec<Sample>,
    /// Around the red one, but for those.
    pub(crate) others: Vec<Sample>,
}

impl Gathered {
    pub(crate) fn clear(&mut self) {
        self.around_blue.clear();
        self.others.clear();
    }
}

/// Where a vertex may be put, and what that leaves of the differences.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub(crate) plan: DVec2,
    pub(crate) point: GridPoint,
    /// Sum of the squared differences at the samples of its star.
    pub(crate) squares: f64,
}

/// A collapse that passed all checks.
pub(crate) struct Chosen {
    pub(crate) red: u32,
    pub(crate) place: Place,
    /// How far the outline strays then.
    pub(crate) strays: Strays,
    /// The same of the breakline, metres.
    pub(crate) breakline_strays: f64,
    /// The third vertex of the hole that is closed.
    pub(crate) closes: Option<u32>,
}

impl<'a> SampledSurface<'a> {
    /// Vertices of the outline that are [`VertexKind::Free`] become [`VertexKind::Outline`], and [`VertexKind::Border`] where the
    /// outline touches itself. Of vertices of breaklines, those between two ends that are [`VertexKind::Free`] become
    /// [`VertexKind::Breakline`], and all others but those of sides stay.
    pub(crate) fn new(surface: Surface<'a>, mut kinds: Vec<VertexKind>) -> Self {
        let outline = KeptChains::of_outline(&surface);
        for (kind, vertex) in kinds.iter_mut().zip(0..) {
            match outline.visits(vertex) {
                0 => {}
                1 if *kind == VertexKind::Free => *kind = VertexKind::Outline,
                1 => {}
                _ => *kind = VertexKind::Border,
            }
        }
        let breaklines = KeptChains::of_breaklines(&surface);
        for &vertex in surface.breaklines.iter().flatten() {
            let kind = &mut kinds[vertex as usize];
            *kind = match *kind {
                VertexKind::Border => VertexKind::Border,
                VertexKind::Free if breaklines.is_between_ends(vertex) => VertexKind::Breakline,
                VertexKind::Breakline => VertexKind::Breakline,
                _ => VertexKind::Fixed,
            };
        }
        let mut samples = SampleLists::new(&surface);
        if surface.reference.bound == Bound::Samples {
            for vertex in vertices_at_one_place(&surface) {
                let GridPoint { grid: at, height } = surface.point(vertex);
                if let Some(edge) = surface.connectivity.leaving(vertex).next() {
                    let sample = samples.add(SurfacePoint { at, height });
                    samples.put(edge / 3, &sample);
                }
            }
        }
        Self {
            samples,
            surface,
            kinds,
            outline,
            outline_strayed: 0.0,
            breaklines,
            breaklines_strayed: 0.0,
            ring: Ring::default(),
            fan: Fan::default(),
            spokes: Vec::new(),
        }
    }

    pub(crate) fn keeps_height(&self, vertex: u32) -> bool {
        self.kinds[vertex as usize].keeps_height()
    }

    /// The third vertex of a hole that the collapse of an edge would close: one of three vertices, all of which are of an
    /// outline and nothing else.
    pub(crate) fn closes(&self, edge: Edge) -> Option<u32> {
        let is_outline = |vertex: u32| self.kinds[vertex as usize] == VertexKind::Outline;
        if !edge.is_on_boundary || !is_outline(edge.blue) || !is_outline(edge.red) {
            return None;
        }
        let third = self.surface.connectivity.third_of_hole(edge.blue, edge.red)?;
        // The outline of all the surface goes round the other way.
        let [from, to] = if edge.index == 0 {
            [edge.blue, edge.red]
        } else {
            [edge.red, edge.blue]
        };
        let [from, to, at] = [from, to, third].map(|vertex| self.surface.plan(vertex));
        (is_outline(third) && (to - from).perp_dot(at - from) < 0.0).then_some(third)
    }

    /// How far the outline would stray.
    pub(crate) fn strays(&self, edge: Edge) -> Strays {
        if let Some(third) = edge.closes {
            let corners = [edge.blue, edge.red, third];
            return Strays {
                metres: self.outline.half_width(self.surface.reference.ground, corners),
                is_straight: false,
            };
        }
        if self.kinds[edge.blue as usize] == VertexKind::Outline {
            self.outline.strays(self.surface.reference.ground, edge.blue, edge.red)
        } else {
            Strays::NONE
        }
    }

    /// Metres that a breakline would stray in plan; infinite where the edge is not along it.
    pub(crate) fn breakline_strays(&self, edge: Edge) -> f64 {
        let may_be_passed = matches!(
            self.kinds[edge.blue as usize],
            VertexKind::Breakline | VertexKind::Border
        );
        if !may_be_passed || self.breaklines.visits(edge.blue) == 0 {
            return 0.0;
        }
        let strays = self
            .breaklines
            .strays(self.surface.reference.ground, edge.blue, edge.red);
        strays.metres
    }

    /// The surface, with the breaklines that are left.
    pub(crate) fn into_surface(mut self) -> Surface<'a> {
        self.surface.breaklines = self.breaklines.left_edges();
        self.surface
    }

    pub(crate) fn gather_around(&self, vertex: u32, samples: &mut Vec<Sample>) {
        for edge in self.surface.connectivity.leaving(vertex) {
            self.samples.gather(self.surface.reference, edge / 3, samples);
        }
    }

    /// The samples around a vertex but for those in triangles with another one.
    pub(crate) fn gather_around_other(&self, vertex: u32, other: u32, samples: &mut Vec<Sample>) {
        let connectivity = &self.surface.connectivity;
        for edge in connectivity.leaving(vertex) {
            if connectivity.end(edge) != other && connectivity.apex(edge) != other {
                self.samples.gather(self.surface.reference, edge / 3, samples);
            }
        }
    }

    /// The samples under the triangles from a place to a ring, whoever had them before.
    pub(crate) fn gather_under(&self, centre: DVec2, ring: &Ring, samples: &mut Vec<Sample>) {
        let last_to_first = || Some([*ring.points.last()?, *ring.points.first()?]);
        let pairs = ring.points.windows(2).map(|pair| [pair[0], pair[1]]);
        for [from, to] in pairs.chain(last_to_first().filter(|_| ring.is_closed)) {
            let corners = [centre, from.grid, to.grid];
            self.samples.gather_under(self.surface.reference, corners, samples);
        }
    }

    /// The triangle around a vertex with a place.
    pub(crate) fn triangle_around(&self, vertex: u32, at: DVec2) -> Option<u32> {
        let connectivity = &self.surface.connectivity;
        let turn = self.surface.reference.plan.handedness();
        let holds = |triangle: &u32| {
            let corners = connectivity
                .corners(*triangle)
                .map(|c| c.map(|corner| self.surface.grid(corner)));
            corners.is_some_and(|[a, b, c]| {
                [(a, b), (b, c), (c, a)]
                    .into_iter()
                    .all(|(from, to)| turn * (to - from).perp_dot(at - from) >= 0.0)
            })
        };
        connectivity.leaving(vertex).map(|edge| edge / 3).find(holds)
    }

    /// Performs a collapse; `gathered` is what is under the triangles around both ends, or may be.
    pub(crate) fn collapse(&mut self, blue: u32, chosen: &Chosen, gathered: &mut Gathered) {
        let &Chosen {
            red,
            ref place,
            strays,
            breakline_strays,
            closes,
        } = chosen;
        self.clear_samples(blue);
        if place.plan == self.surface.plan(red) && strays.is_straight {
            // Red's other triangles are in plan what they were.
            gathered.others.clear();
        } else {
            self.clear_samples(red);
        }
        if let Some(third) = closes {
            self.surface.connectivity.close_hole(blue, red, third);
            self.outline.close([blue, red, third]);
            for inside in [red, third] {
                self.kinds[inside as usize] = VertexKind::Free;
            }
        } else {
            self.surface.connectivity.collapse(blue, red);
            self.outline.remove(blue);
            self.breaklines.remove(blue);
        }
        self.surface.put(red, place.plan, place.point);
        self.outline_strayed = self.outline_strayed.max(strays.metres);
        self.breaklines_strayed = self.breaklines_strayed.max(breakline_strays);
        if !strays.is_straight {
            gathered.clear();
            self.ring.surround(&self.surface, red);
            self.gather_under(place.point.grid, &self.ring, &mut gathered.around_blue);
        }
        self.lay_samples(red, gathered);
    }

    /// Moves a vertex; `gathered` is what is under its triangles.
    pub(crate) fn move_to(&mut self, vertex: u32, place: &Place, gathered: &Gathered) {
        self.clear_samples(vertex);
        self.surface.put(vertex, place.plan, place.point);
        self.lay_samples(vertex, gathered);
    }

    /// Turns an edge; `gathered` is what is under its two triangles.
    pub(crate) fn flip(&mut self, edge: u32, gathered: &Gathered) {
        let connectivity = &self.surface.connectivity;
        let apex = connectivity.apex(edge);
        for triangle in [edge / 3, connectivity.twin(edge) / 3] {
            self.samples.clear(triangle);
        }
        self.surface.connectivity.flip(edge);
        self.lay_samples(apex, gathered);
    }

    /// Takes the samples around a vertex out of their lists.
    fn clear_samples(&mut self, vertex: u32) {
        for edge in self.surface.connectivity.leaving(vertex) {
            self.samples.clear(edge / 3);
        }
    }

    /// Puts samples into the lists of the triangles around a vertex.
    fn lay_samples(&mut self, vertex: u32, gathered: &Gathered) {
        let Ring { points, is_closed, .. } = {
            self.ring.surround(&self.surface, vertex);
            &self.ring
        };
        self.spokes.clear();
        self.spokes.extend(self.surface.connectivity.leaving(vertex));
        let centre = self.surface.grid(vertex);
        self.fan.spread(self.surface.reference, centre, points, *is_closed);
        let mut at = 0;
        for sample in gathered.around_blue.iter().chain(&gathered.others) {
            if let Some(sector) = self.fan.sector_of(sample, at) {
                at = sector;
                self.samples.put(self.spokes[sector] / 3, sample);
            }
        }
    }
}

/// Vertices of fans that touch in a point. The sample there is under one of them and counts for the others, too.
fn vertices_at_one_place(surface: &Surface) -> Vec<u32> {
    let place = |vertex: &u32| {
        let plan = surface.plan(*vertex);
        [plan.x.to_bits(), plan.y.to_bits()]
    };
    let mut vertices: Vec<u32> = (0..surface.vertex_count() as u32).collect();
    vertices.sort_by_key(place);
    vertices
        .chunk_by(|a, b| place(a) == place(b))
        .filter(|vertices| vertices.len() > 1)
        .flatten()
        .copied()
        .collect()
}
