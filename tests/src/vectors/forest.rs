//! Kinds `forest_split` and `forest_counts`: the split that undoes collapses, and what splits cost. Inputs inside `expected`:
//! of `forest_counts`, `cases[].triangles` and `cases[].spanning_tree`.

use anyhow::Result;
use serde_json::{Value, json};
use terrain_core::streaming::forest_split::{ClosedSurface, ForestSplit, coarsen};

use super::input;

pub(super) fn split(vector: &Value) -> Result<Value> {
    let fine_triangles: Vec<[u32; 3]> = input::read(vector, "fine_triangles")?;
    let fine = ClosedSurface::new(input::read(vector, "fine_vertices")?, &fine_triangles)?;
    let collapses: Vec<[u32; 2]> = input::read(vector, "collapses")?;
    let coarse_triangles: Vec<[u32; 3]> = input::read(vector, "coarse_triangles")?;
    let coarse = ClosedSurface::new(input::read(vector, "coarse_vertices")?, &coarse_triangles)?;
    let coarsening = coarsen(&fine, &collapses)?;
    // What is answered has gone through the product's own bits.
    let bits = coarsening.split.encode(&coarse)?;
    let split = ForestSplit::decode(&bits, &coarse)?;
    let refined = split.apply(&coarse)?;
    let trees = split.trees(&coarse)?;
    let mut fill = split.fill.as_slice();
    let fills = trees.iter().map(|tree| {
        let (own, others) = fill.split_at((2 * tree.len() - 2).min(fill.len()));
        fill = others;
        as_bits(own.as_flattened())
    });
    Ok(json!({
        "fills": fills.collect::<Vec<_>>(),
        "mark_bits": as_bits(&mark_bits(&coarse, &split.edges)),
        "fill_bits": as_bits(split.fill.as_flattened()),
        "gap_polygons": refined.gaps,
        "refined_vertices": refined.surface.vertex_count(),
        "refined_triangles": refined.surface.triangles(),
        "refined_to_fine": coarsening.refined_to_fine,
        "counts": counts(&coarse, &split.edges, trees.len()),
        "forest": split.edges,
        "trees": trees,
    }))
}

pub(super) fn all_counts(vector: &Value) -> Result<Value> {
    let cases: Vec<Value> = input::read(&vector["expected"], "cases")?;
    let answered = cases.into_iter().map(|mut case| {
        let triangles: Vec<[u32; 3]> = input::read(&case, "triangles")?;
        let vertex_count = triangles.iter().flatten().max().map_or(0, |&last| last + 1);
        let surface = ClosedSurface::new(vertex_count, &triangles)?;
        let mut edges: Vec<[u32; 2]> = input::read(&case, "spanning_tree")?;
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        let split = ForestSplit {
            edges,
            ..ForestSplit::default()
        };
        case["counts"] = counts(&surface, &split.edges, split.trees(&surface)?.len());
        Ok(case)
    });
    Ok(json!({ "cases": answered.collect::<Result<Vec<_>>>()? }))
}

/// The paper's reckoning: one bit for each edge, two for each triangle.
fn counts(surface: &ClosedSurface, marked: &[[u32; 2]], trees: usize) -> Value {
    let (triangles, edges) = (surface.triangles().len(), surface.edges().len());
    let added_vertices = marked.len() - trees;
    let fill_bits = 4 * added_vertices;
    let mark_bits = mark_bits(surface, marked).len();
    json!({
        "vertices": surface.vertex_count(),
        "triangles": triangles,
        "edges": edges,
        "trees": trees,
        "added_triangles": 2 * added_vertices,
        "added_vertices": added_vertices,
        "mark_bits_plain": edges,
        "mark_bits_with_forest_constraint": mark_bits,
        "fill_bits": fill_bits,
        "total_plain": edges + fill_bits,
        "total": mark_bits + fill_bits,
        "bits_per_coarse_triangle": (edges + fill_bits) as f64 / triangles as f64,
    })
}

/// The marks in the vectors' order, edges growing; left out are those whose ends marked edges join already. The product's own
/// order is another, which leaves out more.
fn mark_bits(surface: &ClosedSurface, marked: &[[u32; 2]]) -> Vec<bool> {
    let mut parents: Vec<u32> = (0..surface.vertex_count()).collect();
    let mut bits = Vec::new();
    for edge in surface.edges() {
        let [a, b] = edge.map(|end| root(&mut parents, end));
        if a != b {
            let is_marked = marked.binary_search(&edge).is_ok();
            bits.push(is_marked);
            parents[a as usize] = if is_marked { b } else { a };
        }
    }
    bits
}

/// The vertex that stands for all of a tree, path halving on the way.
fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let above = parents[parents[vertex as usize] as usize];
        parents[vertex as usize] = above;
        vertex = above;
    }
    vertex
}

fn as_bits(bits: &[bool]) -> Vec<u8> {
    bits.iter().copied().map(u8::from).collect()
}
