//! Reading the inputs that several kinds share, and writing what they share.

use anyhow::{Context, Result};
use glam::DVec3;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use terrain_core::levels::collapse_list::{self, ListedCollapse};
use terrain_core::{CollapseLog, Mesh};

/// A value of a known shape under `key`.
pub(super) fn read<T: DeserializeOwned>(value: &Value, key: &str) -> Result<T> {
    let found = value.get(key).with_context(|| format!("{key:?} is missing"))?;
    T::deserialize(found).with_context(|| format!("{key:?} has another shape"))
}

/// The mesh of `positions` and `triangles`.
pub(super) fn mesh(vector: &Value) -> Result<Mesh> {
    Ok(Mesh {
        positions: read::<Vec<[f64; 3]>>(vector, "positions")?
            .into_iter()
            .map(DVec3::from_array)
            .collect(),
        triangles: read(vector, "triangles")?,
    })
}

/// A mesh without geometry, of as many vertices as the triangles use.
pub(super) fn mesh_of(triangles: Vec<[u32; 3]>) -> Mesh {
    let count = triangles.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    Mesh {
        positions: vec![DVec3::ZERO; count],
        triangles,
    }
}

/// The log of `collapses` and `moved`, where there is one, on `mesh`.
pub(super) fn log(vector: &Value, mesh: &Mesh) -> Result<CollapseLog> {
    let pairs: Vec<[u32; 2]> = read(vector, "collapses")?;
    let moved_to = |index: usize| {
        let moved = vector.get("moved")?.get(index.to_string())?;
        Some(<[f64; 3]>::deserialize(moved).map(DVec3::from_array))
    };
    let listed = pairs.iter().enumerate().map(|(index, &[blue, red])| {
        let moved_to = moved_to(index).transpose()?;
        Ok(ListedCollapse { blue, red, moved_to })
    });
    let list = listed.collect::<Result<Vec<_>>>()?;
    Ok(collapse_list::to_log(&list, &mesh.positions, f64::INFINITY)?)
}

/// Triangles as a set: each from its smallest corner on, sorted.
pub(super) fn triangle_set(triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let mut set: Vec<[u32; 3]> = triangles.into_iter().map(from_smallest).collect();
    set.sort_unstable();
    set
}

pub(super) fn from_smallest([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

pub(super) fn sorted(mut indices: Vec<u32>) -> Vec<u32> {
    indices.sort_unstable();
    indices
}

pub(super) fn position(position: DVec3) -> Value {
    json!(position.to_array())
}

/// An object with one entry for each level.
pub(super) fn by_level(entries: impl IntoIterator<Item = (u32, Value)>) -> Value {
    let keyed = entries.into_iter().map(|(level, value)| (level.to_string(), value));
    Value::Object(keyed.collect::<Map<_, _>>())
}
