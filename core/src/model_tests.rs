#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]
use std::time::Instant;
use super::*;
use crate::partition::SurfacePartition;

fn load(name: &str) -> Mesh {
    let text = std::fs::read_to_string(format!("/work/shared/data/meshes/{name}")).unwrap();
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let mut w = line.split_whitespace();
        match w.next() {
            Some("v") => { let v: Vec<f64> = w.map(|x| x.parse().unwrap()).collect(); mesh.positions.push(DVec3::new(v[0], v[1], v[2])); }
            Some("f") => { let v: Vec<u32> = w.map(|x| x.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect(); mesh.triangles.push([v[0], v[1], v[2]]); }
            _ => {}
        }
    }
    mesh
}
fn one_sided(mesh: &Mesh, tree: &SurfaceTree, enough: f64) -> (f64, f64) {
    let c = |t: &[u32;3]| t.map(|v| mesh.positions[v as usize]);
    let found = mesh.triangles.iter().map(|t| tree.distance((c(t)[0]+c(t)[1]+c(t)[2])/3.0)).fold(0.0, f64::max);
    let enough = enough;
    (found, mesh.triangles.iter().map(|t| tree.bound(c(t), enough)).fold(0.0, f64::max))
}
#[test]
fn experiment() {
    let name = std::env::var("M").unwrap_or("stanford-bunny.obj".into());
    let placement = if std::env::var("STAY").is_ok() { Placement::Stay } else { Placement::Best };
    let mesh = load(&name);
    let (low, high) = mesh.bounds();
    let d = low.distance(high);
    let s = Instant::now();
    let mut m = ModelSimplifier::new(&mesh, placement).unwrap();
    let goal = Goal { tolerance: f64::INFINITY, triangles: std::env::var("N").map_or(0, |n| n.parse().unwrap()) };
    let mut tol = vec![];
    loop { let more = m.next_band(goal); tol.push((m.tolerance, m.log().bands.len(), m.round)); println!("{:.2} s tol {:.3e} triangles {} rounds {}", s.elapsed().as_secs_f64(), m.tolerance/d, m.triangle_count(), m.round); if !more { break } }
    let p = SurfacePartition::from_log(&mesh, m.log(), 0.0).unwrap();
    if std::env::var("Q").is_ok() { return }
    let tree = SurfaceTree::new(&mesh);
    for k in 0..p.levels.len()-1 {
        let lod = p.lod(k);
        let band = m.log().bands.len()-1-k;
        let t = tol.iter().find(|x| x.1 == band+1).unwrap().0;
        let s = Instant::now();
        let back = one_sided(&lod, &tree, t);
        let t1 = s.elapsed().as_secs_f64();
        let forth = one_sided(&mesh, &SurfaceTree::new(&lod), t);
        println!("level {k}: {} triangles tol {:.3e} forth {:.3} {:.3} back {:.3} {:.3} of tol; {t1:.2} {:.2}", lod.triangles.len(), t/d, forth.0/t, forth.1/t, back.0/t, back.1/t, s.elapsed().as_secs_f64()-t1);
    }
}
