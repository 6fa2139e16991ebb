//! The whole service, asked in the process, over a small archive of tiles made here.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

#[path = "http/layers.rs"]
mod layers;
mod service;

use std::fs;
use std::path::Path;

use axum::http::{StatusCode, header};
use service::{Service, address, metadata, tile};
use terrain_codec::spt;
use terrain_server::{ModelFile, Settings};
use terrain_tiles::archive::Writer;

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
async fn the_decoder_of_the_page_is_a_compressed_module() {
    let assets = fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/web/dist/assets")).unwrap();
    let mut names = assets.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let module = names.find(|name| name.ends_with(".wasm")).unwrap();
    let service = Service::new();
    let accept = [("accept-encoding", "br")];
    let reply = service.ask("GET", &format!("/assets/{module}"), &accept).await;
    assert_eq!(reply.header(header::CONTENT_TYPE), "application/wasm");
    assert_eq!(reply.header(header::CONTENT_ENCODING), "br");
}

#[tokio::test]
async fn a_tile_is_measured_in_the_middle_and_ground_around_it() {
    let service = Service::new();
    let reply = service.get("/square/1/0/0.terrain?extensions=measuredtriangles").await;
    assert_eq!(reply.header(header::CONTENT_TYPE), "application/vnd.quantized-mesh");
    let mesh = reply.mesh();
    assert_eq!(mesh.measured_triangles, Some(2));
    assert!(mesh.triangles.len() > 500);
    let height = |index| mesh.geodetic(address(1, 0, 0), index).height;
    assert_eq!(mesh.triangles[0].map(|index| height(index as usize)), [500.0; 3]);
    let empty = service
        .get("/square/0/1/0.terrain?extensions=measuredtriangles")
        .await
        .mesh();
    assert_eq!((empty.measured_triangles, empty.heights), (Some(0), [0.0, 0.0]));
}

