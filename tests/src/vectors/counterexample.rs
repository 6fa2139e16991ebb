//! Kind `counterexample`: what the papers' rules make of meshes and errors that break their assumptions. Each case is
//! answered as far as its own inputs go, all of them inside `expected`: `vertices`, `triangles`, `collapses` and, for
//! the queues, `errors` and `max_error`. Those of forest splits are the cases whose names begin with `forest_`.

use std::collections::BTreeSet;

use anyhow::{Context, Result};
use glam::DVec3;
use serde_json::{Map, Value, json};
use terrain_core::levels::adaptive_surface::AdaptiveSurface;
use terrain_core::levels::dag::DagBuilder;
use terrain_core::levels::level_view::LevelView;
use terrain_core::levels::refinement_queues::RefinementQueues;
use terrain_core::levels::replay::{Demand, Replay};
use terrain_core::streaming::forest_split::{ClosedSurface, coarsen};
use terrain_core::{CollapseLog, Mesh, SurfacePartition};

use super::audit::Audit;
use super::{dag, input, partition};

const INPUTS: [&str; 5] = ["vertices", "triangles", "collapses", "errors", "max_error"];

pub(super) fn expected(vector: &Value) -> Result<Value> {
    let cases = vector["expected"].as_object().context("\"expected\" is missing")?;
    let answered = cases.iter().map(|(name, case)| {
        let of_forest = name.starts_with("forest_");
        let answer = if of_forest { forest(case) } else { collapses(case) };
        Ok((name.clone(), answer?))
    });
    Ok(Value::Object(answered.collect::<Result<Map<_, _>>>()?))
}

/// The case with nothing but its inputs.
fn question(case: &Value) -> Value {
    let inputs = INPUTS
        .iter()
        .filter_map(|&key| Some((key.to_owned(), case.get(key)?.clone())));
    Value::Object(inputs.collect())
}

fn mesh(case: &Value) -> Result<Mesh> {
    Ok(Mesh {
        positions: vec![DVec3::ZERO; input::read(case, "vertices")?],
        triangles: input::read(case, "triangles")?,
    })
}

/// Collapses whose removed triangles are a forest while their coarse edges are not one of trees apart: why the product
/// refuses to undo them with one split.
fn forest(case: &Value) -> Result<Value> {
    let mut answer = question(case);
    let mesh = mesh(case)?;
    let log = input::log(case, &mesh)?;
    let replay = Replay::run(&mesh, &log, Demand::Consistent, |_| ())?;
    let removed: Vec<usize> = (0..mesh.triangles.len())
        .filter(|&triangle| replay.triangle_levels[triangle] < replay.top_level)
        .collect();
    let partition = SurfacePartition::from_replay(&mesh, &replay, &replay.level_batches(&log, 0.0))?;
    let roots = partition::roots(&mut LevelView::new(&partition), &replay.vertex_order());
    let coarse_edge = |&triangle: &usize| mesh.triangles[triangle].map(|corner| roots[corner as usize]).into();
    let marked: BTreeSet<BTreeSet<u32>> = removed.iter().map(coarse_edge).collect();
    let fine = ClosedSurface::new(mesh.positions.len() as u32, &mesh.triangles)?;
    let refusal = coarsen(&fine, &input::read::<Vec<[u32; 2]>>(case, "collapses")?).err();
    answer["why"] = json!(refusal.map(|error| error.to_string()));
    answer["triangles_removed"] = json!(removed.len());
    answer["triangles_a_single_tree_of_these_edges_would_add"] = json!(2 * marked.len().saturating_sub(1));
    answer["removed"] = json!(removed);
    answer["marked_coarse_edges"] = json!(marked);
    Ok(answer)
}

fn collapses(case: &Value) -> Result<Value> {
    let mut answer = question(case);
    let mesh = mesh(case)?;
    let log = input::log(case, &mesh)?;
    let mut graph = DagBuilder::new(mesh.positions.len());
    let replay = Replay::run(&mesh, &log, Demand::Drawable, |step| graph.add(step))?;
    let graph = graph.finish();
    answer["dag"] = json!(dag::rows(&graph.all_influences()));
    if case.get("errors").is_some() {
        answer["performed_after"] = json!(performed_after(case, &mesh, &log)?);
    } else {
        answer["levels"] = json!(replay.collapse_levels);
        answer["lods"] = lods(&mesh, &log, &replay)?;
        let audit = Audit::new(&mesh.triangles, &input::read::<Vec<[u32; 2]>>(case, "collapses")?);
        answer["bad_lods"] = audit.bad_levels(&replay.collapse_levels, replay.top_level);
        answer["bad_sets"] = audit.bad_sets(&graph, &dag::closed_sets(&graph).context("too many collapses")?);
    }
    Ok(answer)
}

/// Every level as pairs of a triangle's index and its corners.
fn lods(mesh: &Mesh, log: &CollapseLog, replay: &Replay) -> Result<Value> {
    let partition = SurfacePartition::from_replay(mesh, replay, &replay.level_batches(log, 0.0))?;
    let (vertices, triangles) = (replay.vertex_order(), replay.triangle_order());
    let mut view = LevelView::new(&partition);
    let levels = (1..=replay.top_level).map(|level| {
        view.set_level((replay.top_level - level) as usize);
        let corners = view
            .triangles()
            .map(|triangle| triangle.map(|corner| vertices[corner as usize]));
        let mut drawn: Vec<(u32, [u32; 3])> = triangles.iter().copied().zip(corners).collect();
        drawn.sort_unstable();
        (level, json!(drawn))
    });
    Ok(input::by_level(levels.collect::<Vec<_>>()))
}

fn performed_after(case: &Value, mesh: &Mesh, log: &CollapseLog) -> Result<Vec<u32>> {
    let (errors, maximum): (Vec<f64>, f64) = (input::read(case, "errors")?, input::read(case, "max_error")?);
    let mut surface = AdaptiveSurface::new(mesh, log)?;
    let error = |collapse: u32| errors.get(collapse as usize).copied().unwrap_or(f64::INFINITY);
    RefinementQueues::new(&surface, error).update(&mut surface, maximum, error);
    Ok(dag::performed(&surface))
}
