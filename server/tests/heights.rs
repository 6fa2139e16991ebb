//! Heights at places and along paths, and raster tiles of heights, through requests.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod service;

use std::fs;
use std::path::Path;

use axum::http::{StatusCode, header};
use glam::DVec2;
use serde_json::{Value, json};
use service::{Service, address, metadata, tile};
use terrain_codec::spt;
use terrain_tiles::archive::Writer;
use terrain_tiles::outside::{HeightField, Outside};

#[tokio::test]
async fn heights_have_their_error_and_tell_void_from_outside() {
    let service = Service::new();
    let reply = service
        .get("/square/height?longitude=-157.5&latitude=-67.5")
        .await
        .json();
    let point = &reply["points"][0];
    assert!((point["height"].as_f64().unwrap() - 500.0).abs() < 0.002, "{point}");
    assert_eq!(
        (point["error"].as_f64(), point["status"].as_str()),
        (Some(1.0), Some("measured"))
    );
    let taken = &reply["tilesets"][0];
    assert_eq!(
        (taken["name"].as_str(), taken["zoom"].as_u64()),
        (Some("square"), Some(1))
    );
    assert_eq!(
        (taken["heights_above"].as_str(), taken["source"][0].as_str()),
        (Some("unspecified"), Some("square.tif"))
    );
    // The northern edge is straight in space and bulges southwards, so that it leaves a little of the bounds without ground.
    let reply = service.get("/square/height?locations=-22.6,-135|10,-10").await.json();
    let told = |index: usize| {
        (
            reply["points"][index]["status"].as_str().unwrap(),
            reply["points"][index]["height"].is_null(),
        )
    };
    assert_eq!([told(0), told(1)], [("void", true), ("outside", true)]);
}

#[tokio::test]
async fn ground_that_was_filled_has_a_height_but_no_error() {
    let service = Service::new();
    let square = address(1, 0, 0);
    let mut filled = tile(square);
    filled.filled.fill(DVec2::splat(0.25), DVec2::splat(0.251));
    let path = service.folder.path().join("filled");
    let mut writer = Writer::create(&path).unwrap();
    for tile in [tile(address(0, 0, 0)), filled] {
        writer.add(tile.address, &spt::encode(&tile).unwrap()).unwrap();
    }
    writer.finish(&metadata()).unwrap();
    fs::copy(&path, service.archive()).unwrap();
    // The file is found to be another one when it is read.
    service.get("/square/2/5/3.spt").await;
    let body = r#"{"points": [[-157.5, -67.5], [-112.5, -67.5]]}"#;
    let reply = service.post("/square/height", body).await.json();
    let told = |index: usize| {
        let point = &reply["points"][index];
        assert!((point["height"].as_f64().unwrap() - 500.0).abs() < 0.01, "{point}");
        (point["status"].as_str().unwrap(), point["error"].as_f64())
    };
    assert_eq!([told(0), told(1)], [("filled", None), ("measured", Some(1.0))]);
}

