//! The whole service, asked in the process, over a small archive of tiles made here.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::io::Read;
use std::path::Path;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{HeaderMap, Request, StatusCode, header};
use flate2::read::GzDecoder;
use glam::DVec3;
use serde_json::Value;
use tempfile::TempDir;
use terrain_core::{Band, CollapseLog, Mesh, SurfacePartition};
use terrain_server::curved::{self, CurvedFile};
use terrain_server::{Tileset, router};
use terrain_tiles::address::TileAddress;
use terrain_tiles::archive::Writer;
use terrain_tiles::formats::quantized_mesh::{QuantizedMesh, QuantizedMeshLimits, decode, validate};
use terrain_tiles::formats::spt;
use terrain_tiles::metadata::{Asked, FORMAT, Metadata, Source, VERSION, Zoom};
use terrain_tiles::tile::{Lineage, Tile};
use tower::ServiceExt;

fn address(zoom: u8, x: u32, y: u32) -> TileAddress {
    TileAddress::new(zoom, x, y).unwrap()
}

/// A square of two triangles in the middle of the tile, 500 m up.
fn tile(address: TileAddress) -> Tile {
    let corners = [(256.0, 256.0), (768.0, 256.0), (768.0, 768.0), (256.0, 768.0)];
    let mesh = Mesh {
        positions: corners.map(|(x, y)| DVec3::new(x, y, 500.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let log = CollapseLog {
        collapses: Vec::new(),
        bands: vec![Band { end: 0, error: 1.0 }; 4],
    };
    let partition = SurfacePartition::from_log(&mesh, &log, 1.0).unwrap();
    Tile {
        address,
        extent_bits: 10,
        height_exponent: -2,
        sampling: None,
        lineage: Lineage::default(),
        partition,
        outline_errors: vec![0.0; 5],
    }
}

fn metadata() -> Metadata {
    let zoom = |zoom, available| Zoom {
        zoom,
        tiles: 1,
        triangles: 2,
        finest_error: 1.0,
        coarsest_error: 1.0,
        outline_error: 0.0,
        available: vec![available],
    };
    Metadata {
        format: FORMAT.to_owned(),
        version: VERSION,
        scheme: "geographic-tms".to_owned(),
        bounds: [-157.5, -67.5, -112.5, -22.5],
        heights: [500.0, 500.0],
        min_zoom: 0,
        max_zoom: 1,
        bound: "surface".to_owned(),
        max_error: 1.0,
        asked: Asked::default(),
        plan: String::new(),
        source: Source {
            files: vec!["square.tif".to_owned()],
            crs: "EPSG:4326".to_owned(),
            vertical_datum: "unspecified".to_owned(),
            heights_above: String::new(),
            geoid: None,
            samples: [2, 2],
        },
        generator: "test".to_owned(),
        zooms: vec![zoom(0, [0, 0, 0, 0]), zoom(1, [0, 0, 0, 0])],
    }
}

/// Where the archive has bytes that are no tile.
const DAMAGED: TileAddress = TileAddress { zoom: 1, x: 2, y: 1 };

fn write_archive(path: &Path) {
    let mut writer = Writer::create(path).unwrap();
    for address in [address(0, 0, 0), address(1, 0, 0)] {
        writer.add(address, &spt::encode(&tile(address)).unwrap()).unwrap();
    }
    writer.add(DAMAGED, b"no tile").unwrap();
    writer.finish(&metadata()).unwrap();
}

/// The service over one archive called `square`.
struct Service {
    router: Router,
    _folder: TempDir,
}

struct Reply {
    status: StatusCode,
    headers: HeaderMap,
    body: Vec<u8>,
}

impl Reply {
    fn header(&self, name: header::HeaderName) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }

    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    /// The body as a quantized mesh, unzipped if the headers say so.
    fn mesh(&self) -> QuantizedMesh {
        let mut bytes = Vec::new();
        match self.header(header::CONTENT_ENCODING) {
            "gzip" => drop(GzDecoder::new(&self.body[..]).read_to_end(&mut bytes).unwrap()),
            _ => bytes.clone_from(&self.body),
        }
        decode(&bytes, &QuantizedMeshLimits::default()).unwrap()
    }
}

impl Service {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("square.pmtiles");
        write_archive(&path);
        Self {
            router: router(vec![Tileset::open(&path).unwrap()]),
            _folder: folder,
        }
    }

    async fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)]) -> Reply {
        let request = headers
            .iter()
            .fold(Request::builder().method(method).uri(path), |builder, (name, value)| {
                builder.header(*name, *value)
            });
        let response = self
            .router
            .clone()
            .oneshot(request.body(Body::empty()).unwrap())
            .await
            .unwrap();
        let (parts, body) = response.into_parts();
        let body = to_bytes(body, 1 << 24).await.unwrap().to_vec();
        Reply {
            status: parts.status,
            headers: parts.headers,
            body,
        }
    }

    async fn get(&self, path: &str) -> Reply {
        self.ask("GET", path, &[]).await
    }
}

