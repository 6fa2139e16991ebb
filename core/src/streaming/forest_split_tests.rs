#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use fastrand::Rng;
use spade::{DelaunayTriangulation, Point2, Triangulation};

use super::*;

/// A Delaunay triangulation of random points in the unit square: a surface with a boundary.
fn terrain(point_count: usize, random: &mut Rng) -> (Vec<[f64; 2]>, ClosedSurface) {
    let mut triangulation = DelaunayTriangulation::<Point2<f64>>::new();
    for _ in 0..point_count {
        triangulation.insert(Point2::new(random.f64(), random.f64())).unwrap();
    }
    let positions: Vec<[f64; 2]> = triangulation
        .vertices()
        .map(|v| [v.position().x, v.position().y])
        .collect();
    let corners = triangulation
        .inner_faces()
        .map(|face| face.vertices().map(|v| v.index() as u32));
    let surface = ClosedSurface::new(positions.len() as u32, &corners.collect::<Vec<_>>()).unwrap();
    (positions, surface)
}

/// The Delaunay triangulation of random points on a sphere: closed. Stereographic projection keeps circles, so that of the
/// plane is the same but for its outside, where the pole is.
fn sphere(point_count: u32, random: &mut Rng) -> ClosedSurface {
    let mut triangulation = DelaunayTriangulation::<Point2<f64>>::new();
    for _ in 1..point_count {
        let (height, angle) = (random.f64() * 2.0 - 1.0, random.f64() * std::f64::consts::TAU);
        let radius = ((1.0 + height) / (1.0 - height)).sqrt();
        let point = Point2::new(radius * angle.cos(), radius * angle.sin());
        triangulation.insert(point).unwrap();
    }
    let corners = triangulation
        .inner_faces()
        .map(|face| face.vertices().map(|v| v.index() as u32));
    let mut triangles: Vec<[u32; 3]> = corners.collect();
    let pole = point_count - 1;
    triangles.extend(
        crate::mesh::boundary_edges(&triangles)
            .into_iter()
            .map(|(a, b)| [b, a, pole]),
    );
    ClosedSurface::new(point_count, &triangles).unwrap()
}

/// Triangles from their smallest corner on, sorted.
fn as_set(triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let rotated = triangles.into_iter().map(|mut corners| {
        let smallest = (0..3).min_by_key(|&corner| corners[corner]).unwrap();
        corners.rotate_left(smallest);
        corners
    });
    let mut set: Vec<[u32; 3]> = rotated.collect();
    set.sort_unstable();
    set
}

/// Coarsens, sends the split as bits and refines again: the fine surface must come back, vertex by vertex.
fn round_trip(fine: &ClosedSurface, collapses: &[[u32; 2]]) -> (Coarsening, SplitBits) {
    let coarsening = coarsen(fine, collapses).unwrap();
    let bits = coarsening.split.encode(&coarsening.surface).unwrap();
    let read = ForestSplit::decode(&bits, &coarsening.surface).unwrap();
    assert_eq!(read, coarsening.split);
    let refined = read.apply(&coarsening.surface).unwrap();
    let to_fine = |corners: &[u32; 3]| corners.map(|vertex| coarsening.refined_to_fine[vertex as usize]);
    assert_eq!(
        as_set(refined.surface.triangles().iter().map(to_fine)),
        as_set(fine.triangles().iter().copied())
    );
    assert_eq!(refined.origins.len(), collapses.len());
    (coarsening, bits)
}

fn random_cost(seed: u64) -> impl Fn(u32, u32, &[[u32; 3]]) -> Option<f64> {
    move |blue, red, _| Some(Rng::with_seed(seed ^ (u64::from(blue) << 32) ^ u64::from(red)).f64())
}

/// Short edges first, and no triangle may turn over.
fn edge_length(positions: &[[f64; 2]]) -> impl Fn(u32, u32, &[[u32; 3]]) -> Option<f64> + '_ {
    |blue, red, kept| {
        let at = |vertex: u32| positions[vertex as usize];
        let area = |[a, b, c]: [[f64; 2]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let moved = |corners: &[u32; 3]| corners.map(|v| at(if v == blue { red } else { v }));
        let is_upright = kept.iter().all(|corners| area(moved(corners)) > 0.0);
        is_upright.then(|| (at(blue)[0] - at(red)[0]).hypot(at(blue)[1] - at(red)[1]))
    }
}

fn bits_per_added_triangle(fine: &ClosedSurface, collapses: &[[u32; 2]]) -> f64 {
    let (coarsening, bits) = round_trip(fine, collapses);
    let added = fine.triangles().len() - coarsening.surface.triangles().len();
    println!(
        "{} to {} triangles",
        coarsening.surface.triangles().len(),
        fine.triangles().len()
    );
    bits.len() as f64 / added as f64
}