#[tokio::test]
async fn terrain_is_compressed_as_its_client_likes_it_best() {
    let service = Service::new();
    let path = "/square/1/0/0.terrain";
    let plain = service.get(path).await;
    assert_eq!(plain.header(header::CONTENT_ENCODING), "");
    for (accepted, expected) in [
        ("gzip, deflate, br, zstd", "br"),
        ("gzip, zstd", "zstd"),
        ("br;q=0.5, gzip", "gzip"),
        ("deflate", ""),
        ("gzip;q=0", ""),
        ("gzip;q=0, *", "br"),
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
async fn documents_and_scripts_are_compressed() {
    let service = Service::new();
    let page = service.get("/").await;
    let text = String::from_utf8(page.body.clone()).unwrap();
    let script = text.split('"').find(|part| part.ends_with(".js"));
    for path in ["/tilesets", script.map_or("/", |path| path.trim_start_matches('.'))] {
        let plain = service.get(path).await;
        let packed = service.ask("GET", path, &[("accept-encoding", "gzip, br")]).await;
        if plain.body.len() >= 1 << 10 {
            assert_eq!(packed.header(header::CONTENT_ENCODING), "br", "{path}");
            assert!(packed.body.len() < plain.body.len() / 2, "{path}");
        }
        assert_eq!(packed.plain(), plain.body, "{path}");
        assert_eq!(packed.header(header::VARY), "accept-encoding", "{path}");
    }
}

#[tokio::test]
async fn extensions_are_sent_when_asked_for_in_any_of_three_ways_and_never_else() {
    let service = Service::new();
    let path = "/square/1/0/0.terrain";
    let unasked = service.get(path).await.mesh();
    assert_eq!((unasked.normals, unasked.measured_triangles), (None, None));
    let cesium =
        "application/vnd.quantized-mesh;extensions=octvertexnormals-metadata,application/octet-stream;q=0.9,*/*;q=0.01";
    let three = "application/vnd.quantized-mesh,application/octet-stream;q=0.9;extensions=octvertexnormals";
    for accept in [cesium, three] {
        let mesh = service.ask("GET", path, &[("accept", accept)]).await.mesh();
        assert!(mesh.normals.is_some(), "{accept}");
        assert_eq!(mesh.measured_triangles, None, "{accept}");
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
    let strong = whole.header(header::ETAG).to_owned();
    let weak = format!("W/{strong}");
    let same = service
        .ask("GET", path, &[("range", "bytes=0-31"), ("if-range", &strong)])
        .await;
    assert_eq!((same.status, same.body.len()), (StatusCode::PARTIAL_CONTENT, 32));
    let beyond = service.ask("GET", path, &[("range", "bytes=999999-")]).await;
    assert_eq!(beyond.status, StatusCode::RANGE_NOT_SATISFIABLE);
    assert_eq!(beyond.header(header::CONTENT_RANGE), format!("bytes */{length}"));
    for headers in [
        [("range", "lines=1-2"), ("accept", "*/*")],
        [("range", "bytes=0-31"), ("if-range", "\"old\"")],
        [("range", "bytes=0-31"), ("if-range", weak.as_str())],
        [("range", "bytes=0-31"), ("if-range", "*")],
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
        assert!(tag.starts_with('"') && tag.len() >= 18, "{path}: {tag}");
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
async fn beside_the_data_is_ground_for_clients_and_no_tile_of_ours() {
    let service = Service::new();
    let beside = service.get("/square/1/0/1.terrain").await;
    assert_eq!(beside.status, StatusCode::OK);
    assert_ne!(
        beside.header(header::ETAG),
        service.get("/square/1/0/0.terrain").await.header(header::ETAG)
    );
    assert_eq!(service.get("/square/1/0/1.spt").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn what_is_not_there_is_404_and_nonsense_is_400() {
    let service = Service::new();
    let cases = [
        ("/square/2/0/0.terrain", 404, "tileset “square” has no tile 2/0/0"),
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
async fn a_damaged_tile_is_the_servers_fault_tells_no_path_and_does_not_stop_it() {
    let service = Service::new();
    let mut bytes = fs::read(service.archive()).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(service.archive(), bytes).unwrap();
    // One holds bytes that are no tile, the other one's are damaged.
    for path in ["/square/2/5/3.terrain", "/square/2/5/3.spt"] {
        let reply = service.get(path).await;
        assert_eq!(reply.status, StatusCode::INTERNAL_SERVER_ERROR);
        assert_eq!(reply.json()["error"], "the server failed; its log says why");
        assert_eq!(reply.header(header::ETAG), "");
        assert_eq!(reply.header(header::CACHE_CONTROL), "no-store");
    }
    assert_eq!(service.get("/square/1/0/0.terrain").await.status, StatusCode::OK);
}

/// Writes another archive over the file of a service's; one tile is a metre higher in it. Gives the bytes of that.
fn overwrite(service: &Service) -> Vec<u8> {
    let mut higher = tile(address(1, 0, 0));
    let partition = &mut higher.partition;
    let positions = partition.positions.iter_mut().chain(&mut partition.blue_positions);
    positions.for_each(|position| position.z += 1.0);
    let higher = spt::encode(&higher).unwrap();
    let other = service.folder.path().join("other");
    let mut writer = Writer::create(&other).unwrap();
    for address in [address(0, 0, 0), address(0, 1, 0)] {
        writer.add(address, &spt::encode(&tile(address)).unwrap()).unwrap();
    }
    writer.add(address(1, 0, 0), &higher).unwrap();
    writer.finish(&metadata()).unwrap();
    fs::copy(&other, service.archive()).unwrap();
    higher
}

#[tokio::test]
async fn of_an_archive_that_is_overwritten_no_byte_goes_out_under_the_name_of_the_other() {
    let service = Service::new();
    let path = "/square/1/0/0.spt";
    let version = version(&service).await;
    let before = service.get(&format!("{path}?v={version}")).await;
    let remembered = service.get(&format!("{path}?v={version}")).await;
    assert_eq!(remembered.body, before.body);
    let higher = overwrite(&service);
    let elsewhere = service.get("/square/2/5/3.spt").await;
    assert_eq!(elsewhere.status, StatusCode::NOT_FOUND, "the file is looked at again");
    let after = service.get(&format!("{path}?v={version}")).await;
    assert_eq!(after.body, higher);
    assert_ne!(after.header(header::ETAG), before.header(header::ETAG));
    assert_eq!(
        after.header(header::CACHE_CONTROL),
        "public, no-cache",
        "{version} is gone"
    );
}

#[tokio::test]
async fn rasters_of_an_archive_that_is_overwritten_are_those_of_the_new_one() {
    for path in ["/square/terrarium/1/0/1.png", "/square/gradients/1/0/0.png"] {
        let service = Service::new();
        let before = version(&service).await;
        overwrite(&service);
        let reply = service.get(path).await;
        assert_eq!(reply.status, StatusCode::OK, "{path}");
        assert_ne!(version(&service).await, before);
    }
}

#[tokio::test]
async fn only_requests_with_one_host_and_a_told_length_are_answered() {
    let service = Service::new();
    let reply = service.ask("GET", "/healthz", &[("host", "there")]).await;
    assert_eq!(reply.status, StatusCode::BAD_REQUEST);
    let reply = service
        .ask("POST", "/tilesets", &[("transfer-encoding", "chunked")])
        .await;
    assert_eq!(reply.status, StatusCode::LENGTH_REQUIRED);
    assert_eq!(reply.header(header::CONNECTION), "close");
}

#[tokio::test]
async fn the_token_opens_everything_but_what_tells_health() {
    let service = Service::with(Settings {
        token: Some("open sesame".to_owned()),
        ..Settings::default()
    });
    for path in ["/tilesets", "/square/1/0/0.spt", "/metrics", "/"] {
        for (shown, expected) in [
            ("", 401),
            ("Bearer open", 401),
            ("open sesame", 401),
            ("Bearer open sesame", 200),
        ] {
            let reply = service.ask("GET", path, &[("authorization", shown)]).await;
            assert_eq!(reply.status.as_u16(), expected, "{path} {shown}");
        }
    }
    assert_eq!(
        service.get("/tilesets").await.header(header::WWW_AUTHENTICATE),
        "Bearer"
    );
    assert_eq!(service.get("/healthz").await.status, StatusCode::OK);
    let asked = [("origin", "http://a.example"), ("access-control-request-method", "GET")];
    assert_eq!(service.ask("OPTIONS", "/tilesets", &asked).await.status, StatusCode::OK);
}

#[tokio::test]
async fn an_operator_may_name_the_pages_that_read_and_the_path_before_all_others() {
    let service = Service::with(Settings {
        base_path: "/earth".to_owned(),
        allow_origin: vec!["http://a.example".to_owned()],
        ..Settings::default()
    });
    let list = service.get("/earth/tilesets").await.json();
    let tile = format!("/earth/square/1/0/0.terrain?v={}", list[0]["version"].as_str().unwrap());
    let pages = [("http://a.example", "http://a.example"), ("http://b.example", "")];
    // The tile comes from memory the second time.
    let tile = (tile.as_str(), "accept, accept-encoding");
    for ((path, varying), (origin, allowed)) in [("/earth/square/layer.json", "accept-encoding"), tile, tile]
        .into_iter()
        .flat_map(|path| pages.map(|page| (path, page)))
    {
        let reply = service.ask("GET", path, &[("origin", origin)]).await;
        assert_eq!(reply.status, StatusCode::OK);
        assert_eq!(reply.header(header::ACCESS_CONTROL_ALLOW_ORIGIN), allowed, "{path}");
        let told: Vec<_> = reply.headers.get_all(header::VARY).iter().collect();
        assert_eq!(told, [varying, "origin"], "{path}");
    }
    assert_eq!(
        service.get("/earth/").await.header(header::CONTENT_TYPE),
        "text/html; charset=utf-8"
    );
    assert_eq!(service.get("/square/layer.json").await.status, StatusCode::NOT_FOUND);
}

async fn version(service: &Service) -> String {
    let list = service.get("/tilesets").await.json();
    list[0]["version"].as_str().unwrap().to_owned()
}

#[tokio::test]
async fn what_was_asked_before_is_answered_alike_from_memory_and_other_questions_are_not() {
    let service = Service::with(Settings {
        token: Some("secret".to_owned()),
        ..Settings::default()
    });
    let token = ("authorization", "Bearer secret");
    let list = service.ask("GET", "/tilesets", &[token]).await.json();
    let path = format!("/square/1/0/0.terrain?v={}", list[0]["version"].as_str().unwrap());
    let gzip = ("accept-encoding", "gzip");
    let first = service.ask("GET", &path, &[token, gzip]).await;
    let again = service.ask("GET", &path, &[token, gzip]).await;
    assert_eq!(
        (again.status, &again.headers, &again.body),
        (first.status, &first.headers, &first.body)
    );
    assert!(again.header(header::CACHE_CONTROL).contains("immutable"));
    assert_eq!(again.header(header::ACCESS_CONTROL_ALLOW_ORIGIN), "*");

    assert_eq!(
        service.ask("GET", &path, &[gzip]).await.status,
        StatusCode::UNAUTHORIZED
    );
    let plain = service.ask("GET", &path, &[token]).await;
    assert_eq!(
        (plain.header(header::CONTENT_ENCODING), &plain.body),
        ("", &first.plain())
    );
    let normals = ("accept", "application/vnd.quantized-mesh;extensions=octvertexnormals");
    assert!(
        service
            .ask("GET", &path, &[token, gzip, normals])
            .await
            .mesh()
            .normals
            .is_some()
    );
    let tag = first.header(header::ETAG);
    let has_it = service.ask("GET", &path, &[token, gzip, ("if-none-match", tag)]).await;
    assert_eq!(has_it.status, StatusCode::NOT_MODIFIED);
    let part = service.ask("GET", &path, &[token, gzip, ("range", "bytes=2-5")]).await;
    assert_eq!(
        (part.status, part.body.as_slice()),
        (StatusCode::PARTIAL_CONTENT, &first.body[2..6])
    );
    let head = service.ask("HEAD", &path, &[token, gzip]).await;
    assert_eq!((head.status, head.body.len()), (StatusCode::OK, 0));
    // Without the version the answer may change.
    for _ in 0..2 {
        service.ask("GET", "/square/1/0/0.terrain", &[token, gzip]).await;
    }
    let text = String::from_utf8(service.ask("GET", "/metrics", &[token]).await.body).unwrap();
    assert!(text.contains("terrain_remembered_answers_total 1\n"), "{text}");
}

#[tokio::test]
async fn answers_are_counted_by_route_and_status() {
    let service = Service::new();
    for path in [
        "/square/1/0/0.spt",
        "/square/1/0/0.spt",
        "/square/9/0/0.spt",
        "/nothing",
    ] {
        service.get(path).await;
    }
    let text = String::from_utf8(service.get("/metrics").await.body).unwrap();
    for line in [
        "terrain_requests_total{route=\"spt\",status=\"200\"} 2",
        "terrain_requests_total{route=\"spt\",status=\"404\"} 1",
        "terrain_requests_total{route=\"page\",status=\"404\"} 1",
        "terrain_answer_seconds_count{route=\"page\"} 1",
        "terrain_tilesets 1",
    ] {
        assert!(text.lines().any(|other| other == line), "{line}\n{text}");
    }
}

#[tokio::test]
async fn curved_models_are_served_as_they_are() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("web/test/torus.clod");
    let file = ModelFile::open(&path).unwrap();
    let service = Service::of(vec![file], Settings::default());
    let reply = service.get("/torus/curved.clod").await;
    assert_eq!(reply.status, StatusCode::OK);
    assert_eq!(reply.body, fs::read(&path).unwrap());
    assert_eq!(service.get("/square/curved.clod").await.status, StatusCode::NOT_FOUND);
    assert_eq!(service.get("/square/layer.json").await.status, StatusCode::OK);
    assert!(ModelFile::open(&path.with_file_name("page.test.mjs")).is_err());
}

#[tokio::test]
async fn progressive_meshes_are_served_as_they_are() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../codec/golden/open_torus.spm");
    let file = ModelFile::open(&path).unwrap();
    let service = Service::of(vec![file], Settings::default());
    let reply = service.get("/open_torus/model.spm").await;
    assert_eq!(reply.status, StatusCode::OK);
    assert_eq!(reply.body, fs::read(&path).unwrap());
    assert_eq!(
        service.get("/open_torus/curved.clod").await.status,
        StatusCode::NOT_FOUND
    );
    let damaged = tempfile::Builder::new().suffix(".spm").tempfile().unwrap();
    fs::write(damaged.path(), &reply.body[..reply.body.len() - 1]).unwrap();
    assert!(ModelFile::open(damaged.path()).is_err());
}