#[tokio::test]
async fn health_tilesets_and_page_are_there() {
    let service = Service::new();
    let health = service.get("/healthz").await;
    assert_eq!(
        (health.status, health.body.as_slice()),
        (StatusCode::OK, b"ok".as_slice())
    );
    let list = service.get("/tilesets").await.json();
    assert_eq!(list[0]["name"], "square");
    assert_eq!(list[0]["metadata"]["max_zoom"], 1);
    let page = service.get("/").await;
    assert_eq!(page.status, StatusCode::OK);
    assert_eq!(page.header(header::CONTENT_TYPE), "text/html; charset=utf-8");
    assert!(page.body.starts_with(b"<!doctype html>") || page.body.starts_with(b"<!DOCTYPE html>"));
}

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
async fn a_tile_is_measured_in_the_middle_and_ground_around_it() {
    let service = Service::new();
    let reply = service.get("/square/1/0/0.terrain").await;
    assert_eq!(reply.header(header::CONTENT_TYPE), "application/vnd.quantized-mesh");
    let mesh = reply.mesh();
    assert_eq!(mesh.measured_triangles, Some(2));
    assert!(mesh.triangles.len() > 500);
    let height = |index| mesh.geodetic(address(1, 0, 0), index).height;
    assert_eq!(mesh.triangles[0].map(|index| height(index as usize)), [500.0; 3]);
    let empty = service.get("/square/0/1/0.terrain").await.mesh();
    assert_eq!((empty.measured_triangles, empty.heights), (Some(0), [0.0, 0.0]));
}

#[tokio::test]
async fn terrain_is_gzipped_exactly_for_clients_that_accept_it() {
    let service = Service::new();
    let path = "/square/1/0/0.terrain";
    let plain = service.get(path).await;
    assert_eq!(plain.header(header::CONTENT_ENCODING), "");
    for (accepted, expected) in [
        ("gzip, deflate, br, zstd", "gzip"),
        ("br", ""),
        ("gzip;q=0", ""),
        ("identity", ""),
        ("GZIP;q=0.5", "gzip"),
    ] {
        let reply = service.ask("GET", path, &[("accept-encoding", accepted)]).await;
        assert_eq!(reply.header(header::CONTENT_ENCODING), expected, "{accepted}");
        assert_eq!(reply.mesh(), plain.mesh());
        assert_eq!(reply.header(header::VARY), "accept, accept-encoding");
        let same_bytes = reply.header(header::ETAG) == plain.header(header::ETAG);
        assert_eq!(same_bytes, expected.is_empty(), "two encodings have two tags");
    }
}

