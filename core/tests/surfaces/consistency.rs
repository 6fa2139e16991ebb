//! Every surface that levels, closed sets and queues can reach is consistent: on random Delaunay fields with random
//! collapses, compared with a plain replay that knows no ring, level or graph.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use spade::{DelaunayTriangulation, Point2, Triangulation};
use terrain_core::levels::adaptive_surface::AdaptiveSurface;
use terrain_core::levels::level_view::LevelView;
use terrain_core::levels::refinement_queues::RefinementQueues;
use terrain_core::levels::replay::{Demand, Replay};
use terrain_core::topology::connectivity::Connectivity;
use terrain_core::topology::manifold;
use terrain_core::{Collapse, CollapseLog, Mesh, SurfacePartition, mesh};

use crate::random::random_log;

const FIELDS: u64 = 12;

/// A triangle of a star: its corners, from the smallest on, and where they are.
type Placed = [(u32, [u64; 3]); 3];

/// Triangles by their index in the mesh, and positions.
#[derive(Clone)]
struct PlainSurface {
    triangles: BTreeMap<u32, [u32; 3]>,
    positions: Vec<DVec3>,
}

impl PlainSurface {
    fn new(mesh: &Mesh) -> Self {
        Self {
            triangles: (0..).zip(mesh.triangles.iter().copied()).collect(),
            positions: mesh.positions.clone(),
        }
    }

    fn placed(&self, triangle: [u32; 3]) -> Placed {
        let place = |vertex: u32| (vertex, self.positions[vertex as usize].to_array().map(f64::to_bits));
        let mut placed = triangle.map(place);
        let smallest = (0..3).min_by_key(|&corner| placed[corner]).unwrap();
        placed.rotate_left(smallest);
        placed
    }

    fn drawn(&self) -> BTreeMap<u32, Placed> {
        let placed = self
            .triangles
            .iter()
            .map(|(&index, &triangle)| (index, self.placed(triangle)));
        placed.collect()
    }

    /// Performs a collapse and returns the star that its edge had.
    fn perform(&mut self, collapse: Collapse) -> BTreeMap<u32, Placed> {
        let Collapse { blue, red, .. } = collapse;
        let is_near = |triangle: &[u32; 3]| triangle.contains(&blue) || triangle.contains(&red);
        let near = self.triangles.iter().filter(|(_, triangle)| is_near(triangle));
        let star = near.map(|(&index, &triangle)| (index, self.placed(triangle))).collect();
        self.triangles
            .retain(|_, triangle| !(triangle.contains(&blue) && triangle.contains(&red)));
        for corner in self.triangles.values_mut().flatten() {
            if *corner == blue {
                *corner = red;
            }
        }
        self.positions[red as usize] = collapse.red_after;
        star
    }
}

/// A Delaunay triangulation of random points of random heights.
fn delaunay_field(point_count: usize, random: &mut fastrand::Rng) -> Mesh {
    let mut triangulation = DelaunayTriangulation::<Point2<f64>>::new();
    for _ in 0..point_count {
        let point = Point2::new(random.f64() * 100.0, random.f64() * 100.0);
        triangulation.insert(point).unwrap();
    }
    let heights = std::iter::repeat_with(|| random.f64() * 10.0);
    Mesh {
        positions: triangulation
            .vertices()
            .zip(heights)
            .map(|(vertex, height)| DVec2::new(vertex.position().x, vertex.position().y).extend(height))
            .collect(),
        triangles: triangulation
            .inner_faces()
            .map(|face| face.vertices().map(|vertex| vertex.index() as u32))
            .collect(),
    }
}

pub(crate) struct Field {
    pub(crate) mesh: Mesh,
    pub(crate) log: CollapseLog,
    /// The star of each collapse's edge when the log was made.
    stars: Vec<BTreeMap<u32, Placed>>,
    pub(crate) random: fastrand::Rng,
}

pub(crate) fn field(seed: u64) -> Field {
    let mut random = fastrand::Rng::with_seed(seed);
    let mesh = delaunay_field(80, &mut random);
    let log = random_log(&mesh, usize::MAX, seed.is_multiple_of(2), &mut random);
    assert!(
        log.collapses.len() > 60,
        "seed {seed}: only {} collapses",
        log.collapses.len()
    );
    Field::new(mesh, log, random)
}

impl Field {
    pub(crate) fn new(mesh: Mesh, log: CollapseLog, random: fastrand::Rng) -> Self {
        let mut plain = PlainSurface::new(&mesh);
        let stars = log.collapses.iter().map(|&collapse| plain.perform(collapse)).collect();
        Self {
            mesh,
            log,
            stars,
            random,
        }
    }

    /// Performs a closed set in the order of the log; each star must be the one of the log.
    fn with_performed(&self, is_performed: impl Fn(usize) -> bool) -> PlainSurface {
        let mut plain = PlainSurface::new(&self.mesh);
        for (index, &collapse) in self.log.collapses.iter().enumerate() {
            if is_performed(index) {
                assert_eq!(plain.perform(collapse), self.stars[index], "star of collapse {index}");
            }
        }
        plain
    }