#[tokio::test]
async fn batches_are_answered_in_their_order_at_the_zoom_that_is_named() {
    let service = Service::new();
    let body = r#"{"points": [[-10, 10], [-112.5, -67.5], [-157.5, -67.5]], "zoom": 1}"#;
    let reply = service.post("/square/height", body).await.json();
    let heights: Vec<Option<f64>> = reply["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| point["height"].as_f64())
        .collect();
    assert_eq!(
        heights.iter().map(Option::is_some).collect::<Vec<_>>(),
        [false, true, true]
    );
    // The tile of zoom 0 has its square elsewhere.
    let coarse = service
        .post("/square/height", &body.replace("\"zoom\": 1", "\"zoom\": 0"))
        .await
        .json();
    assert_eq!(coarse["tilesets"][0]["zoom"], 0);
    assert_ne!(coarse["points"], reply["points"]);
    for (body, reason) in [
        ("{}", "the body: missing field `points`"),
        (r#"{"points": [[0, 91]]}"#, "place 0 is not on the Earth"),
    ] {
        let refused = service.post("/square/height", body).await;
        assert_eq!(refused.status, StatusCode::BAD_REQUEST);
        assert!(refused.json()["error"].as_str().unwrap().starts_with(reason), "{body}");
    }
    let large = service.post("/square/height", &" ".repeat((1 << 20) + 1)).await;
    assert_eq!(large.status, StatusCode::PAYLOAD_TOO_LARGE);
}

#[tokio::test]
async fn profiles_run_along_their_path() {
    let service = Service::new();
    let reply = service
        .get("/square/profile?locations=-67.5,-157.5|-67.5,-112.5&samples=5")
        .await
        .json();
    let distances: Vec<f64> = reply["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| point["distance"].as_f64().unwrap())
        .collect();
    assert_eq!((distances.len(), distances[0]), (5, 0.0));
    assert!(
        (distances[1] * 4.0 - distances[4]).abs() < 1e-3 && (1.8e6..2.0e6).contains(&distances[4]),
        "{distances:?}"
    );
    let posted = service
        .post(
            "/square/profile",
            r#"{"path": [[-157.5, -67.5], [-112.5, -67.5]], "samples": 5}"#,
        )
        .await;
    assert_eq!(posted.json(), reply);
}

#[tokio::test]
async fn clients_of_google_and_of_valhalla_get_the_answers_that_they_know() {
    let service = Service::new();
    let reply = service
        .get("/square/maps/api/elevation/json?locations=-67.5,-157.5|10,-10")
        .await
        .json();
    assert_eq!(reply["status"], "OK");
    assert!((reply["results"][0]["elevation"].as_f64().unwrap() - 500.0).abs() < 0.002);
    assert_eq!(reply["results"][1]["elevation"], Value::Null);
    assert_eq!(reply["results"][0]["location"]["lng"], -157.5);
    let wrong = service.get("/square/maps/api/elevation/json?path=0,0|1,1").await;
    assert_eq!(
        (wrong.status, wrong.json()["status"].as_str()),
        (StatusCode::BAD_REQUEST, Some("INVALID_REQUEST"))
    );
    let shape = r#"{"shape": [{"lat": -67.5, "lon": -157.5}, {"lat": 10, "lon": -10}], "range": true, "id": "a"}"#;
    let reply = service.post("/square/valhalla/height", shape).await.json();
    assert_eq!(
        (reply["id"].as_str(), reply["range_height"][0].to_string()),
        (Some("a"), "[0.0,500]".to_owned())
    );
    assert_eq!(reply["range_height"][1][1], Value::Null);
    let plain = service
        .post("/square/valhalla/height", &shape.replace("true", "false"))
        .await
        .json();
    assert_eq!(plain["height"].to_string(), "[500,null]");
}

#[tokio::test]
async fn services_are_described_and_have_a_page_to_try_them() {
    let service = Service::new();
    let document = service.get("/openapi.json").await.json();
    for path in [
        "/{name}/height",
        "/{name}/profile",
        "/{name}/maps/api/elevation/json",
        "/{name}/valhalla/height",
    ] {
        assert!(document["paths"][path]["get"].is_object(), "{path}");
    }
    let page = service.get("/docs/index.html").await;
    assert!(String::from_utf8(page.body).unwrap().contains("swagger"));
    let script = service.get("/docs/swagger-initializer.js").await;
    assert!(String::from_utf8(script.body).unwrap().contains("../openapi.json"));
}

/// Heights that a PNG file of terrarium has, row by row.
fn heights_of(file: &[u8]) -> Vec<f64> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let height =
        |&[red, green, blue]: &[u8; 3]| f64::from(red) * 256.0 + f64::from(green) + f64::from(blue) / 256.0 - 32_768.0;
    bytes.as_chunks().0.iter().map(height).collect()
}

/// Longitude and latitude of the middle of a pixel of a tile of 256 pixels of Web Mercator's zoom 9.
fn middle_of([x, y]: [u32; 2], [column, row]: [u32; 2]) -> [f64; 2] {
    let [x, y] =
        [(x, column), (y, row)].map(|(tile, pixel)| (f64::from(tile) + (f64::from(pixel) + 0.5) / 256.0) / 512.0);
    let latitude = ((1.0 - 2.0 * y) * std::f64::consts::PI).sinh().atan().to_degrees();
    [x * 360.0 - 180.0, latitude]
}

/// Where [`write_fine_archive`] has ground beside its data: west, south, east, north.
const BESIDE: [f64; 4] = [16.0, 45.0, 19.0, 55.0];

/// Degrees from node to node of these heights, within which the ground of the data still counts.
const STEP: f64 = 0.05;

/// Metres that it has there.
fn beside(longitude: f64) -> f64 {
    120.0 - 30.0 * (longitude - 16.0)
}

fn bounds_of_data() -> [f64; 4] {
    let fine = address(9, 561, 397);
    let at = |south_west: f64, part: f64| south_west + part * fine.degrees();
    let (west, south) = (fine.west(), fine.south());
    [at(west, 0.25), at(south, 0.25), at(west, 0.75), at(south, 0.75)]
}

/// An archive whose one tile, of zoom 9, is half a square of 500 m, and all of it in one raster tile.
fn write_fine_archive(path: &Path) {
    let mut writer = Writer::create(path).unwrap();
    let fine = address(9, 561, 397);
    writer.add(fine, &spt::encode(&tile(fine)).unwrap()).unwrap();
    let mut metadata = metadata();
    metadata.bounds = bounds_of_data();
    metadata.max_zoom = 9;
    metadata.zooms[1].zoom = 9;
    let [west, south, east, north] = BESIDE;
    let row = (0..=60).map(|node| (beside(west + (east - west) * f64::from(node) / 60.0) * 10.0).round() as i32);
    metadata.outside = Outside::Extend {
        field: HeightField {
            bounds: [west, south, east, north],
            columns: 61,
            decimetres: row.clone().chain(row).collect(),
        },
    };
    writer.finish(&metadata).unwrap();
}

#[tokio::test]
async fn raster_tiles_have_the_heights_of_the_surface_ground_under_voids_and_what_is_beside_the_data() {
    let service = Service::new();
    let fine = service.folder.path().join("fine");
    write_fine_archive(&fine);
    fs::copy(&fine, service.archive()).unwrap();
    // The file is found to be another one when it is read.
    service.get("/square/2/5/3.spt").await;
    let document = service.get("/square/terrarium.json").await.json();
    assert_eq!(
        (document["encoding"].as_str(), document["tileSize"].as_u64()),
        (Some("terrarium"), Some(256))
    );
    assert_eq!(document["bounds"], json!(BESIDE));
    let zoom = &document["zooms"][9];
    assert_eq!(
        (document["maxzoom"].as_u64(), zoom["error"].as_f64()),
        (Some(9), Some(1.0))
    );
    let quantum = zoom["quantum"].as_f64().unwrap();
    assert_eq!(quantum, 0.25);
    let address = document["tiles"][0].as_str().unwrap();
    assert!(
        address.starts_with("http://here/square/terrarium/{z}/{x}/{y}.png?v="),
        "{address}"
    );
    let path = address
        .trim_start_matches("http://here")
        .replace("{z}/{x}/{y}", "9/280/174");
    let reply = service.get(&path).await;
    assert_eq!(reply.header(header::CONTENT_TYPE), "image/png");
    assert!(reply.header(header::CACHE_CONTROL).contains("immutable"));
    let heights = heights_of(&reply.body);
    let [west, south, east, north] = bounds_of_data();
    let [mut measured, mut outside] = [0, 0];
    for row in (0..256).step_by(9) {
        for column in (0..256).step_by(7) {
            let [longitude, latitude] = middle_of([280, 174], [column, row]);
            let drawn = heights[(row * 256 + column) as usize];
            let asked = service
                .get(&format!("/square/height?longitude={longitude}&latitude={latitude}"))
                .await
                .json();
            match asked["points"][0]["height"].as_f64() {
                Some(height) => {
                    measured += 1;
                    assert!(
                        (drawn - height).abs() <= quantum / 2.0 + 1e-3,
                        "{longitude} {latitude}: {drawn} {height}"
                    );
                }
                None if asked["points"][0]["status"] == "outside" => {
                    outside += 1;
                    let to = |low: f64, at: f64, high: f64| (low - at).max(at - high).max(0.0);
                    let away = to(west, longitude, east).hypot(to(south, latitude, north));
                    let off = drawn - beside(longitude);
                    let most = if away < STEP { 500.0 * (1.0 - away / STEP) } else { 0.0 };
                    let rounding = quantum / 2.0 + 1e-3;
                    assert!(
                        (-rounding..=most + rounding).contains(&off),
                        "{longitude} {latitude}: {drawn}"
                    );
                }
                None => {}
            }
        }
    }
    assert!(
        measured > 20 && outside > 20,
        "{measured} places are measured, {outside} outside"
    );
    let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least > 72.0, "no spike anywhere: {least}");
    let beside_all = service.get("/square/terrarium/9/281/174.png").await;
    for (pixel, drawn) in (0..).zip(heights_of(&beside_all.body)) {
        let [longitude, _] = middle_of([281, 174], [pixel % 256, pixel / 256]);
        assert!(
            (drawn - beside(longitude)).abs() <= quantum / 2.0 + 1e-3,
            "{longitude}: {drawn}"
        );
    }
    let far = service.get("/square/terrarium/9/0/0.png").await;
    assert!(heights_of(&far.body).iter().all(|&height| height == 0.0));
    for (path, status) in [
        ("/square/terrarium/10/561/348.png", 404),
        ("/square/terrarium/1/2/0.png", 400),
        ("/square/terrarium/9/280/174.jpg", 400),
        ("/square/terrarium/9/280/174.png?size=100", 400),
        ("/square/mapbox/0/0/0.webp?size=512", 200),
    ] {
        assert_eq!(service.get(path).await.status.as_u16(), status, "{path}");
    }
}
