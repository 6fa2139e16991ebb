//! Both tilesets of 3D Tiles, asked in the process.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

mod service;

use axum::http::{StatusCode, header};
use serde_json::Value;
use service::Service;

/// The description in a GLB file.
fn description(glb: &[u8]) -> Value {
    assert_eq!(&glb[..4], b"glTF");
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

/// Addresses of all contents of a document.
fn contents(tile: &Value) -> Vec<String> {
    let own = tile["content"]["uri"].as_str().map(str::to_owned);
    let below = tile["children"].as_array().into_iter().flatten().flat_map(contents);
    own.into_iter().chain(below).collect()
}

#[tokio::test]
async fn the_explicit_tileset_names_every_tile_and_what_is_certified_of_it() {
    let service = Service::new();
    let document = service.get("/square/3d-tiles/tileset.json").await.json();
    let version = service.get("/square/layer.json").await.json()["version"]
        .as_str()
        .unwrap()
        .to_owned();
    let named: Vec<String> = ["0/0/0", "1/0/0"]
        .iter()
        .map(|tile| format!("{tile}.glb?v={version}"))
        .collect();
    assert_eq!(contents(&document["root"]), named);
    let tile = &document["root"]["children"][0];
    let told = &tile["metadata"]["properties"];
    // At zoom 0 the step is a metre.
    let rounding = 3.0_f64.sqrt() / 2.0;
    assert_eq!(
        (&tile["geometricError"], &told["certifiedError"], &told["rounding"]),
        (&(1.0 + rounding).into(), &1.0.into(), &rounding.into())
    );
    for uri in named {
        assert_eq!(
            service.get(&format!("/square/3d-tiles/{uri}")).await.status,
            StatusCode::OK
        );
    }
}

#[tokio::test]
async fn a_measured_tile_is_what_was_measured_and_a_whole_one_covers_the_square() {
    let service = Service::new();
    let measured = service.get("/square/3d-tiles/1/0/0.glb").await;
    assert_eq!(measured.header(header::CONTENT_TYPE), "model/gltf-binary");
    let measured = description(&measured.body);
    assert_eq!(measured["accessors"][2]["count"], 6, "two triangles");
    let error = measured["asset"]["extras"]["certifiedError"].as_f64().unwrap();
    assert!(
        error > 1.0 && error < 2.0,
        "{error}: what is claimed, and what rounding adds"
    );
    let whole = service.get("/square/3d-terrain/0/1/0/0.glb").await;
    let whole = description(&whole.body);
    assert!(whole["accessors"][2]["count"].as_u64().unwrap() > 1500);
    assert_eq!(whole["extensionsUsed"][0], "CESIUM_tile_edges");
}

#[tokio::test]
async fn the_implicit_tileset_has_two_roots_and_both_have_a_subtree_and_a_tile() {
    let service = Service::new();
    let tileset = service.get("/square/3d-terrain/tileset.json").await.json();
    let version = service.get("/square/layer.json").await.json()["version"]
        .as_str()
        .unwrap()
        .to_owned();
    for (number, root) in tileset["root"]["children"].as_array().unwrap().iter().enumerate() {
        let named = contents(root);
        assert_eq!(named, [format!("{number}/{{level}}/{{x}}/{{y}}.glb?v={version}")]);
        let glb = service
            .get(&format!("/square/3d-terrain/{number}/0/0/0.glb?v={version}"))
            .await;
        assert_eq!(glb.status, StatusCode::OK);
        assert!(glb.header(header::CACHE_CONTROL).contains("immutable"));
    }
    let subtree = service.get("/square/3d-terrain/0/0/0/0.subtree").await;
    assert_eq!(
        (subtree.status, &subtree.body[..4]),
        (StatusCode::OK, b"subt".as_slice())
    );
}

/// What a subtree says of itself.
fn of_subtree(subtree: &[u8]) -> Value {
    let length = u64::from_le_bytes(subtree[8..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&subtree[24..24 + length]).unwrap()
}

#[tokio::test]
async fn the_implicit_tileset_has_ground_beside_the_data_across_the_antimeridian_too() {
    let service = Service::new();
    // Measured are 0/0/0 and 1/0/0.
    let beside = ["0/1/1/0", "0/1/0/1", "0/1/1/1", "1/1/1/0", "1/1/1/1"];
    for path in beside {
        let tile = service.get(&format!("/square/3d-terrain/{path}.glb")).await;
        assert_eq!(tile.status, StatusCode::OK, "{path}");
        assert!(description(&tile.body)["extensionsUsed"][0] == "CESIUM_tile_edges");
    }
    for path in ["1/1/0/0", "0/2/3/3"] {
        let tile = service.get(&format!("/square/3d-terrain/{path}.glb")).await;
        assert_eq!(tile.status, StatusCode::NOT_FOUND, "{path}");
    }
    for (root, available) in [(0, 5), (1, 3)] {
        let subtree = service.get(&format!("/square/3d-terrain/{root}/0/0/0.subtree")).await;
        let said = of_subtree(&subtree.body);
        assert_eq!(said["tileAvailability"]["availableCount"], available, "root {root}");
        assert_eq!(said["propertyTables"][0]["count"], available, "root {root}");
    }
}

#[tokio::test]
async fn packed_tilesets_name_packed_tiles() {
    let service = Service::new();
    let packing = "packing=meshopt";
    let document = service
        .get(&format!("/square/3d-tiles/tileset.json?{packing}"))
        .await
        .json();
    let named = contents(&document["root"]);
    assert_eq!(named.len(), 2);
    assert!(
        document["root"]["children"][0]["geometricError"].as_f64() > Some(400.0),
        "steps of 512 m at zoom 0"
    );
    let implicit = service
        .get(&format!("/square/3d-terrain/tileset.json?{packing}"))
        .await
        .json();
    let of_root = contents(&implicit["root"]["children"][0]).remove(0);
    let of_root = of_root.replace("{level}/{x}/{y}", "0/0/0");
    let all = named
        .iter()
        .map(|uri| format!("/square/3d-tiles/{uri}"))
        .chain([format!("/square/3d-terrain/{of_root}")]);
    for path in all {
        let packed = service.get(&path).await;
        let plain = service.get(&path.replace(packing, "packing=plain")).await;
        let required = |answer: &service::Reply| description(&answer.body)["extensionsRequired"].clone();
        assert_eq!(
            (&required(&packed)[0], &required(&plain)),
            (&"EXT_meshopt_compression".into(), &Value::Null)
        );
        assert_ne!(packed.header(header::ETAG), plain.header(header::ETAG));
        assert!(packed.header(header::CACHE_CONTROL).contains("immutable"));
    }
}

#[tokio::test]
async fn what_no_tileset_has_is_refused() {
    let service = Service::new();
    for (path, status) in [
        ("/square/3d-tiles/1/3/0.glb", StatusCode::NOT_FOUND),
        ("/square/3d-tiles/4/0/0.json", StatusCode::NOT_FOUND),
        ("/square/3d-tiles/3/0/0.json", StatusCode::NOT_FOUND),
        ("/square/3d-tiles/1/0/0.b3dm", StatusCode::BAD_REQUEST),
        ("/square/3d-tiles/1/0/2.glb", StatusCode::BAD_REQUEST),
        ("/square/3d-tiles/1/0/0.glb?packing=draco", StatusCode::BAD_REQUEST),
        ("/square/3d-terrain/2/0/0/0.glb", StatusCode::BAD_REQUEST),
        ("/square/3d-terrain/0/0/1/0.glb", StatusCode::BAD_REQUEST),
        ("/square/3d-terrain/0/7/0/0.subtree", StatusCode::NOT_FOUND),
        ("/round/3d-tiles/tileset.json", StatusCode::NOT_FOUND),
    ] {
        assert_eq!(service.get(path).await.status, status, "{path}");
    }
}

#[tokio::test]
async fn what_a_client_has_already_is_not_sent_again() {
    let service = Service::new();
    for path in [
        "/square/3d-tiles/1/0/0.glb",
        "/square/3d-terrain/0/1/0/0.glb",
        "/square/3d-terrain/tileset.json",
    ] {
        let first = service.get(path).await;
        let tag = first.header(header::ETAG).to_owned();
        let again = service.ask("GET", path, &[("if-none-match", &tag)]).await;
        assert_eq!(
            (again.status, again.body.len()),
            (StatusCode::NOT_MODIFIED, 0),
            "{path}"
        );
    }
}
