//! The paper's table: seconds, levels, patches and certified errors of curved models, each simplified to a number of patches.
//!
//! ```sh
//! cargo run --release -p terrain-tests --example curved_levels -- bunny.obj 1000 teapot.bez 20
//! ```

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use glam::DVec3;
use terrain_core::curved::model::CurvedModel;
use terrain_core::curved::simplify::{Options, simplify};
use terrain_core::curved::tensor::Bicubic;
use terrain_ingest::polygonal_model;
use terrain_tiles::formats::polygons::PolygonLimits;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    for pair in arguments.chunks(2) {
        let patches: usize = pair[1].parse()?;
        let start = Instant::now();
        let model = read(&PathBuf::from(&pair[0]))?;
        let (low, high) = bounds(&model);
        let diagonal = low.distance(high);
        let given = model.patches().len();
        let made = Instant::now();
        let levels = simplify(
            model,
            &Options {
                patches,
                ..Options::default()
            },
            |_| (),
        );
        let done = Instant::now();
        println!(
            "{} {given} patches: read {:.2} s, simplified {:.2} s, {} levels, {} bytes = {:.2} of input",
            pair[0],
            (made - start).as_secs_f64(),
            (done - made).as_secs_f64(),
            levels.len(),
            levels.bytes(),
            levels.bytes() as f64 / (given as f64 * 192.0)
        );
        for level in (0..levels.len()).step_by(8).chain([levels.len() - 1]) {
            println!(
                "  {level:4} {:7} patches, error {:.5} % of the diagonal",
                levels.patch_count(level),
                100.0 * levels.error(level) / diagonal
            );
        }
    }
    Ok(())
}

fn bounds(model: &CurvedModel) -> (DVec3, DVec3) {
    let points = model.patches().iter().flat_map(|patch| patch.points);
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| {
        (low.min(at), high.max(at))
    })
}

fn read(path: &Path) -> Result<CurvedModel> {
    if path.extension().is_some_and(|extension| extension == "bez") {
        let text = std::fs::read_to_string(path)?;
        let mut numbers = text.split_whitespace();
        let count: usize = numbers.next().context("no count")?.parse()?;
        let numbers: Vec<f64> = numbers.map(str::parse).collect::<Result<_, _>>()?;
        let points: Vec<DVec3> = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
        let bicubics: Vec<Bicubic> = points
            .chunks_exact(16)
            .take(count)
            .map(|p| std::array::from_fn(|i| std::array::from_fn(|j| p[4 * i + j])))
            .collect();
        return Ok(CurvedModel::from_bicubics(&bicubics));
    }
    let model = polygonal_model::read(path, PolygonLimits::default())?;
    let mesh = &model.mesh;
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a);
        corners.iter().for_each(|&corner| normals[corner as usize] += normal);
    }
    let normals: Vec<[DVec3; 3]> = mesh
        .triangles
        .iter()
        .map(|corners| corners.map(|corner| normals[corner as usize].try_normalize().unwrap_or(DVec3::Z)))
        .collect();
    Ok(CurvedModel::from_mesh(mesh, &normals)?)
}
