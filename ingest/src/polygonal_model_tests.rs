#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use super::*;

/// An octahedron as OBJ, with a colour at each vertex.
const OCTAHEDRON: &str = "\
v 1 0 0 1 0 0\nv 0 1 0 0 1 0\nv -1 0 0 1 0 0\nv 0 -1 0 0 1 0\nv 0 0 1 0 0 1\nv 0 0 -1 0 0 1\n
f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 2 1 6\nf 3 2 6\nf 4 3 6\nf 1 4 6\n";

fn file(folder: &TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path
}

fn read_text(name: &str, text: &str) -> Result<Model, ModelError> {
    let folder = TempDir::new().unwrap();
    read(&file(&folder, name, text), PolygonLimits::default())
}

fn made(folder: &TempDir, input: &str, target: Target, output: &str, lod: Option<usize>) -> Report {
    let options = Options {
        target,
        keep_vertices: false,
        lod,
    };
    let [input, output] = [input, output].map(|name| folder.path().join(name));
    run(&input, &options, &output, &Progress::silent()).unwrap()
}

/// A grid of hills; a cell is two triangles.
fn hills() -> String {
    let size = 25;
    let vertex = |i: u32| (i % size, i / size);
    let height = |x: u32, y: u32| (f64::from(x) / 4.0).sin() + (f64::from(y) / 5.0).cos();
    let positions = (0..size * size)
        .map(vertex)
        .map(|(x, y)| format!("v {x} {y} {}\n", height(x, y)));
    let cells = (1..size * (size - 1)).filter(|i| i % size != 0);
    let faces = cells.map(|i| format!("f {i} {} {} {}\n", i + 1, i + 1 + size, i + size));
    positions.chain(faces).collect()
}

#[test]
fn polygons_become_triangles_and_equal_positions_one_vertex() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0\nv 5 5 5\nv -0.0 2 0\nf 1 2 3 4\nf 5 4 7\nf 1 5 2\n";
    let model = read_text("square.obj", text).unwrap();
    assert_eq!(model.mesh.positions.len(), 5, "neither the copy nor the unused vertex");
    assert_eq!(model.mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn a_triangle_that_is_there_twice_is_one_but_its_back_is_another() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 2 3 1\nf 1 3 2\n";
    let model = read_text("twice.obj", text).unwrap();
    assert_eq!(model.mesh.triangles, [[0, 1, 2], [0, 2, 1]]);
}

#[test]
fn colours_are_kept_and_what_differs_at_a_seam_is_left_out_by_name() {
    let model = read_text("octahedron.obj", OCTAHEDRON).unwrap();
    let names: Vec<&str> = model.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["red", "green", "blue"]);
    let along_x: Vec<f64> = model.mesh.positions.iter().map(|at| 255.0 * at.x.abs()).collect();
    assert_eq!(model.columns[0].values, along_x);
    let seam = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property float s\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 0.5 7\n1 0 0 0 7\n0 1 0 0 7\n0 0 0 0.75 7\n3 0 1 2\n3 3 2 1\n";
    let model = read_text("seam.ply", seam).unwrap();
    assert_eq!(model.seams, ["s"]);
    assert_eq!(model.columns[0].values, [7.0, 7.0, 7.0]);
}