#[tokio::test]
async fn normals_are_sent_when_asked_for_in_any_of_three_ways() {
    let service = Service::new();
    let path = "/square/1/0/0.terrain";
    assert!(service.get(path).await.mesh().normals.is_none());
    let cesium =
        "application/vnd.quantized-mesh;extensions=octvertexnormals-metadata,application/octet-stream;q=0.9,*/*;q=0.01";
    let three = "application/vnd.quantized-mesh,application/octet-stream;q=0.9;extensions=octvertexnormals";
    for accept in [cesium, three] {
        assert!(
            service
                .ask("GET", path, &[("accept", accept)])
                .await
                .mesh()
                .normals
                .is_some(),
            "{accept}"
        );
    }
    let query = format!("{path}?v=1&extensions=watermask-octvertexnormals");
    assert!(service.get(&query).await.mesh().normals.is_some());
    assert!(
        service
            .get(&format!("{path}?extensions=watermask&v=octvertexnormals"))
            .await
            .mesh()
            .normals
            .is_none()
    );
}

#[tokio::test]
async fn our_own_tile_comes_as_stored_whole_or_in_part() {
    let service = Service::new();
    let path = "/square/1/0/0.spt";
    let whole = service.ask("GET", path, &[("accept-encoding", "gzip")]).await;
    assert_eq!(whole.body, spt::encode(&tile(address(1, 0, 0))).unwrap());
    assert_eq!(whole.header(header::CONTENT_ENCODING), "");
    assert_eq!(whole.header(header::CONTENT_TYPE), "application/octet-stream");
    assert_eq!(whole.header(header::ACCEPT_RANGES), "bytes");
    let length = whole.body.len();
    for (range, first, last) in [
        ("bytes=0-31", 0, 31),
        ("bytes=32-", 32, length - 1),
        ("bytes=-5", length - 5, length - 1),
    ] {
        let part = service.ask("GET", path, &[("range", range)]).await;
        assert_eq!(part.status, StatusCode::PARTIAL_CONTENT, "{range}");
        assert_eq!(
            part.header(header::CONTENT_RANGE),
            format!("bytes {first}-{last}/{length}")
        );
        assert_eq!(part.body, whole.body[first..=last]);
        assert_eq!(part.header(header::ETAG), whole.header(header::ETAG));
    }
    let beyond = service.ask("GET", path, &[("range", "bytes=999999-")]).await;
    assert_eq!(beyond.status, StatusCode::RANGE_NOT_SATISFIABLE);
    assert_eq!(beyond.header(header::CONTENT_RANGE), format!("bytes */{length}"));
    for headers in [
        [("range", "lines=1-2"), ("accept", "*/*")],
        [("range", "bytes=0-31"), ("if-range", "\"old\"")],
    ] {
        let reply = service.ask("GET", path, &headers).await;
        assert_eq!(
            (reply.status, reply.body.len()),
            (StatusCode::OK, length),
            "{headers:?}"
        );
    }
}

#[tokio::test]
async fn what_a_client_has_already_is_not_sent_again() {
    let service = Service::new();
    for path in [
        "/square/1/0/0.terrain",
        "/square/1/0/0.spt",
        "/square/layer.json",
        "/tilesets",
        "/",
    ] {
        let first = service.get(path).await;
        let tag = first.header(header::ETAG).to_owned();
        assert!(tag.starts_with('"') && tag.len() == 34, "{path}: {tag}");
        assert_eq!(first.header(header::CACHE_CONTROL), "public, no-cache");
        for condition in [tag.clone(), format!("\"other\", W/{tag}"), "*".to_owned()] {
            let again = service.ask("GET", path, &[("if-none-match", &condition)]).await;
            assert_eq!(
                (again.status, again.body.len()),
                (StatusCode::NOT_MODIFIED, 0),
                "{path} {condition}"
            );
            assert_eq!(again.header(header::ETAG), tag);
        }
        assert_eq!(
            service.ask("GET", path, &[("if-none-match", "\"other\"")]).await.status,
            StatusCode::OK
        );
        let head = service.ask("HEAD", path, &[]).await;
        assert_eq!((head.status, head.body.len()), (StatusCode::OK, 0));
    }
}

