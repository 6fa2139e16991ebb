//! Kinds `clod_…`: cubic triangular patches. Inputs inside `expected.cases[]`: `patch`, `uvw`, `t`, `t1`, `t2`, `ts`, `faces`,
//! `tensor`, `perturbed` and `perturbed_star`; and the names of the tolerances.

use anyhow::{Context, Result, anyhow};
use glam::DVec3;
use serde_json::{Map, Value, json};
use terrain_core::Mesh;
use terrain_core::curved::fit::Refined;
use terrain_core::curved::merging::{self, Merged};
use terrain_core::curved::model::CurvedModel;
use terrain_core::curved::patch::CubicPatch;
use terrain_core::curved::patterns::PatternKind;
use terrain_core::curved::tensor::{self, Bicubic};

use super::input;

type Points = Vec<[f64; 3]>;

pub(super) fn star(vector: &Value) -> Result<Value> {
    answer_cases(vector, |case| {
        let given = patch(case, "patch")?;
        let at = DVec3::from_array(input::read(case, "uvw")?);
        let parts = given.star(at);
        case["point"] = input::position(given.point(at));
        case["star"] = json!(parts.map(|part| points(&part)));
        let whole = merging::merge_star(parts.each_ref()).context("the star cannot be merged")?;
        case["merged"] = points(&whole.patch);
        if case.get("perturbed_star").is_some() {
            let parts: [CubicPatch; 3] = patches(case, "perturbed_star")?;
            let whole = merging::merge_star(parts.each_ref()).context("the star cannot be merged")?;
            set_perturbed(case, &whole);
        }
        Ok(())
    })
}

pub(super) fn t(vector: &Value) -> Result<Value> {
    answer_cases(vector, |case| {
        let given = patch(case, "patch")?;
        let t: f64 = input::read(case, "t")?;
        case["split_edges"] = json!(split_edges(&given, t));
        if case.get("perturbed").is_some() {
            let [first, second] = patches(case, "perturbed")?;
            let whole = merging::merge_two(&first, &second).context("the T cannot be merged")?;
            set_perturbed(case, &whole);
        }
        if let Some(two_t) = case.get_mut("two_t") {
            let (t1, t2): (f64, f64) = (input::read(two_t, "t1")?, input::read(two_t, "t2")?);
            let [lower, upper] = given.rotated().split_first_curve(t2);
            let [first, second] = lower.rotated().rotated().split_first_curve(t1);
            let faces = [first, second, upper.rotated().rotated()];
            two_t["faces"] = json!(faces.map(|face| points(&face)));
        }
        if let Some(inner) = case.get_mut("t_in_t") {
            let faces = merging::triangle_in_triangle(&patch(inner, "patch")?, input::read(inner, "ts")?);
            let whole = merging::merge_triangle_in_triangle(faces.each_ref()).context("the T-in-T cannot be merged")?;
            inner["faces"] = json!(faces.map(|face| points(&face)));
            inner["patch"] = points(&whole.patch);
        }
        if let Some(inner) = case.get_mut("t_in_t_inexact") {
            let faces: [CubicPatch; 4] = patches(inner, "faces")?;
            let whole = merging::merge_triangle_in_triangle(faces.each_ref()).context("the T-in-T cannot be merged")?;
            inner["merged"] = points(&whole.patch);
            inner["deviation"] = json!(whole.deviation());
        }
        Ok(())
    })
}

/// The curves AB, BC and CA split, in the vectors' order of parts and corners.
fn split_edges(given: &CubicPatch, t: f64) -> [[Value; 2]; 3] {
    let [a, b, c] = [DVec3::X, DVec3::Y, DVec3::Z];
    let [ab, bc, ca] = [a.lerp(b, t), b.lerp(c, t), c.lerp(a, t)];
    let parts = [
        [[a, ab, c], [ab, b, c]],
        [[a, b, bc], [a, bc, c]],
        [[ca, b, c], [a, b, ca]],
    ];
    parts.map(|both| both.map(|places| points(&given.part(places))))
}

pub(super) fn swap(vector: &Value) -> Result<Value> {
    answer_cases(vector, |case| {
        let faces: [CubicPatch; 2] = patches(case, "faces")?;
        let swapped = merging::swap_diagonal(faces.each_ref());
        case["possible"] = json!(swapped.is_some());
        if let Some(swapped) = swapped {
            case["t"] = json!(swapped.along_old);
            case["s"] = json!(swapped.along_new);
            case["result"] = json!(swapped.patches.map(|patch| points(&patch)));
            if case.get("exact").is_none() {
                let worst = swapped.deviations.into_iter().flatten().fold(0.0, f64::max);
                case["exact"] = json!(worst < EXACT);
            }
        }
        Ok(())
    })
}

/// Deviations below this are rounding, for patches of about a unit's size.
const EXACT: f64 = 1e-9;

pub(super) fn tensor(vector: &Value) -> Result<Value> {
    answer_cases(vector, |case| {
        let rows: [[[f64; 3]; 4]; 4] = input::read(case, "tensor")?;
        let bicubic: Bicubic = rows.map(|row| row.map(DVec3::from_array));
        let transposed: Bicubic = std::array::from_fn(|i| std::array::from_fn(|j| bicubic[j][i]));
        case["diagonal"] = json!(tensor::diagonal(&bicubic).map(|point| point.to_array()));
        case["diagonal_transposed"] = json!(tensor::diagonal(&transposed).map(|point| point.to_array()));
        case["triangles_first_pass"] = json!(tensor::triangles(&bicubic).map(|patch| points(&patch)));
        Ok(())
    })
}

