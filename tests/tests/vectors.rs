//! The answers to test vectors, those in `tests/vectors` and, where they stand beside the project, the larger ones of
//! `../shared/vectors`: computed from the inputs alone, compared as JSON.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use terrain_tests::{files_below, shared_vectors, vectors, workspace};

/// A vector as a stranger's checker hands it out: of `expected` only what its kind counts among the inputs.
fn question(vector: &Value) -> Value {
    let expected = &vector["expected"];
    let only = |list: &str, keys: &[&str]| -> Vec<Value> {
        let cases = expected[list].as_array().unwrap().iter();
        let pick = |case: &Value| keys.iter().map(|&key| (key.to_owned(), case[key].clone())).collect();
        cases.map(|case| Value::Object(pick(case))).collect()
    };
    let inputs = match vector["kind"].as_str().unwrap() {
        "partition" => match expected.get("merged") {
            Some(merged) => json!({ "merged": { "first_level_of_group": merged["first_level_of_group"] } }),
            None => json!({}),
        },
        "dag" => json!({
            "closed_sets": only("closed_sets", &["performed"]),
            "dual_queue": only("dual_queue", &["max_error", "errors"]),
            "forced_splits": only("forced_splits", &["want"]),
        }),
        "collapse_validity" => json!({ "cases": only("cases", &["mesh", "blue", "red"]) }),
        "multilevel" | "clustering" => json!({ "geomorphs": only("geomorphs", &["level"]) }),
        "malformed" | "forest_split" => json!({}),
        "forest_counts" => json!({ "cases": only("cases", &["triangles", "spanning_tree"]) }),
        "clod_star" => json!({ "cases": only("cases", &["patch", "uvw", "perturbed_star"]) }),
        "clod_t" => {
            json!({ "cases": only("cases", &["patch", "t", "perturbed", "two_t", "t_in_t", "t_in_t_inexact"]) })
        }
        "clod_swap" => json!({ "cases": only("cases", &["exact", "faces"]) }),
        "clod_tensor" => json!({ "cases": only("cases", &["tensor"]) }),
        "clod_fit" => json!({}),
        "clod_patterns" => json!({ "tolerance_1e-06": {}, "tolerance_0.2": {} }),
        kind => panic!("kind {kind} has no answer"),
    };
    let mut question = vector.clone();
    question["expected"] = inputs;
    question
}

/// Compares key by key, for failures that can be read.
fn assert_answered(name: &str, answer: &Value, vector: &Value) {
    let [answer, expected] = [answer, vector].map(|file| file["expected"].as_object().unwrap());
    let is_curved = vector["kind"].as_str().unwrap().starts_with("clod_");
    let tolerance = if is_curved { 1e-12 } else { 0.0 };
    for (key, value) in expected {
        let given = answer.get(key).unwrap();
        assert!(
            is_same(given, value, tolerance),
            "{name}: {key} is {given} instead of {value}"
        );
    }
    assert_eq!(answer.len(), expected.len(), "{name}: more than was asked");
}

/// The same values; numbers with a fraction may differ by a share of them, or of 1 if they are smaller.
fn is_same(one: &Value, other: &Value, tolerance: f64) -> bool {
    match (one, other) {
        (Value::Number(a), Value::Number(b)) if a.is_f64() || b.is_f64() => {
            let [a, b] = [a, b].map(|number| number.as_f64().unwrap());
            (a - b).abs() <= tolerance * b.abs().max(1.0)
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same(a, b, tolerance))
        }
        (Value::Object(a), Value::Object(b)) => {
            let same = |(key, a)| b.get(key).is_some_and(|b| is_same(a, b, tolerance));
            a.len() == b.len() && a.iter().all(same)
        }
        _ => one == other,
    }
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Answers the vectors in a folder whose kind is one of `kinds`; returns how many.
fn answer_all(folder: &Path, kinds: &[&str]) -> usize {
    let mut answered = 0;
    for path in files_below(folder)
        .iter()
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
    {
        let vector = read(path);
        if kinds.contains(&vector["kind"].as_str().unwrap()) {
            let answer = vectors::answer(&question(&vector)).unwrap();
            assert_answered(&path.display().to_string(), &answer, &vector);
            answered += 1;
        }
    }
    answered
}

const KINDS: [&str; 14] = [
    "partition",
    "dag",
    "collapse_validity",
    "multilevel",
    "malformed",
    "clustering",
    "forest_split",
    "forest_counts",
    "clod_star",
    "clod_t",
    "clod_swap",
    "clod_tensor",
    "clod_fit",
    "clod_patterns",
];