    pub(crate) fn check(&self, surface: &AdaptiveSurface) {
        assert!(surface.dag().is_closed(|collapse| surface.is_performed(collapse)));
        let plain = self.with_performed(|index| surface.is_performed(index as u32));
        let placed = |triangle: u32| {
            let corners = surface.corners(triangle);
            let own = PlainSurface {
                triangles: BTreeMap::new(),
                positions: corners.map(|corner| surface.position(corner)).to_vec(),
            };
            let mut placed = own
                .placed([0, 1, 2])
                .map(|(corner, position)| (corners[corner as usize], position));
            let smallest = (0..3).min_by_key(|&corner| placed[corner]).unwrap();
            placed.rotate_left(smallest);
            placed
        };
        let drawn: BTreeMap<u32, Placed> = surface.triangles().iter().map(|&t| (t, placed(t))).collect();
        assert_eq!(drawn, plain.drawn());
        check_valid(&surface.mesh());
    }
}

fn check_valid(surface: &Mesh) {
    mesh::validate(surface).unwrap();
    manifold::check_stars(&Connectivity::new(surface)).unwrap();
}

#[test]
fn every_level_is_the_collapses_of_lower_levels() {
    for seed in 0..FIELDS {
        let field = field(seed);
        let replay = Replay::run(&field.mesh, &field.log, Demand::Consistent, |_| ()).unwrap();
        let batches = replay.level_batches(&field.log, 0.0);
        let partition = SurfacePartition::from_replay(&field.mesh, &replay, &batches).unwrap();
        terrain_core::levels::partition::validate(&partition).unwrap();
        let (vertices, triangles) = (replay.vertex_order(), replay.triangle_order());
        let mut view = LevelView::new(&partition);
        let mut levels: Vec<u32> = (1..=replay.top_level).collect();
        field.random.clone().shuffle(&mut levels);
        for level in levels {
            view.set_level((replay.top_level - level) as usize);
            check_valid(&view.mesh());
            let mut plain = field.with_performed(|index| replay.collapse_levels[index] < level);
            let expected = plain.drawn();
            for (place, &position) in view.positions().iter().enumerate() {
                plain.positions[vertices[place] as usize] = position;
            }
            let corners = view.triangles().map(|t| t.map(|corner| vertices[corner as usize]));
            plain.triangles = triangles.iter().copied().zip(corners).collect();
            assert_eq!(plain.drawn(), expected, "seed {seed}, level {level}");
        }
    }
}

#[test]
fn every_closed_set_draws_the_stars_of_the_log() {
    for seed in 0..FIELDS {
        let mut field = field(seed);
        let mut surface = AdaptiveSurface::new(&field.mesh, &field.log).unwrap();
        field.check(&surface);
        for _ in 0..40 {
            for _ in 0..field.random.usize(1..30) {
                let splits = field.random.bool();
                let possible = if splits {
                    surface.splittable()
                } else {
                    surface.collapsible()
                };
                if let Some(&collapse) = field.random.choice(possible) {
                    assert!(if splits {
                        surface.split(collapse)
                    } else {
                        surface.collapse(collapse)
                    });
                }
            }
            field.check(&surface);
        }
    }
}

#[test]
fn a_forced_split_undoes_what_rests_on_the_collapse_and_no_more() {
    for seed in 0..FIELDS {
        let mut field = field(seed);
        let count = field.log.collapses.len() as u32;
        for _ in 0..10 {
            let mut surface = AdaptiveSurface::new(&field.mesh, &field.log).unwrap();
            let wanted = field.random.u32(0..count);
            let split = surface.force_split(wanted);
            assert_eq!(split.last(), Some(&wanted));
            assert!(!surface.is_performed(wanted));
            assert!(surface.force_split(wanted).is_empty());
            let mut rests = vec![false; count as usize];
            for collapse in 0..count {
                let mut needed = surface.dag().constraints(collapse).iter();
                rests[collapse as usize] = collapse == wanted || needed.any(|&other| rests[other as usize]);
            }
            let expected: Vec<u32> = (0..count).rev().filter(|&collapse| rests[collapse as usize]).collect();
            assert_eq!(split, expected);
            field.check(&surface);
        }
    }
}

#[test]
fn every_state_of_the_queues_is_consistent_and_keeps_to_the_maximum() {
    for seed in 0..FIELDS {
        let mut field = field(seed);
        let mut surface = AdaptiveSurface::new(&field.mesh, &field.log).unwrap();
        let mut queues = RefinementQueues::new(&surface, |_| 0.0);
        for turn in 0..30 {
            let own: Vec<f64> = field.log.collapses.iter().map(|_| field.random.f64()).collect();
            let is_monotone = turn % 2 == 0;
            let errors = if is_monotone {
                surface.dag().monotone_errors(&own)
            } else {
                own
            };
            let error = |collapse: u32| errors[collapse as usize];
            let maximum = field.random.f64();
            queues.refill(&surface, error);
            let changes = queues.update(&mut surface, maximum, error);
            field.check(&surface);
            let may_be_split = |&&collapse: &&u32| error(collapse) > maximum;
            assert_eq!(surface.splittable().iter().find(may_be_split), None);
            if is_monotone {
                let is_right = |c: u32| surface.is_performed(c) == (error(c) < maximum);
                assert!(
                    (0..errors.len() as u32).all(is_right),
                    "seed {seed}, turn {turn}, {changes:?}"
                );
            }
        }
    }
}
