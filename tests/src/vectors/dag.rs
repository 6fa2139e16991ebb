//! Kind `dag`: the graph of the collapses, closed sets, queues and forced splits. Inputs inside `expected`:
//! `closed_sets[].performed`, `dual_queue[].max_error` and `.errors`, `forced_splits[].want`.

use std::collections::BTreeSet;

use anyhow::{Result, ensure};
use serde_json::{Value, json};
use terrain_core::levels::adaptive_surface::AdaptiveSurface;
use terrain_core::levels::dag::CollapseDag;
use terrain_core::levels::refinement_queues::RefinementQueues;
use terrain_core::topology::compressed_rows::CompressedRows;

use super::input;

/// Closed sets are counted up to so many collapses.
const MOST_COUNTED: usize = 20;

pub(super) fn expected(vector: &Value) -> Result<Value> {
    let mesh = input::mesh(vector)?;
    let collapsed = AdaptiveSurface::new(&mesh, &input::log(vector, &mesh)?)?;
    let dag = collapsed.dag();
    let literal = dag.all_influences();
    Ok(json!({
        "collapse_constraints": rows(&literal),
        "split_constraints": rows(&literal.transposed()),
        "reduced": rows(&dag.transitive_reduction()),
        "number_of_closed_sets": closed_sets(dag).map(|sets| sets.len()),
        "closed_sets": each(vector, "closed_sets", |case| closed_set(&collapsed, case))?,
        "dual_queue": dual_queue(&collapsed, vector)?,
        "forced_splits": each(vector, "forced_splits", |case| forced_splits(&collapsed, case))?,
    }))
}

pub(super) fn rows(rows: &CompressedRows) -> Vec<&[u32]> {
    rows.rows().collect()
}

/// An answer to each case of a list; to none where the vector has no such list.
fn each(vector: &Value, key: &str, answer: impl FnMut(&Value) -> Result<Value>) -> Result<Vec<Value>> {
    let cases = vector["expected"][key].as_array().into_iter().flatten();
    cases.map(answer).collect()
}

/// All closed sets of a small graph, a bit for each collapse: each set either leaves a collapse out or holds all that it
/// needs.
pub(super) fn closed_sets(dag: &CollapseDag) -> Option<Vec<u32>> {
    if dag.len() > MOST_COUNTED {
        return None;
    }
    let mut closed: Vec<u32> = vec![0];
    for collapse in 0..dag.len() as u32 {
        let needed = dag
            .constraints(collapse)
            .iter()
            .fold(0, |set, needed| set | 1 << needed);
        let may_hold = closed.iter().filter(|&set| set & needed == needed);
        let holding: Vec<u32> = may_hold.map(|set| set | 1 << collapse).collect();
        closed.extend(holding);
    }
    Some(closed)
}

fn closed_set(collapsed: &AdaptiveSurface, case: &Value) -> Result<Value> {
    let performed: Vec<u32> = input::read(case, "performed")?;
    let set: BTreeSet<u32> = performed.iter().copied().collect();
    ensure!(
        collapsed.dag().is_closed(|collapse| set.contains(&collapse)),
        "{performed:?} is not a closed set"
    );
    let mut surface = collapsed.clone();
    for collapse in (0..surface.dag().len() as u32)
        .rev()
        .filter(|collapse| !set.contains(collapse))
    {
        surface.split(collapse);
    }
    Ok(json!({
        "performed": performed,
        "triangles": triangles(&surface),
        "splittable": input::sorted(surface.splittable().to_vec()),
        "collapsible": input::sorted(surface.collapsible().to_vec()),
    }))
}

fn dual_queue(collapsed: &AdaptiveSurface, vector: &Value) -> Result<Vec<Value>> {
    let mut surface = collapsed.clone();
    let mut queues = RefinementQueues::new(&surface, |_| 0.0);
    each(vector, "dual_queue", |step| {
        let maximum: f64 = input::read(step, "max_error")?;
        let errors: Vec<f64> = input::read(step, "errors")?;
        ensure!(
            errors.len() == surface.dag().len(),
            "one error is needed for each collapse"
        );
        let error = |collapse: u32| errors[collapse as usize];
        queues.refill(&surface, error);
        let changes = queues.update(&mut surface, maximum, error);
        Ok(json!({
            "max_error": step["max_error"],
            "errors": step["errors"],
            "performed": performed(&surface),
            "splits": changes.splits,
            "collapses": changes.collapses,
            "triangles": triangles(&surface),
        }))
    })
}

fn forced_splits(collapsed: &AdaptiveSurface, case: &Value) -> Result<Value> {
    let want: Vec<u32> = input::read(case, "want")?;
    let mut surface = collapsed.clone();
    let mut split = Vec::new();
    for &collapse in &want {
        ensure!(
            (collapse as usize) < surface.dag().len(),
            "there is no collapse {collapse}"
        );
        split.extend(surface.force_split(collapse));
    }
    Ok(json!({ "want": want, "split": input::sorted(split), "triangles": triangles(&surface) }))
}

pub(super) fn performed(surface: &AdaptiveSurface) -> Vec<u32> {
    let all = 0..surface.dag().len() as u32;
    all.filter(|&collapse| surface.is_performed(collapse)).collect()
}

fn triangles(surface: &AdaptiveSurface) -> Vec<[u32; 3]> {
    input::triangle_set(surface.triangles().iter().map(|&triangle| surface.corners(triangle)))
}
