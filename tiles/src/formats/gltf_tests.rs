#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::*;

fn roof() -> DrawnMesh {
    DrawnMesh {
        positions: [
            [1000.0, 0.0, 0.0],
            [1001.0, 0.0, 0.0],
            [1000.0, 1.0, 0.0],
            [1000.0, 0.0, 2.0],
        ]
        .map(DVec3::from_array)
        .to_vec(),
        normals: vec![DVec3::Z, DVec3::Y, DVec3::Z, DVec3::X],
        triangles: vec![[0, 1, 2], [1, 0, 3]],
    }
}

fn written(mesh: &DrawnMesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(&mut bytes, mesh, "a roof").unwrap();
    bytes
}

fn nowhere(_: &str) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::NotFound.into())
}

fn back(bytes: &[u8]) -> Result<Polygons, PolygonError> {
    read(bytes, &nowhere, PolygonLimits::default())
}

/// The JSON of a written file, and its binary part.
fn parts(bytes: &[u8]) -> (Value, Vec<u8>) {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (
        serde_json::from_slice(&bytes[20..20 + length]).unwrap(),
        bytes[28 + length..].to_vec(),
    )
}

/// The roof as text with its buffer written into it, after `change`.
fn changed(change: impl FnOnce(&mut Value)) -> Result<Polygons, PolygonError> {
    let (mut json, binary) = parts(&written(&roof()));
    json["buffers"][0]["uri"] = json!(format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(binary)
    ));
    change(&mut json);
    back(json.to_string().as_bytes())
}

#[test]
fn a_written_mesh_comes_back_with_its_normals() {
    let polygons = back(&written(&roof())).unwrap();
    assert_eq!(polygons.positions, roof().positions);
    assert_eq!(polygons.triangles, roof().triangles);
    let normals: Vec<f64> = polygons.columns.iter().map(|column| column.values[3]).collect();
    assert_eq!(normals, [1.0, 0.0, 0.0]);
}

#[test]
fn nodes_move_turn_and_mirror() {
    let polygons = changed(|json| {
        json["nodes"] =
            json!([{ "children": [1], "scale": [-2.0, 1.0, 1.0] }, { "mesh": 0, "translation": [1.0, 2.0, 3.0] }]);
    });
    let polygons = polygons.unwrap();
    // The mesh is about its middle, (1000.5, 0.5, 1).
    assert_eq!(polygons.positions[1], DVec3::new(-2.0 * 1.5, 1.5, 2.0));
    assert_eq!(polygons.triangles[0], [0, 2, 1], "mirrored");
    let normal = [0, 1, 2].map(|axis| polygons.columns[axis].values[3]);
    assert!(
        DVec3::from_array(normal).normalize().distance(DVec3::NEG_X) < 1e-12,
        "{normal:?}"
    );
}

#[test]
fn strips_and_fans_are_triangles_and_points_are_nothing() {
    let mode = |mode: u32| changed(|json| json["meshes"][0]["primitives"][0]["mode"] = json!(mode)).unwrap();
    assert_eq!(mode(5).triangles, [[0, 1, 2], [2, 1, 1], [2, 1, 0], [0, 1, 3]]);
    assert_eq!(mode(6).triangles, [[0, 1, 2], [0, 2, 1], [0, 1, 0], [0, 0, 3]]);
    assert_eq!(mode(0).faces, 0);
}

#[test]
fn files_beside_it_are_asked_for_by_name() {
    let (mut json, binary) = parts(&written(&roof()));
    json["buffers"][0]["uri"] = json!("the%20roof.bin");
    let open = |name: &str| {
        if name == "the roof.bin" {
            Ok(binary.clone())
        } else {
            nowhere(name)
        }
    };
    let polygons = read(json.to_string().as_bytes(), &open, PolygonLimits::default()).unwrap();
    assert_eq!(polygons.faces, 2);
    let missing = back(json.to_string().as_bytes()).unwrap_err().to_string();
    assert!(missing.contains("the roof.bin: "), "{missing}");
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let is_refused =
        |change: &dyn Fn(&mut Value)| matches!(changed(change), Err(PolygonError::Malformed { format: "glTF", .. }));
    assert!(is_refused(&|json| json["accessors"][0]["count"] = json!(5000)));
    assert!(is_refused(&|json| json["accessors"][0]["componentType"] = json!(5123)));
    assert!(is_refused(&|json| json["accessors"][2]["type"] = json!("VEC3")));
    assert!(is_refused(&|json| json["accessors"][0]["byteOffset"] = json!(u64::MAX)));
    assert!(is_refused(&|json| json["bufferViews"][0]["byteStride"] = json!(4)));
    assert!(is_refused(
        &|json| json["bufferViews"][0]["byteLength"] = json!(u64::MAX)
    ));
    assert!(is_refused(
        &|json| json["bufferViews"][0]["byteOffset"] = json!(u64::MAX - 3)
    ));
    assert!(is_refused(
        &|json| json["nodes"] = json!([{ "mesh": 0, "children": [0] }])
    ));
    assert!(is_refused(&|json| json["accessors"][0]["count"] = json!(0)));
    assert!(is_refused(&|json| json["accessors"] = json!([])));
    assert!(is_refused(
        &|json| json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])
    ));
    assert!(matches!(
        changed(|json| json["accessors"][0]["count"] = json!(2)),
        Err(PolygonError::BadIndex { .. })
    ));
    assert!(matches!(changed(|json| json["accessors"][2]["count"] = json!(3)), Ok(polygons) if polygons.faces == 1));
    let limits = PolygonLimits {
        vertices: 3,
        triangles: 9,
    };
    assert!(matches!(
        read(&written(&roof()), &nowhere, limits),
        Err(PolygonError::TooLarge(3, "vertices"))
    ));
}

#[test]
fn damaged_files_are_read_or_refused() {
    let whole = written(&roof());
    let mut random = fastrand::Rng::with_seed(1);
    let refused = (0..3000).filter(|_| {
        let mut bytes = whole.clone();
        for _ in 0..random.usize(1..4) {
            let at = random.usize(..bytes.len());
            bytes[at] = random.u8(b' '..127);
        }
        back(&bytes).is_err()
    });
    assert!(refused.count() > 1000);
}