#[tokio::test]
async fn other_pages_may_read_everything() {
    let service = Service::new();
    for path in [
        "/square/layer.json",
        "/square/1/0/0.terrain",
        "/square/1/0/0.spt",
        "/tilesets",
        "/square/9/0/0.spt",
        "/x",
    ] {
        let reply = service
            .ask("GET", path, &[("origin", "http://elsewhere.example")])
            .await;
        assert_eq!(reply.header(header::ACCESS_CONTROL_ALLOW_ORIGIN), "*", "{path}");
        let asked = [
            ("origin", "http://elsewhere.example"),
            ("access-control-request-method", "GET"),
            ("access-control-request-headers", "if-none-match,range"),
        ];
        let preflight = service.ask("OPTIONS", path, &asked).await;
        assert_eq!(preflight.status, StatusCode::OK);
        assert_eq!(preflight.header(header::ACCESS_CONTROL_ALLOW_ORIGIN), "*");
        assert_eq!(preflight.header(header::ACCESS_CONTROL_ALLOW_HEADERS), "*");
    }
}

#[tokio::test]
async fn what_is_not_there_is_404_and_nonsense_is_400() {
    let service = Service::new();
    let cases = [
        ("/square/1/1/0.terrain", 404, "tileset “square” has no tile 1/1/0"),
        ("/square/9/0/0.spt", 404, "tileset “square” has no tile 9/0/0"),
        ("/square/0/1/0.spt", 404, "tileset “square” has no tile 0/1/0"),
        (
            "/round/layer.json",
            404,
            "there is no tileset “round”; /tilesets lists those there are",
        ),
        (
            "/round/0/0/0.terrain",
            404,
            "there is no tileset “round”; /tilesets lists those there are",
        ),
        ("/nothing.js", 404, "there is nothing at /nothing.js"),
        (
            "/square/0/0/0.png",
            400,
            "tiles end in .terrain or .spt, not in “0.png”",
        ),
        ("/square/0/0/0", 400, "tiles end in .terrain or .spt, not in “0”"),
        ("/square/one/0/0.terrain", 400, "one/0/0.terrain is no tile"),
        ("/square/1/+1/0.terrain", 400, "1/+1/0.terrain is no tile"),
        ("/square/1/4/0.terrain", 400, "1/4/0.terrain is no tile"),
        ("/square/27/0/0.spt", 400, "27/0/0.spt is no tile"),
        ("/square/99999999999/0/0.spt", 400, "99999999999/0/0.spt is no tile"),
        ("/square/1/0/-1.spt", 400, "1/0/-1.spt is no tile"),
    ];
    for (path, status, message) in cases {
        let reply = service.get(path).await;
        assert_eq!(reply.status.as_u16(), status, "{path}");
        let error = reply.json()["error"].as_str().unwrap().to_owned();
        assert!(error.starts_with(message), "{path}: {error}");
    }
}

#[tokio::test]
async fn a_damaged_tile_is_the_servers_fault_and_does_not_stop_it() {
    let service = Service::new();
    let reply = service.get("/square/1/2/1.terrain").await;
    assert_eq!(reply.status, StatusCode::INTERNAL_SERVER_ERROR);
    let error = reply.json()["error"].as_str().unwrap().to_owned();
    assert!(error.starts_with("tile 1/2/1 of “square”: "), "{error}");
    assert_eq!(service.get("/square/1/0/0.terrain").await.status, StatusCode::OK);
}

#[tokio::test]
async fn curved_models_are_served_as_they_are() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("web/test/torus.clod");
    let file = CurvedFile::open(&path).unwrap();
    let mut service = Service::new();
    service.router = service.router.merge(curved::router(vec![file]));
    let reply = service.get("/torus/curved.clod").await;
    assert_eq!(reply.status, StatusCode::OK);
    assert_eq!(reply.body, std::fs::read(&path).unwrap());
    assert_eq!(service.get("/square/curved.clod").await.status, StatusCode::NOT_FOUND);
    assert_eq!(service.get("/square/layer.json").await.status, StatusCode::OK);
    assert!(CurvedFile::open(&path.with_file_name("page.test.mjs")).is_err());
}