#[test]
fn faults_are_named() {
    let fault = |name: &str, text: &str| read_text(name, text).unwrap_err().to_string();
    assert_eq!(fault("empty.obj", ""), "has no triangles");
    assert!(fault("far.obj", "v 0 0 0\nf 1 2 3\n").starts_with("not a readable OBJ file"));
    assert_eq!(
        fault("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        "vertex 0 has a coordinate that is no finite number"
    );
    assert_eq!(
        fault("far.obj", "v 0 0 0\nv 1e61 0 0\nv 0 1 0\nf 1 2 3\n"),
        "vertex 1 has a coordinate of more than 1e60; scale the model down"
    );
    assert!(fault("text.ply", "no mesh").starts_with("not a readable PLY file"));
    let header = "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n";
    assert_eq!(fault("huge.ply", header), "more than 134217728 vertices");
    let negative = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n3 0 -1 0\n";
    assert!(fault("negative.ply", negative).starts_with("face 0 uses vertex"));
    assert!(fault("a.step", "").starts_with("models are read from"));
}

#[test]
fn a_tetrahedron_is_the_same_in_every_format() {
    let positions = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let facet = |face: &[usize; 3]| {
        let corners = face.map(|corner| format!("vertex {}\n", positions[corner])).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let stl = format!("solid t\n{}endsolid t\n", faces.iter().map(facet).collect::<String>());
    let face = |face: &[usize; 3]| format!("3 {} {} {}\n", face[0], face[1], face[2]);
    let off = format!(
        "OFF\n4 4 6\n{}\n{}",
        positions.join("\n"),
        faces.iter().map(face).collect::<String>()
    );
    let folder = TempDir::new().unwrap();
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let numbers = floats.iter().flat_map(|number| number.to_le_bytes());
    let corners = faces.iter().flatten().flat_map(|&corner| (corner as u16).to_le_bytes());
    fs::write(folder.path().join("t.bin"), numbers.chain(corners).collect::<Vec<u8>>()).unwrap();
    let gltf = |buffer: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":72,"uri":"{buffer}"}}],"bufferViews":
            [{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":24}}],"accessors":
            [{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
            {{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}]}}"#
        )
    };
    let bits = |model: Model| {
        let corners = model.mesh.triangles.as_flattened().iter();
        corners
            .map(|&corner| model.mesh.positions[corner as usize].to_array())
            .collect::<Vec<_>>()
    };
    let read_as = |name: &str, text: &str| read(&file(&folder, name, text), PolygonLimits::default());
    let expected = bits(read_as("t.off", &off).unwrap());
    assert_eq!(bits(read_as("t.STL", &stl).unwrap()), expected);
    assert_eq!(bits(read_as("t.gltf", &gltf("t.bin")).unwrap()), expected);
    for outside in ["../t.bin", "/etc/hostname", "file:///etc/hostname"] {
        let refused = read_as("out.gltf", &gltf(outside)).unwrap_err().to_string();
        assert!(refused.contains("only files beside it or below are read"), "{refused}");
    }
}

#[test]
fn levels_keep_the_error_that_was_asked_for_and_colours_on_the_way() {
    let folder = TempDir::new().unwrap();
    file(&folder, "hills.obj", &hills());
    let report = made(&folder, "hills.obj", Target::Error(0.2), "out.ply", None);
    let errors: Vec<f64> = report
        .levels
        .iter()
        .map(|level| level.certified_error.unwrap())
        .collect();
    assert_eq!((report.method, errors[0]), ("collapses", 0.0));
    assert!(
        errors.is_sorted() && *errors.last().unwrap() <= 0.2 && *errors.last().unwrap() > 0.1,
        "{errors:?}"
    );
    let written = read(&folder.path().join("out.ply"), PolygonLimits::default()).unwrap();
    assert_eq!(written.mesh.triangles.len(), report.levels.last().unwrap().triangles);
    file(&folder, "octahedron.obj", OCTAHEDRON);
    made(&folder, "octahedron.obj", Target::Coarsest, "coloured.ply", Some(0));
    let coloured = read(&folder.path().join("coloured.ply"), PolygonLimits::default()).unwrap();
    assert_eq!(coloured.columns.len(), 3);
    assert_eq!(coloured.mesh.triangles.len(), 8);
}

#[test]
fn columns_follow_the_vertices_where_they_move() {
    let size = 9;
    let header = "ply\nformat ascii 1.0\nelement vertex 81\nproperty float x\nproperty float y\nproperty float z\n\
        property double s\nelement face 128\nproperty list uchar int vertex_indices\nend_header\n";
    let vertices = (0..size * size).map(|i| (i % size, i / size));
    let vertices = vertices.map(|(x, y)| format!("{x} {y} 0 {}\n", x + 10 * y));
    let cells = (0..size * (size - 1)).filter(|i| i % size != size - 1);
    let faces = cells.map(|i| {
        format!(
            "3 {i} {} {}\n3 {i} {} {}\n",
            i + 1,
            i + 1 + size,
            i + 1 + size,
            i + size
        )
    });
    let folder = TempDir::new().unwrap();
    let text: String = std::iter::once(header.to_owned())
        .chain(vertices)
        .chain(faces)
        .collect();
    file(&folder, "plate.ply", &text);
    made(&folder, "plate.ply", Target::Triangles(8), "few.ply", None);
    let few = read(&folder.path().join("few.ply"), PolygonLimits::default()).unwrap();
    for (at, value) in few.mesh.positions.iter().zip(&few.columns[0].values) {
        assert!((at.x + 10.0 * at.y - value).abs() < 0.01, "{value} at {at}");
    }
}

#[test]
fn a_level_of_a_lod_file_is_the_level_that_was_made() {
    let folder = TempDir::new().unwrap();
    file(&folder, "hills.obj", &hills());
    let report = made(&folder, "hills.obj", Target::Triangles(60), "hills.lod", None);
    assert!(report.levels.last().unwrap().triangles <= 60);
    for (level, made_level) in report.levels.iter().enumerate() {
        let extracted = made(&folder, "hills.lod", Target::Coarsest, "level.ply", Some(level));
        assert_eq!(
            (extracted.method, extracted.levels.len()),
            ("file", report.levels.len())
        );
        let mesh = read(&folder.path().join("level.ply"), PolygonLimits::default())
            .unwrap()
            .mesh;
        assert_eq!(
            (mesh.positions.len(), mesh.triangles.len()),
            (made_level.vertices, made_level.triangles)
        );
    }
}

#[test]
fn what_is_no_manifold_is_clustered_within_the_error() {
    let folder = TempDir::new().unwrap();
    // A third triangle on an edge of the hills.
    let text = hills() + "v 0.5 0.5 9\nf 1 2 626\n";
    file(&folder, "fin.obj", &text);
    let report = made(&folder, "fin.obj", Target::Error(3.0), "fin.lod", None);
    assert_eq!(report.method, "clustering");
    assert!(report.reason.unwrap().contains("used twice in the same direction"));
    let last = report.levels.last().unwrap();
    assert!(last.certified_error.unwrap() <= 3.0 && last.triangles < 576, "{last:?}");
    for most in [25, 30, 35, 40, 45, 50] {
        let few = made(&folder, "fin.obj", Target::Triangles(most), "few.lod", None);
        let left = few.levels.last().unwrap().triangles;
        assert!((most / 2..=most).contains(&left), "{left} of {most}");
        assert!(few.levels.len() >= 3, "there are levels between: {few}");
    }
    let fewest = made(&folder, "fin.obj", Target::Triangles(1), "fewest.lod", None);
    assert!((1..=10).contains(&fewest.levels.last().unwrap().triangles), "{fewest}");
    let whole = made(&folder, "fin.obj", Target::Triangles(1153), "whole.lod", None);
    assert_eq!((whole.levels.len(), whole.levels[0].triangles), (1, 1153));
}

#[test]
fn levels_that_are_not_there_are_refused() {
    let folder = TempDir::new().unwrap();
    let input = file(&folder, "octahedron.obj", OCTAHEDRON);
    let options = Options {
        target: Target::Coarsest,
        keep_vertices: false,
        lod: Some(9),
    };
    let error = run(&input, &options, &folder.path().join("out.ply"), &Progress::silent()).unwrap_err();
    assert!(
        format!("{error:#}").contains("there is no level 9: levels go from 0"),
        "{error:#}"
    );
    assert!(!folder.path().join("out.ply").exists());
}