#[test]
fn vectors_of_this_project_are_answered() {
    assert_eq!(answer_all(&workspace().join("tests/vectors"), &KINDS), 9);
}

#[test]
fn vectors_of_an_independent_reference_are_answered() {
    let Some(folder) = shared_vectors("") else { return };
    assert!(answer_all(&folder, &KINDS) >= 31);
}

/// The reference's file of a partition is what the product makes of the same collapses and writes.
#[test]
fn a_partition_is_written_as_the_reference_writes_it() {
    let Some(path) = shared_vectors("multilevel_partition_grid5.json") else {
        return;
    };
    let vector = read(&path);
    let written = vectors::text_of_collapses(&vector).unwrap();
    assert_eq!(written, vector["text"].as_str().unwrap());
}

#[test]
fn the_program_writes_the_answer_to_the_file_named() {
    let folder = tempfile::tempdir().unwrap();
    let vector = read(&workspace().join("tests/vectors/dag_grid3.json"));
    let [file, actual] = ["file.json", "actual.json"].map(|name| folder.path().join(name));
    std::fs::write(&file, question(&vector).to_string()).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_terrain-vectors"));
    let status = program.arg(&file).arg("-o").arg(&actual).status().unwrap();
    assert!(status.success());
    assert_eq!(read(&actual), vector);
}

#[test]
fn lists_that_a_vector_does_not_have_ask_for_nothing() {
    let mut vector = read(&workspace().join("tests/vectors/dag_grid3.json"));
    let graph = vector["expected"]["collapse_constraints"].clone();
    vector["expected"] = json!({});
    let answer = vectors::answer(&vector).unwrap();
    assert_eq!(answer["expected"]["collapse_constraints"], graph);
    assert_eq!(answer["expected"]["dual_queue"], json!([]));
}

/// One order of the edges of a spanning tree is as good as another.
#[test]
fn spanning_trees_may_come_in_any_order() {
    let tetrahedron = json!([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    let case = json!({ "triangles": tetrahedron, "spanning_tree": [[3, 2], [1, 0], [2, 0]] });
    let answer = vectors::answer(&json!({ "kind": "forest_counts", "expected": { "cases": [case] } })).unwrap();
    let counts = &answer["expected"]["cases"][0]["counts"];
    assert_eq!((&counts["trees"], &counts["added_triangles"]), (&json!(1), &json!(4)));
    // All six edges are asked about but 1–2, whose ends the first two join.
    assert_eq!(counts["mark_bits_with_forest_constraint"], 5);
}

#[test]
fn a_log_that_is_not_valid_is_refused_with_its_index() {
    let mut vector = read(&workspace().join("tests/vectors/partition_grid3.json"));
    vector["collapses"][2] = json!([6, 4]);
    let told = vectors::answer(&question(&vector)).unwrap_err().to_string();
    assert!(told.contains("collapse 2"), "{told}");
}

/// What the papers' rules make of surfaces and errors outside their assumptions, and that the product says so.
#[test]
fn counterexamples_are_drawn_as_the_papers_would_and_not_called_consistent() {
    let Some(path) = shared_vectors("counterexamples.json") else {
        return;
    };
    let vector = read(&path);
    let answer = vectors::answer(&vector).unwrap();
    let compared = [
        ("bowtie", &["levels", "dag", "lods", "bad_lods", "bad_sets"][..]),
        ("pinch", &["levels", "dag", "lods", "bad_lods", "bad_sets"]),
        ("blocked_queue", &["dag", "performed_after"]),
        (
            "forest_shared_vertex",
            &[
                "removed",
                "marked_coarse_edges",
                "triangles_removed",
                "triangles_a_single_tree_of_these_edges_would_add",
            ],
        ),
    ];
    for (case, keys) in compared {
        for &key in keys {
            assert_eq!(
                answer["expected"][case][key], vector["expected"][case][key],
                "{case}: {key}"
            );
        }
    }
    let of_forest = answer["expected"]["forest_shared_vertex"]["why"].as_str().unwrap();
    assert!(of_forest.contains("collapse 1: its triangles and those of the collapses before it do not form a forest"));
    let refused = [
        ("bowtie", "the surface around vertex 2 falls into parts"),
        (
            "pinch",
            "collapse 0, 0 → 1: an interior edge between two vertices of the boundary",
        ),
    ];
    for (case, reason) in refused {
        let mut question = vector["expected"][case].clone();
        let count = question["vertices"].as_u64().unwrap() as usize;
        question["positions"] = json!(vec![[0.0; 3]; count]);
        question["kind"] = json!("partition");
        let told = format!("{:#}", vectors::answer(&question).unwrap_err());
        assert!(told.contains(reason), "{case}: {told}");
    }
}