#[test]
fn connectivity_costs_at_most_three_and_a_half_bits_for_each_added_triangle() {
    for seed in 0..3 {
        let mut random = Rng::with_seed(seed);
        let (positions, with_boundary) = terrain(2000, &mut random);
        let closed = sphere(2000, &mut random);
        let figures = [
            (
                "terrain, short edges first",
                bits_per_added_triangle(&with_boundary, &largest_batch(&with_boundary, edge_length(&positions))),
            ),
            (
                "terrain, any order",
                bits_per_added_triangle(&with_boundary, &largest_batch(&with_boundary, random_cost(seed))),
            ),
            (
                "sphere, any order",
                bits_per_added_triangle(&closed, &largest_batch(&closed, random_cost(seed))),
            ),
        ];
        println!("bits for each added triangle: {figures:?}");
        assert!(figures.iter().all(|(_, figure)| *figure <= 3.5), "{figures:?}");
    }
}

/// Each collapse asks again about the edges that it changed, however many triangles its red vertex has by then.
#[test]
fn choosing_a_batch_asks_for_few_costs_whatever_the_size_of_the_surface() {
    let asked_for_each_triangle = |point_count: usize| {
        let (_, fine) = terrain(point_count, &mut Rng::with_seed(5));
        let (asked, cost) = (std::cell::Cell::new(0), random_cost(5));
        let batch = largest_batch(&fine, |blue, red, kept| {
            asked.set(asked.get() + 1);
            cost(blue, red, kept)
        });
        assert!(batch.len() > point_count * 2 / 5, "{} collapses", batch.len());
        f64::from(asked.get()) / fine.triangles().len() as f64
    };
    let figures = [500, 8000].map(asked_for_each_triangle);
    println!("{figures:?}");
    assert!(figures.iter().all(|&figure| figure < 7.0), "{figures:?}");
}

#[test]
fn every_batch_of_every_small_surface_comes_back() {
    for seed in 0..60 {
        let mut random = Rng::with_seed(seed);
        let (positions, with_boundary) = terrain(5 + seed as usize, &mut random);
        let upright = largest_batch(&with_boundary, edge_length(&positions));
        let closed = sphere(8 + seed as u32, &mut random);
        for (fine, batch) in [
            (&with_boundary, upright),
            (&with_boundary, largest_batch(&with_boundary, random_cost(seed))),
            (&closed, largest_batch(&closed, random_cost(seed))),
        ] {
            (0..=batch.len()).for_each(|end| _ = round_trip(fine, &batch[..end]));
        }
    }
}

/// Any collapses that are possible, one after the other, until few vertices are left.
fn random_collapses(fine: &ClosedSurface, random: &mut Rng) -> Vec<[u32; 2]> {
    let mut collapses = Vec::new();
    let mut surface = fine.clone();
    let mut names: Vec<u32> = (0..fine.vertex_count()).collect();
    for _ in 0..fine.vertex_count() {
        let mut edges = surface.edges();
        random.shuffle(&mut edges);
        let possible = edges
            .iter()
            .find_map(|&edge| Some((edge, coarsen(&surface, &[edge]).ok()?)));
        let Some(([blue, red], coarsening)) = possible else {
            break;
        };
        collapses.push([names[blue as usize], names[red as usize]]);
        names.remove(blue as usize);
        surface = coarsening.surface;
    }
    collapses
}

#[test]
fn batches_of_any_list_of_collapses_lead_to_the_same_coarsest_surface() {
    for seed in 0..6 {
        let mut random = Rng::with_seed(seed);
        let (_, fine) = terrain(60, &mut random);
        let fine = if seed % 2 == 0 { fine } else { sphere(60, &mut random) };
        let collapses = random_collapses(&fine, &mut random);
        let batches = forest_batches(&fine, &collapses).unwrap();
        assert!(batches.len() < collapses.len() / 2, "{} batches", batches.len());
        let mut surface = fine.clone();
        let mut names: Vec<u32> = (0..fine.vertex_count()).collect();
        for batch in batches {
            let own = |vertex: u32| names.binary_search(&vertex).unwrap() as u32;
            let ends = batch.iter().map(|&index| collapses[index as usize]);
            let (coarsening, _) = round_trip(&surface, &ends.clone().map(|ends| ends.map(own)).collect::<Vec<_>>());
            names.retain(|vertex| ends.clone().all(|[blue, _]| blue != *vertex));
            surface = coarsening.surface;
        }
        let named = surface
            .triangles()
            .iter()
            .map(|corners| corners.map(|vertex| names[vertex as usize]));
        assert_eq!(as_set(named), as_set(replayed(&fine, &collapses)), "seed {seed}");
    }
}

/// What collapses leave, by renaming blue vertices.
fn replayed(fine: &ClosedSurface, collapses: &[[u32; 2]]) -> Vec<[u32; 3]> {
    let mut triangles = fine.triangles().to_vec();
    for &[blue, red] in collapses {
        triangles
            .as_flattened_mut()
            .iter_mut()
            .filter(|corner| **corner == blue)
            .for_each(|corner| *corner = red);
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    }
    triangles
}

/// ```text
///      4
///    ╱ │ ╲
///   3──0──1      an octahedron without its underside, 5: a pyramid with a boundary 0 1 2 3 around the tip 4
///    ╲ │ ╱
///      2
/// ```
const PYRAMID: [[u32; 3]; 4] = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];

