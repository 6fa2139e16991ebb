//! Kinds `multilevel` and `malformed`: what a text in the papers' format says. Input inside `expected`:
//! `geomorphs[].level`.

use anyhow::{Result, bail};
use serde_json::{Map, Value, json};
use terrain_core::SurfacePartition;
use terrain_core::levels::replay::{Demand, Replay};
use terrain_core::streaming::multilevel::{LevelView, MultilevelLimits, MultilevelMesh, to_ascii};

use super::input;

pub(super) fn expected(vector: &Value) -> Result<Value> {
    match dimension(vector)? {
        2 => of_text::<2>(vector),
        3 => of_text::<3>(vector),
        other => bail!("vertices of {other} numbers are not answered"),
    }
}

/// Whether every text is refused.
pub(super) fn malformed(vector: &Value) -> Result<Value> {
    let texts: Vec<String> = input::read(vector, "texts")?;
    let is_refused: fn(&str) -> bool = match dimension(vector)? {
        2 => |text| MultilevelMesh::<2>::from_ascii(text, MultilevelLimits::default()).is_err(),
        3 => |text| MultilevelMesh::<3>::from_ascii(text, MultilevelLimits::default()).is_err(),
        other => bail!("vertices of {other} numbers are not answered"),
    };
    Ok(json!({ "all_rejected": texts.iter().all(|text| is_refused(text)) }))
}

/// How many numbers a vertex is: three where nothing is said.
pub(super) fn dimension(vector: &Value) -> Result<usize> {
    match vector.get("dimension") {
        Some(_) => input::read(vector, "dimension"),
        None => Ok(3),
    }
}

fn of_text<const DIMENSION: usize>(vector: &Value) -> Result<Value> {
    let text: String = input::read(vector, "text")?;
    let mesh = MultilevelMesh::<DIMENSION>::from_ascii(&text, MultilevelLimits::default())?;
    let mut expected = levels(&mesh, vector)?;
    if vector.get("collapses").is_some() {
        expected["all_representatives"] = representatives(&of_collapses(vector)?);
    }
    Ok(expected)
}

/// The mesh that the vector's collapses make, in the papers' format.
///
/// # Errors
/// Where the inputs are not those of a mesh and its collapses.
pub fn text_of_collapses(vector: &Value) -> Result<String> {
    Ok(to_ascii(&of_collapses(vector)?))
}

/// The mesh that the vector's collapses make, one level for each of the partition.
fn of_collapses(vector: &Value) -> Result<MultilevelMesh> {
    let mesh = input::mesh(vector)?;
    let log = input::log(vector, &mesh)?;
    let replay = Replay::run(&mesh, &log, Demand::Consistent, |_| ())?;
    let partition = SurfacePartition::from_replay(&mesh, &replay, &replay.level_batches(&log, 0.0))?;
    Ok(MultilevelMesh::from_partition(&partition)?)
}

/// The arrays of a mesh, its levels of detail, and the geomorphs that the vector asks for.
pub(super) fn levels<const DIMENSION: usize>(mesh: &MultilevelMesh<DIMENSION>, vector: &Value) -> Result<Value> {
    let count = mesh.level_count();
    let mut view = LevelView::default();
    let mut lods = Vec::with_capacity(count);
    for level in 0..count {
        view.set_level(mesh, level)?;
        lods.push(json!(view.triangles()));
    }
    let ends = || (0..count).filter_map(|level| mesh.end(level));
    Ok(json!({
        "levels": count,
        "vertices_in_lod": ends().map(|end| end.vertices).collect::<Vec<_>>(),
        "triangles_in_lod": ends().map(|end| end.triangles).collect::<Vec<_>>(),
        "representatives": representatives(mesh),
        "triangles": mesh.triangles(),
        "positions": positions(mesh.positions()),
        "lods": lods,
        "geomorphs": geomorphs(mesh, vector)?,
    }))
}

pub(super) fn representatives<const DIMENSION: usize>(mesh: &MultilevelMesh<DIMENSION>) -> Value {
    let pairs = mesh.representatives();
    let keyed = pairs.map(|(vertex, representative)| (vertex.to_string(), json!(representative)));
    Value::Object(keyed.collect::<Map<_, _>>())
}

fn geomorphs<const DIMENSION: usize>(mesh: &MultilevelMesh<DIMENSION>, vector: &Value) -> Result<Vec<Value>> {
    let Some(asked) = vector["expected"].get("geomorphs") else {
        return Ok(Vec::new());
    };
    let mut view = LevelView::default();
    let geomorph = |asked: &Value| {
        view.set_fractional_level(mesh, input::read::<f64>(asked, "level")?)?;
        Ok(json!({
            "level": asked["level"],
            "triangles": view.triangles(),
            "positions": positions(view.positions()),
        }))
    };
    asked.as_array().into_iter().flatten().map(geomorph).collect()
}

fn positions<const DIMENSION: usize>(positions: &[[f64; DIMENSION]]) -> Vec<&[f64]> {
    positions.iter().map(<[f64; DIMENSION]>::as_slice).collect()
}
