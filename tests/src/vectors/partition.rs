//! Kind `partition`: levels, representatives and every level of detail. Input inside `expected`:
//! `merged.first_level_of_group`.

use anyhow::Result;
use glam::DVec3;
use serde_json::{Value, json};
use terrain_core::levels::level_view::LevelView;
use terrain_core::levels::replay::{Batch, Demand, Replay};
use terrain_core::{CollapseLog, Mesh, SurfacePartition};

use super::input;

pub(super) fn expected(vector: &Value) -> Result<Value> {
    let mesh = input::mesh(vector)?;
    let log = input::log(vector, &mesh)?;
    let (replay, mut expected) = replayed(&mesh, &log)?;
    let partition = SurfacePartition::from_replay(&mesh, &replay, &replay.level_batches(&log, 0.0))?;
    let has_moved = vector["moved"].as_object().is_some_and(|moved| !moved.is_empty());
    let mut parts = vec![of_vertices(&replay), lods(&replay, &partition, has_moved)];
    if has_moved {
        parts.push(moved_positions(&replay));
    }
    parts.push(json!({
        "sorted": in_sorted_order(&replay, &partition),
        "bytes": bytes(&partition),
    }));
    let groups = &vector["expected"]["merged"];
    if groups.is_object() {
        let first_levels: Vec<u32> = input::read(groups, "first_level_of_group")?;
        parts.push(json!({ "merged": merged(&mesh, &replay, &first_levels)? }));
    }
    for part in parts {
        if let (Value::Object(all), Value::Object(part)) = (&mut expected, part) {
            all.extend(part);
        }
    }
    Ok(expected)
}

/// Replays, and tells what each collapse met.
fn replayed(mesh: &Mesh, log: &CollapseLog) -> Result<(Replay, Value)> {
    let (mut kinds, mut stars, mut blue_triangles) = (Vec::new(), Vec::new(), Vec::new());
    let replay = Replay::run(mesh, log, Demand::Consistent, |step| {
        let removed = input::sorted(step.star.removed().to_vec());
        kinds.push(if removed.len() == 1 { "boundary" } else { "interior" });
        stars.push(input::sorted(step.star.vertices().to_vec()));
        blue_triangles.push(removed);
    })?;
    let expected = json!({
        "levels": replay.top_level,
        "level_of_collapse": replay.collapse_levels,
        "collapse_kind": kinds,
        "edge_star_vertices": stars,
        "blue_triangles": blue_triangles,
    });
    Ok((replay, expected))
}

fn of_vertices(replay: &Replay) -> Value {
    let or_minus_one = |found: &Option<u32>| found.map_or(-1, i64::from);
    let triangle_representatives: Vec<i64> = replay.triangle_representatives.iter().map(or_minus_one).collect();
    json!({
        "vertex_level": replay.vertex_levels,
        "triangle_level": replay.triangle_levels,
        "representative": replay.representatives,
        "triangle_representative": triangle_representatives,
    })
}

/// Goes through the levels from the finest to the coarsest and writes each in the mesh's numbering.
fn lods(replay: &Replay, partition: &SurfacePartition, has_moved: bool) -> Value {
    let (vertex_order, triangle_order) = (replay.vertex_order(), replay.triangle_order());
    let mut view = LevelView::new(partition);
    let (mut pc_rep, mut vertices, mut ids, mut surfaces, mut positions) =
        <(Vec<_>, Vec<_>, Vec<_>, Vec<_>, Vec<_>)>::default();
    for level in 1..=replay.top_level {
        view.set_level((replay.top_level - level) as usize);
        let ends = partition.levels[view.level()];
        let live = &vertex_order[..ends.vertex_end as usize];
        pc_rep.push((level, json!(roots(&mut view, &vertex_order))));
        vertices.push((level, json!(input::sorted(live.to_vec()))));
        ids.push((
            level,
            json!(input::sorted(triangle_order[..ends.triangle_end as usize].to_vec())),
        ));
        surfaces.push((level, json!(surface(&mut view, &vertex_order))));
        let placed = live
            .iter()
            .copied()
            .zip(view.positions().iter().map(|&p| input::position(p)));
        positions.push((level, input::by_level(placed)));
    }
    let mut lods = json!({
        "pc_rep": input::by_level(pc_rep),
        "lod_vertices": input::by_level(vertices),
        "lod_triangle_ids": input::by_level(ids),
        "lods": input::by_level(surfaces),
    });
    if has_moved {
        lods["positions_in_lod"] = input::by_level(positions);
    }
    lods
}

/// The path-compressed representative of each vertex, in the mesh's numbering.
pub(super) fn roots(view: &mut LevelView, order: &[u32]) -> Vec<u32> {
    let mut roots = vec![0; order.len()];
    for (place, &vertex) in (0..).zip(order) {
        roots[vertex as usize] = order[view.root(place) as usize];
    }
    roots
}

fn surface(view: &mut LevelView, order: &[u32]) -> Vec<[u32; 3]> {
    input::triangle_set(
        view.triangles()
            .map(|triangle| triangle.map(|corner| order[corner as usize])),
    )
}

fn moved_positions(replay: &Replay) -> Value {
    let red: Vec<Value> = replay.positions.red.iter().copied().map(input::position).collect();
    let saved = |(vertex, &position): (usize, &DVec3)| {
        let is_red = replay.representatives[vertex] as usize == vertex;
        (!is_red).then(|| input::position(position))
    };
    let blue: Vec<Option<Value>> = replay.positions.blue.iter().enumerate().map(saved).collect();
    json!({ "final_positions": red, "blue_positions": blue })
}

fn in_sorted_order(replay: &Replay, partition: &SurfacePartition) -> Value {
    let finest_first = || partition.levels.iter().rev();
    json!({
        "vertex_order": replay.vertex_order(),
        "triangle_order": replay.triangle_order(),
        "representative": partition.representatives,
        "triangles": partition.triangles,
        "vertices_in_lod": finest_first().map(|level| level.vertex_end).collect::<Vec<_>>(),
        "triangles_in_lod": finest_first().map(|level| level.triangle_end).collect::<Vec<_>>(),
    })
}

fn bytes(partition: &SurfacePartition) -> Value {
    let storage = partition.storage();
    let vertices = partition.positions.len();
    json!({
        "generic": storage.mesh,
        "surface_partition": storage.mesh + storage.representatives,
        "blue_positions_paper": storage.blue_positions_whole,
        "blue_positions_needed": storage.blue_positions,
        "claim_generic_36n": 36 * vertices,
        "claim_partition_lt_40n": 40 * vertices,
    })
}

/// The partition whose levels are groups of raw levels, finest group first.
fn merged(mesh: &Mesh, replay: &Replay, first_levels: &[u32]) -> Result<Value> {
    let batch = |&first_level: &u32| Batch {
        first_level,
        error: 0.0,
    };
    let batches: Vec<Batch> = first_levels.iter().map(batch).collect();
    let partition = SurfacePartition::from_replay(mesh, replay, &batches)?;
    let order = replay.vertex_order();
    let mut view = LevelView::new(&partition);
    let lods: Vec<_> = (0..partition.levels.len())
        .rev()
        .map(|level| {
            view.set_level(level);
            surface(&mut view, &order)
        })
        .collect();
    let finest_first = || partition.levels.iter().rev();
    Ok(json!({
        "first_level_of_group": first_levels,
        "vertices_in_lod": finest_first().map(|level| level.vertex_end).collect::<Vec<_>>(),
        "triangles_in_lod": finest_first().map(|level| level.triangle_end).collect::<Vec<_>>(),
        "lods": lods,
    }))
}