#[test]
fn a_collapse_inside_a_surface_is_a_tree_of_two_edges() {
    let octahedron = [PYRAMID.as_slice(), &[[1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]]].concat();
    let fine = ClosedSurface::new(6, &octahedron).unwrap();
    let (coarsening, bits) = round_trip(&fine, &[[5, 0]]);
    assert_eq!(coarsening.split.edges, [[0, 1], [0, 3]]);
    assert_eq!((coarsening.split.opened.len(), coarsening.split.fill.len()), (0, 2));
    assert_eq!(
        bits.fills.len(),
        1,
        "two triangles fill a gap of four sides in two ways"
    );
}

#[test]
fn a_collapse_along_the_boundary_opens_it() {
    let fine = ClosedSurface::new(5, &PYRAMID).unwrap();
    let (coarsening, bits) = round_trip(&fine, &[[3, 0]]);
    assert_eq!(
        (coarsening.split.edges.as_slice(), coarsening.split.opened.as_slice()),
        (&[[0, 3]][..], &[0][..])
    );
    assert_eq!(bits.opened, [true], "only the end at the boundary is asked about");
}

#[test]
fn trees_that_would_share_a_vertex_are_refused() {
    let icosahedron: [[u32; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let fine = ClosedSurface::new(12, &icosahedron).unwrap();
    let refusal = coarsen(&fine, &[[0, 1], [4, 5]]).unwrap_err();
    assert_eq!(refusal.fault, CollapseFault::NotForest);
    assert_eq!(refusal.index, 1);
    assert_eq!(forest_batches(&fine, &[[0, 1], [4, 5]]).unwrap(), [[0], [1]]);
}

#[test]
fn collapses_that_are_none_are_refused_with_their_index() {
    let fine = ClosedSurface::new(5, &PYRAMID).unwrap();
    for bad in [[0, 0], [0, 9], [0, 2], [4, 5]] {
        let refusal = coarsen(&fine, &[[3, 0], bad]).unwrap_err();
        assert_eq!(refusal.index, 1, "{bad:?}");
        assert_eq!(forest_batches(&fine, &[[3, 0], bad]).unwrap_err().index, 1, "{bad:?}");
    }
}

#[test]
fn splits_of_another_surface_are_refused() {
    let surface = ClosedSurface::new(5, &PYRAMID).unwrap();
    let refusal = |edges: &[[u32; 2]], opened: &[u32], triangle_count: usize| {
        let split = ForestSplit {
            edges: edges.to_vec(),
            opened: opened.to_vec(),
            fill: vec![[false; 2]; triangle_count],
        };
        split.apply(&surface).unwrap_err()
    };
    assert_eq!(refusal(&[[0, 2]], &[], 0), SplitError::NoEdge(0, 2));
    assert_eq!(refusal(&[[1, 0]], &[], 0), SplitError::NoEdge(1, 0));
    assert_eq!(refusal(&[[0, 4], [0, 1]], &[], 0), SplitError::NoEdge(0, 1));
    assert_eq!(refusal(&[[0, 1], [0, 4], [1, 4]], &[], 4), SplitError::Cycle(1, 4));
    assert_eq!(refusal(&[[0, 4]], &[4], 2), SplitError::NotOpenable(4));
    assert_eq!(refusal(&[[0, 4]], &[2], 2), SplitError::NotOpenable(2));
    assert_eq!(refusal(&[[0, 4]], &[0], 1), SplitError::Fill);
    assert_eq!(refusal(&[[0, 4]], &[], 1), SplitError::Fill);
}

#[test]
fn bits_that_are_too_few_or_too_many_are_refused_and_others_never_panic() {
    let mut random = Rng::with_seed(7);
    let (_, fine) = terrain(40, &mut random);
    let (coarsening, bits) = round_trip(&fine, &largest_batch(&fine, random_cost(7)));
    let coarse = &coarsening.surface;
    let streams: [fn(&mut SplitBits) -> &mut Vec<bool>; 3] =
        [|bits| &mut bits.marks, |bits| &mut bits.opened, |bits| &mut bits.fills];
    for stream in streams {
        let mut longer = bits.clone();
        stream(&mut longer).push(false);
        assert!(matches!(
            ForestSplit::decode(&longer, coarse),
            Err(SplitError::BitCount(_))
        ));
        let mut shorter = bits.clone();
        stream(&mut shorter).pop();
        assert!(matches!(
            ForestSplit::decode(&shorter, coarse),
            Err(SplitError::BitCount(_))
        ));
        for index in 0..stream(&mut bits.clone()).len() {
            let mut changed = bits.clone();
            stream(&mut changed)[index] ^= true;
            if let Ok(refined) = ForestSplit::decode(&changed, coarse).and_then(|split| split.apply(coarse)) {
                let most = coarse.triangles().len() + 2 * coarse.edges().len();
                assert!(refined.surface.triangles().len() <= most);
            }
        }
    }
}
