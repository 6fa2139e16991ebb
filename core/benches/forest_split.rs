//! What batches of forest splits cost: CPU microseconds to choose one and bits for each triangle that it adds.
//!
//! `cargo bench -p terrain-core --bench forest_split`

use cpu_time::ProcessTime;
use spade::{DelaunayTriangulation, Point2, Triangulation};
use terrain::{Terrain, simplifier};
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::simplify::{Allowance, Quality};
use terrain_core::streaming::forest_split::{ClosedSurface, coarsen, forest_batches, largest_batch};
use terrain_core::{CollapseLog, Mesh};

mod terrain;

fn main() {
    println!("one batch that about halves a Delaunay triangulation of random points");
    println!(
        "{:>9}  {:>11}  {:>13}  {:>12}  {:>10}",
        "triangles", "collapses", "chosen", "µs/triangle", "bits/added"
    );
    for point_count in [10_000, 50_000, 250_000] {
        let (points, surface) = delaunay(point_count);
        let started = ProcessTime::now();
        let batch = largest_batch(&surface, |blue, red, kept| short_edges_first(&points, blue, red, kept));
        report("short first", &surface, &batch, started);
        let started = ProcessTime::now();
        let batch = largest_batch(&surface, |blue, red, _| Some(any_order(blue, red)));
        report("any order", &surface, &batch, started);
    }
    println!("\nthe log of a simplifier, from 5 to 40 m in steps of √2, cut into batches");
    let (mesh, log) = log_of_terrain();
    let surface =
        ClosedSurface::new(mesh.positions.len() as u32, &mesh.triangles).expect("a square grid is a manifold");
    report_log(surface, &log);
}

fn report(order: &str, fine: &ClosedSurface, batch: &[[u32; 2]], started: ProcessTime) {
    let triangles = fine.triangles().len();
    let microseconds = started.elapsed().as_secs_f64() * 1e6 / triangles as f64;
    let (_, bits, added) = split(fine, batch);
    println!(
        "{triangles:>9}  {order:>11}  {:>13}  {microseconds:>12.1}  {:>10.2}",
        batch.len(),
        bits as f64 / added as f64
    );
}

/// The coarser surface, the bits of the batch and how many triangles it adds.
fn split(fine: &ClosedSurface, batch: &[[u32; 2]]) -> (ClosedSurface, usize, usize) {
    let coarsening = coarsen(fine, batch).expect("the batch is one forest");
    let bits = coarsening
        .split
        .encode(&coarsening.surface)
        .expect("a split of this surface");
    let added = fine.triangles().len() - coarsening.surface.triangles().len();
    (coarsening.surface, bits.len(), added)
}

fn delaunay(point_count: usize) -> (Vec<Point2<f64>>, ClosedSurface) {
    let mut random = fastrand::Rng::with_seed(1);
    let points = (0..point_count).map(|_| Point2::new(random.f64(), random.f64()));
    let triangulation = DelaunayTriangulation::<Point2<f64>>::bulk_load(points.collect()).expect("points are finite");
    let faces = triangulation.inner_faces();
    let corners = faces.map(|face| face.vertices().map(|vertex| vertex.index() as u32));
    let surface = ClosedSurface::new(point_count as u32, &corners.collect::<Vec<_>>()).expect("it is a manifold");
    let points = triangulation.vertices().map(|vertex| vertex.position()).collect();
    (points, surface)
}

/// The length of the edge; None where a triangle would turn over.
fn short_edges_first(points: &[Point2<f64>], blue: u32, red: u32, kept: &[[u32; 3]]) -> Option<f64> {
    let at = |vertex: u32| points[vertex as usize];
    let is_upright = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|vertex| at(if vertex == blue { red } else { vertex }));
        (b.x - a.x) * (c.y - a.y) > (b.y - a.y) * (c.x - a.x)
    };
    let (from, to) = (at(blue), at(red));
    kept.iter()
        .all(is_upright)
        .then(|| (to.x - from.x).hypot(to.y - from.y))
}

fn any_order(blue: u32, red: u32) -> f64 {
    fastrand::Rng::with_seed((u64::from(blue) << 32) ^ u64::from(red)).f64()
}

fn log_of_terrain() -> (Mesh, CollapseLog) {
    Terrain::new(513).thinned(5.0, Bound::Surface, Quality::Default, |thinned| {
        let mut simplifier = simplifier(thinned.into_surface(), Quality::Default);
        let (mesh, _) = simplifier.surface().mesh();
        for rung in 0..7 {
            let vertical = 5.0 * (f64::from(rung) / 2.0).exp2();
            simplifier.simplify(Allowance {
                vertical,
                outline: 0.0,
                breaklines: 0.0,
            });
        }
        (mesh, simplifier.log().clone())
    })
}

fn report_log(mut surface: ClosedSurface, log: &CollapseLog) {
    let collapses: Vec<[u32; 2]> = log.collapses.iter().map(|c| [c.blue, c.red]).collect();
    let started = ProcessTime::now();
    let batches = forest_batches(&surface, &collapses).expect("the log is made of valid collapses");
    let seconds = started.elapsed().as_secs_f64();
    let triangles = surface.triangles().len();
    let mut names: Vec<u32> = (0..surface.vertex_count()).collect();
    let (mut all_bits, mut all_added) = (0, 0);
    for batch in &batches {
        let own = |vertex: u32| names.binary_search(&vertex).expect("the vertex is still there") as u32;
        let ends = batch.iter().map(|&index| collapses[index as usize]);
        let renamed: Vec<[u32; 2]> = ends.clone().map(|ends| ends.map(own)).collect();
        let (coarse, bits, added) = split(&surface, &renamed);
        if added > triangles / 20 {
            println!(
                "{:>9} from {:>9}  {:>6.2} bits/added",
                added,
                coarse.triangles().len(),
                bits as f64 / added as f64
            );
        }
        let mut blues: Vec<u32> = ends.map(|[blue, _]| blue).collect();
        blues.sort_unstable();
        names.retain(|vertex| blues.binary_search(vertex).is_err());
        surface = coarse;
        (all_bits, all_added) = (all_bits + bits, all_added + added);
    }
    println!(
        "{all_added} of {triangles} triangles in {} batches: {:.2} bits each; cut in {seconds:.1} s",
        batches.len(),
        all_bits as f64 / all_added as f64
    );
}