pub(super) fn fit(vector: &Value) -> Result<Value> {
    let triangles: Vec<[u32; 3]> = input::read(vector, "triangles")?;
    let vectors = |key: &str| -> Result<Vec<DVec3>> {
        let read: Points = input::read(vector, key)?;
        Ok(read.into_iter().map(DVec3::from_array).collect())
    };
    let (positions, of_vertices) = (vectors("positions")?, vectors("normals")?);
    let at = |corner: u32| of_vertices.get(corner as usize).copied();
    let normals = triangles.iter().map(|&[a, b, c]| Some([at(a)?, at(b)?, at(c)?]));
    let normals: Vec<_> = normals.collect::<Option<_>>().context("a vertex has no normal")?;
    let mut model = CurvedModel::first_pass(&Mesh { positions, triangles }, &normals)?;
    let all = |model: &CurvedModel| model.patches().iter().map(points).collect::<Vec<_>>();
    let first_pass = all(&model);
    let how = model.refine_centres().into_iter().map(|how| match how {
        Refined::Three => "three",
        Refined::Line => "line",
        Refined::Plane => "plane",
        Refined::Unchanged => "none",
        Refined::Singular => "singular",
    });
    let how: Vec<_> = how.collect();
    Ok(json!({ "first_pass": first_pass, "refined": all(&model), "how": how }))
}

pub(super) fn patterns(vector: &Value) -> Result<Value> {
    let corners: Vec<[u32; 3]> = input::read(vector, "corners")?;
    let vertices = corners.iter().flatten().max().map_or(0, |&last| last + 1);
    let patches: Vec<Points> = input::read(vector, "patches")?;
    let patches = patches.into_iter().map(to_patch).collect::<Result<Vec<_>>>()?;
    let model = CurvedModel::from_patches(corners, patches)?;
    let mut answered = Map::new();
    let names = vector["expected"]
        .as_object()
        .context("no tolerance is asked for")?
        .keys();
    for name in names {
        let tolerance = name.strip_prefix("tolerance_").and_then(|text| text.parse().ok());
        let tolerance: f64 = tolerance.with_context(|| format!("{name:?} is not a tolerance"))?;
        let pairs = (0..vertices).map(|vertex| (vertex, pairs_of(&model, vertex, tolerance)));
        let patterns = (0..vertices).flat_map(|vertex| patterns_of(&model, vertex, tolerance));
        let both = json!({ "mergeable_pairs": input::by_level(pairs), "patterns": patterns.collect::<Vec<_>>() });
        answered.insert(name.clone(), both);
    }
    Ok(Value::Object(answered))
}

fn pairs_of(model: &CurvedModel, vertex: u32, tolerance: f64) -> Value {
    let mut pairs: Vec<(u32, u32, f64)> = model
        .mergeable_pairs(vertex, tolerance)
        .iter()
        .map(|pair| {
            (
                pair.ends[0].min(pair.ends[1]),
                pair.ends[0].max(pair.ends[1]),
                pair.angle,
            )
        })
        .collect();
    pairs.sort_unstable_by_key(|&(a, b, _)| (a, b));
    json!(pairs)
}

/// Pairs growing; of each pair first the side that begins at its smaller end.
fn patterns_of(model: &CurvedModel, vertex: u32, tolerance: f64) -> Vec<Value> {
    let mut patterns = model.patterns(vertex, tolerance);
    patterns.sort_by_key(|pattern| {
        let [from, to] = pattern.side;
        (from.min(to), from.max(to), from)
    });
    let as_value = |pattern: &terrain_core::curved::patterns::Pattern| {
        let kind = match pattern.kind {
            PatternKind::T => "T",
            PatternKind::TwoT => "2T",
            PatternKind::TriangleInTriangle => "T-in-T",
        };
        json!({
            "vertex": vertex,
            "from_": pattern.side[0],
            "to": pattern.side[1],
            "pattern": kind,
            "removed": pattern.removed.as_slice(),
            "corners": pattern.corners,
        })
    };
    patterns.iter().map(as_value).collect()
}

fn answer_cases(vector: &Value, answer: impl Fn(&mut Value) -> Result<()>) -> Result<Value> {
    let mut cases: Vec<Value> = input::read(&vector["expected"], "cases")?;
    cases.iter_mut().try_for_each(answer)?;
    Ok(json!({ "cases": cases }))
}

fn set_perturbed(case: &mut Value, whole: &Merged) {
    case["perturbed_merged"] = points(&whole.patch);
    case["perturbed_deviation"] = json!(whole.deviation());
}

fn patch(value: &Value, key: &str) -> Result<CubicPatch> {
    to_patch(input::read(value, key)?)
}

fn patches<const N: usize>(value: &Value, key: &str) -> Result<[CubicPatch; N]> {
    let read: Vec<Points> = input::read(value, key)?;
    let all = read.into_iter().map(to_patch).collect::<Result<Vec<_>>>()?;
    all.try_into().map_err(|_| anyhow!("{key:?} is not of {N} patches"))
}

fn to_patch(points: Points) -> Result<CubicPatch> {
    let points: [[f64; 3]; 10] = points
        .try_into()
        .map_err(|_| anyhow!("a patch does not have ten points"))?;
    Ok(CubicPatch {
        points: points.map(DVec3::from_array),
    })
}

fn points(patch: &CubicPatch) -> Value {
    json!(patch.points.map(|point| point.to_array()))
}
