//! Kind `clustering`: what vertex clusterings make of a mesh. Input inside `expected`: `geomorphs[].level`.

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use terrain_core::streaming::clustering::{Clustering, clustered_mesh};
use terrain_core::streaming::multilevel::{LevelView, to_ascii};

use super::{input, multilevel};

pub(super) fn expected(vector: &Value) -> Result<Value> {
    match multilevel::dimension(vector)? {
        2 => clustered::<2>(vector),
        3 => clustered::<3>(vector),
        other => bail!("vertices of {other} numbers are not answered"),
    }
}

fn clustered<const DIMENSION: usize>(vector: &Value) -> Result<Value> {
    let vertices = positions::<DIMENSION>(vector)?;
    let triangles: Vec<[u32; 3]> = input::read(vector, "triangles")?;
    let steps: Vec<Value> = input::read(vector, "clusterings")?;
    let steps = steps.iter().map(clustering).collect::<Result<Vec<_>>>()?;
    let mut clustered = clustered_mesh(&vertices, &triangles, &steps)?;
    let all_representatives = multilevel::representatives(&clustered.mesh);
    clustered.mesh.keep_needed_representatives();
    let mut view = LevelView::default();
    let mut lods = Vec::new();
    for level in 0..clustered.mesh.level_count() {
        view.set_level(&clustered.mesh, level)?;
        let original = |&corners: &[u32; 3]| corners.map(|vertex| clustered.vertex_order[vertex as usize]);
        lods.push(input::triangle_set(view.triangles().iter().map(original)));
    }
    let mut expected = multilevel::levels(&clustered.mesh, vector)?;
    expected["vertex_order"] = json!(clustered.vertex_order);
    expected["triangle_order"] = json!(clustered.triangle_order);
    expected["all_representatives"] = all_representatives;
    expected["lods_in_original_ids"] = json!(lods);
    expected["text"] = json!(to_ascii(&clustered.mesh));
    Ok(expected)
}

fn clustering<const DIMENSION: usize>(value: &Value) -> Result<Clustering<DIMENSION>> {
    Ok(Clustering {
        positions: positions(value)?,
        mapping: input::read(value, "mapping")?,
    })
}

fn positions<const DIMENSION: usize>(value: &Value) -> Result<Vec<[f64; DIMENSION]>> {
    let rows: Vec<Vec<f64>> = input::read(value, "positions")?;
    let position = |row: Vec<f64>| row.try_into().ok().context("a position of another dimension");
    rows.into_iter().map(position).collect()
}
