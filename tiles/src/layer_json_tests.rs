#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use serde_json::{Value, json};

use super::*;
use crate::archive::tests::metadata;
use crate::metadata::{Metadata, Zoom};

fn zoom(zoom: u8, available: Vec<[u32; 4]>) -> Zoom {
    Zoom {
        zoom,
        tiles: available.len(),
        triangles: 1,
        finest_error: 1.0,
        leaves: 0,
        leaf_error: 0.0,
        coarsest_error: 2.0,
        outline_error: 0.0,
        available,
    }
}

fn document(metadata: &Metadata) -> Value {
    serde_json::to_value(LayerJson::new("fault", "abc", metadata, &LayerForm::default())).unwrap()
}

#[test]
fn it_has_every_key_that_clients_demand() {
    let mut metadata = metadata();
    metadata.zooms = vec![
        zoom(0, vec![[0, 0, 0, 0]]),
        zoom(1, vec![[0, 1, 0, 1]]),
        zoom(2, vec![[1, 2, 1, 3], [2, 3, 2, 3]]),
    ];
    let range = |[x0, y0, x1, y1]: [u32; 4]| json!({"startX": x0, "startY": y0, "endX": x1, "endY": y1});
    let document = document(&metadata);
    assert_eq!(
        document,
        json!({
            "tilejson": "2.1.0", "name": "fault", "version": "abc",
            "format": "quantized-mesh-1.0", "scheme": "tms", "projection": "EPSG:4326",
            "tiles": ["{z}/{x}/{y}.terrain?v={version}"],
            "minzoom": 0, "maxzoom": 2, "bounds": [-123.5, 48.0, -122.25, 49.0],
            "extensions": ["octvertexnormals"], "attribution": "a.tif",
            "vertical": {"sourceDatum": "unspecified", "targetDatum": "unspecified", "transformation": "none"},
            "available": [
                [range([0, 0, 1, 0])],
                [range([0, 0, 1, 1]), range([3, 0, 3, 1])],
                [range([0, 1, 2, 3]), range([1, 2, 3, 3])],
            ],
        })
    );
}

#[test]
fn in_web_mercator_rows_are_those_over_the_same_latitudes() {
    let mut metadata = metadata();
    metadata.bounds = [-180.0, -90.0, 180.0, 90.0];
    // 45° to 90° north: two of four rows of zoom 2, and beyond the end of the projection.
    metadata.zooms = vec![
        zoom(0, vec![[0, 0, 1, 0]]),
        zoom(1, vec![[0, 1, 3, 1]]),
        zoom(2, vec![[2, 3, 5, 3]]),
    ];
    let form = LayerForm {
        projection: Projection::WebMercator,
        parent: Some("world/".to_owned()),
        ..LayerForm::default()
    };
    let document = serde_json::to_value(LayerJson::new("fault", "abc", &metadata, &form)).unwrap();
    let range = |[x0, y0, x1, y1]: [u32; 4]| json!({"startX": x0, "startY": y0, "endX": x1, "endY": y1});
    assert_eq!(
        document["available"],
        json!([
            [range([0, 0, 0, 0])],
            [range([0, 0, 1, 1])],
            [range([0, 2, 3, 3])],
            [range([2, 5, 5, 7])],
        ])
    );
    assert_eq!(
        (&document["maxzoom"], &document["parentUrl"]),
        (&json!(3), &json!("world/"))
    );
    assert_eq!(
        document["bounds"],
        json!([-180.0, -mercator::LATITUDES, 180.0, mercator::LATITUDES])
    );
}

#[test]
fn a_zoom_without_tiles_still_has_its_place_in_the_list() {
    let document = document(&metadata());
    let lengths: Vec<usize> = document["available"]
        .as_array()
        .unwrap()
        .iter()
        .map(|zoom| zoom.as_array().unwrap().len())
        .collect();
    assert_eq!(lengths, [1, 0, 0]);
}

#[test]
fn bounds_across_the_antimeridian_stay_on_the_map() {
    let metadata = Metadata {
        bounds: [178.0, -18.0, 181.0, -16.0],
        ..metadata()
    };
    assert_eq!(document(&metadata)["bounds"], json!([-180.0, -18.0, 180.0, -16.0]));
}

#[test]
fn it_says_what_heights_are_above_and_what_made_them_so() {
    let mut metadata = metadata();
    metadata.source.vertical_datum = "EGM96".to_owned();
    metadata.source.heights_above = "WGS 84 ellipsoid".to_owned();
    metadata.source.geoid = Some("egm96_15.gtx".to_owned());
    assert_eq!(
        document(&metadata)["vertical"],
        json!({
            "sourceDatum": "EGM96", "targetDatum": "WGS 84 ellipsoid", "grid": "egm96_15.gtx",
            "transformation": "the height of the geoid above the ellipsoid added, bilinear in egm96_15.gtx",
        })
    );
}

#[test]
fn it_names_the_water_mask_where_there_is_water() {
    let mut metadata = metadata();
    assert_eq!(document(&metadata)["extensions"], json!(["octvertexnormals"]));
    metadata.water.polygons = vec![vec![vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]]];
    assert_eq!(
        document(&metadata)["extensions"],
        json!(["octvertexnormals", "watermask"])
    );
}

#[test]
fn file_names_are_no_html() {
    let mut metadata = metadata();
    metadata.source.files = vec!["<b>.tif".to_owned(), "a&b.tif".to_owned()];
    assert_eq!(document(&metadata)["attribution"], "&lt;b&gt;.tif, a&amp;b.tif");
}
