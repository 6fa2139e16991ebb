//! Kind `collapse_validity`: the link condition, boundary part included. Inputs inside `expected`: `cases[].mesh`,
//! `.blue` and `.red`.

use anyhow::{Context, Result};
use serde_json::{Value, json};
use terrain_core::topology::connectivity::{Connectivity, EdgeStar};
use terrain_core::topology::manifold;

use super::input;

pub(super) fn expected(vector: &Value) -> Result<Value> {
    let meshes: Vec<Vec<[u32; 3]>> = input::read(vector, "meshes")?;
    let surfaces = meshes.into_iter().map(connectivity).collect::<Result<Vec<_>>>()?;
    let cases: Vec<Value> = input::read(&vector["expected"], "cases")?;
    let answer = |case: &Value| {
        let (mesh, blue, red): (usize, u32, u32) = (
            input::read(case, "mesh")?,
            input::read(case, "blue")?,
            input::read(case, "red")?,
        );
        let surface = surfaces.get(mesh).with_context(|| format!("there is no mesh {mesh}"))?;
        let valid = is_valid(surface, blue, red);
        Ok(json!({ "mesh": mesh, "blue": blue, "red": red, "valid": valid }))
    };
    let answers = cases.iter().map(answer).collect::<Result<Vec<_>>>()?;
    Ok(json!({ "cases": answers }))
}

fn connectivity(triangles: Vec<[u32; 3]>) -> Result<Connectivity> {
    let mesh = input::mesh_of(triangles);
    manifold::check_corners(&mesh)?;
    Ok(Connectivity::new(&mesh))
}

fn is_valid(surface: &Connectivity, blue: u32, red: u32) -> bool {
    if blue == red || blue.max(red) as usize >= surface.vertex_count() {
        return false;
    }
    let mut star = EdgeStar::default();
    star.gather(surface, blue, red);
    star.link_condition().is_ok()
}
