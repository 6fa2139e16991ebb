//! `layer.json` in all its forms, and the tiles that it names.

use axum::http::{StatusCode, header};
use terrain_tiles::formats::quantized_mesh::validate;
use terrain_tiles::tile_file::SquareTile;

use crate::service::{Service, address};

#[tokio::test]
async fn layer_json_names_only_tiles_that_exist() {
    let service = Service::new();
    let document = service.get("/square/layer.json").await.json();
    assert_eq!(document["format"], "quantized-mesh-1.0");
    assert_eq!(document["tiles"][0], "{z}/{x}/{y}.terrain?v={version}");
    let version = document["version"].as_str().unwrap();
    for (zoom, ranges) in document["available"].as_array().unwrap().iter().enumerate() {
        for range in ranges.as_array().unwrap() {
            let number = |key: &str| range[key].as_u64().unwrap() as u32;
            for x in number("startX")..=number("endX") {
                for y in number("startY")..=number("endY") {
                    let path = format!("/square/{zoom}/{x}/{y}.terrain?v={version}");
                    let reply = service.get(&path).await;
                    assert_eq!(reply.status, StatusCode::OK, "{path}");
                    assert!(reply.header(header::CACHE_CONTROL).contains("immutable"));
                    assert_eq!(validate(&reply.mesh(), address(zoom as u8, x, y)), Ok(()));
                }
            }
        }
    }
}

#[tokio::test]
async fn layer_json_of_web_mercator_names_only_tiles_that_exist() {
    let service = Service::new();
    for scheme in ["", "&scheme=slippyMap"] {
        let document = service
            .get(&format!("/square/mercator/layer.json?{scheme}"))
            .await
            .json();
        assert_eq!(document["projection"], "EPSG:3857");
        assert_eq!(
            document["tiles"][0],
            format!("{{z}}/{{x}}/{{y}}.terrain?v={{version}}{scheme}")
        );
        assert_eq!(document["maxzoom"], 2);
        let version = document["version"].as_str().unwrap();
        let mut measured = 0;
        for (zoom, ranges) in document["available"].as_array().unwrap().iter().enumerate() {
            for range in ranges.as_array().unwrap() {
                let number = |key: &str| range[key].as_u64().unwrap() as u32;
                for (x, y) in (number("startX")..=number("endX"))
                    .flat_map(|x| (number("startY")..=number("endY")).map(move |y| (x, y)))
                {
                    let north = (1_u32 << zoom) - 1 - y;
                    let row = if scheme.is_empty() { y } else { north };
                    let path = format!(
                        "/square/mercator/{zoom}/{x}/{row}.terrain?extensions=measuredtriangles&v={version}{scheme}"
                    );
                    let reply = service.get(&path).await;
                    assert_eq!(reply.status, StatusCode::OK, "{path}");
                    assert!(reply.header(header::CACHE_CONTROL).contains("immutable"));
                    let (zoom, y) = (zoom as u8, north);
                    let mesh = reply.mesh();
                    assert_eq!(validate(&mesh, SquareTile { zoom, x, y }), Ok(()), "{path}");
                    measured += mesh.measured_triangles.unwrap();
                }
            }
        }
        // The square of two triangles: whole in the root, and cut by the sides of the tiles of two zooms.
        assert!(measured >= 10, "{measured}");
    }
    for path in [
        "3/0/0.terrain",
        "1/2/0.terrain",
        "1/0/x.terrain",
        "1/0/0.spt",
        "27/0/0.terrain",
    ] {
        let reply = service.get(&format!("/square/mercator/{path}")).await;
        let expected = if path.starts_with('3') {
            StatusCode::NOT_FOUND
        } else {
            StatusCode::BAD_REQUEST
        };
        assert_eq!(reply.status, expected, "{path}");
    }
}

#[tokio::test]
async fn rows_from_the_north_and_another_layer_are_told_when_they_are_asked_for() {
    let service = Service::new();
    let document = service
        .get("/square/layer.json?scheme=slippyMap&parent=https%3A%2F%2Fexample.org%2Fworld%2F")
        .await
        .json();
    assert_eq!(
        (&document["scheme"], &document["projection"]),
        (&"slippyMap".into(), &"EPSG:4326".into())
    );
    assert_eq!(document["parentUrl"], "https://example.org/world/");
    // Nothing but what has data.
    assert_eq!(document["available"][0][0]["endX"], 0);
    assert_eq!(document["available"][1][0]["endY"], 0);
    let from_south = service.get("/square/1/0/0.terrain").await;
    let from_north = service.get("/square/1/0/1.terrain?scheme=slippyMap").await;
    assert_eq!(from_north.body, from_south.body);
}
