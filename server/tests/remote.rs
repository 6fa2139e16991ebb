//! An archive in a bucket that fails every tenth request, half of the time amid an answer, and is replaced under load; and in buckets as
//! their makers have them.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

#[expect(dead_code, reason = "the tests of the program use more of it")]
mod running;
mod service;

use std::fs;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use axum::Router;
use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use running::{Running, program};
use service::{Reply, Service, address, metadata, tile};
use terrain_codec::{LevelLimits, spt};
use terrain_server::{Catalogue, Server, Settings, Shared};
use terrain_tiles::archive::{ArchiveError, Writer};

const EVERY: usize = 10;

#[derive(Default)]
struct Bucket {
    /// The object and its entity tag.
    object: Mutex<(Vec<u8>, String)>,
    asked: AtomicUsize,
    failed: AtomicUsize,
}

impl Bucket {
    fn put(&self, bytes: Vec<u8>, tag: &str) {
        *self.object.lock().unwrap() = (bytes, format!("\"{tag}\""));
    }
}

async fn serve(State(bucket): State<Arc<Bucket>>, method: Method, headers: HeaderMap) -> Response {
    let (bytes, tag) = bucket.object.lock().unwrap().clone();
    let number = bucket.asked.fetch_add(1, Ordering::Relaxed) + 1;
    let fails = number.is_multiple_of(EVERY);
    if fails {
        bucket.failed.fetch_add(1, Ordering::Relaxed);
    }
    if fails && (method == Method::HEAD || number.is_multiple_of(2 * EVERY)) {
        return StatusCode::SERVICE_UNAVAILABLE.into_response();
    }
    let is_another = |wanted: &header::HeaderValue| wanted.as_bytes() != tag.as_bytes();
    if headers.get(header::IF_MATCH).is_some_and(is_another) {
        return StatusCode::PRECONDITION_FAILED.into_response();
    }
    let common = [
        (header::ETAG, tag.clone()),
        (header::LAST_MODIFIED, "Sun, 29 Nov 2026 08:00:00 GMT".to_owned()),
    ];
    if method == Method::HEAD {
        let length = [(header::CONTENT_LENGTH, bytes.len().to_string())];
        return (common, length).into_response();
    }
    let range = headers[header::RANGE].to_str().unwrap().strip_prefix("bytes=").unwrap();
    let (first, last) = range.split_once('-').unwrap();
    let (first, last): (usize, usize) = (first.parse().unwrap(), last.parse().unwrap());
    let part = bytes[first..=last].to_vec();
    let length = part.len();
    let body = if fails {
        let cut: [Result<Vec<u8>, &str>; 2] = [Ok(part[..length / 2].to_vec()), Err("the line broke")];
        Body::from_stream(stream::iter(cut))
    } else {
        Body::from(part)
    };
    let of_part = [
        (header::CONTENT_RANGE, format!("bytes {first}-{last}/{}", bytes.len())),
        (header::CONTENT_LENGTH, length.to_string()),
    ];
    (StatusCode::PARTIAL_CONTENT, common, of_part, body).into_response()
}

/// Where a bucket is asked, address and port.
async fn listening(bucket: &Arc<Bucket>) -> SocketAddr {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let host = listener.local_addr().unwrap();
    let routes = Router::new().fallback(serve).with_state(Arc::clone(bucket));
    tokio::spawn(async { axum::serve(listener, routes).await });
    host
}

/// Bytes of an archive whose tiles are all of one height, metres.
fn archive(height: f64) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("archive");
    let mut writer = Writer::create(&path).unwrap();
    for address in [address(0, 0, 0), address(1, 0, 0)] {
        let mut tile = tile(address);
        let heights = tile.partition.positions.iter_mut();
        heights.for_each(|position| position.z = height);
        writer.add(address, &spt::encode(&tile).unwrap()).unwrap();
    }
    writer.finish(&metadata()).unwrap();
    fs::read(path).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn no_answer_fails_or_is_wrong_while_a_bucket_fails_and_an_archive_is_replaced() {
    let bucket = Arc::new(Bucket::default());
    bucket.put(archive(500.0), "first");
    let source = format!("http://{}/maps/square.pmtiles", listening(&bucket).await);

    let settings = Settings::default();
    let height = |reply: &Reply| {
        assert_eq!(reply.status, StatusCode::OK);
        spt::decode(&reply.body, &LevelLimits::default())
            .unwrap()
            .partition
            .positions[0]
            .z
    };
    for round in 0..12 {
        let sources = vec![source.clone().into()];
        let opened = tokio::task::spawn_blocking(|| Catalogue::open(sources)).await.unwrap();
        let shared = Shared::new(opened.unwrap(), Vec::new(), &settings);
        let service = Service {
            server: Server::new(Arc::clone(&shared), &settings).unwrap(),
            folder: tempfile::tempdir().unwrap(),
        };
        let (before, after) = (500.0 + f64::from(round), 501.0 + f64::from(round));
        assert_eq!(height(&service.get("/square/1/0/0.spt").await), before);
        bucket.put(archive(after), &format!("of round {round}"));
        let meanwhile = height(&service.get("/square/0/0/0.spt").await);
        assert!([before, after].contains(&meanwhile), "{meanwhile}");
        shared.look_again().await;
        for tile in ["0/0/0", "1/0/0"] {
            assert_eq!(height(&service.get(&format!("/square/{tile}.spt")).await), after);
        }
    }
    let [asked, failed] = [&bucket.asked, &bucket.failed].map(|count| count.load(Ordering::Relaxed));
    assert!(failed >= 5 && failed == asked / EVERY, "{failed} of {asked}");

    let gone = source.replace("square", "gone");
    bucket.put(Vec::new(), "empty");
    let opened = tokio::task::spawn_blocking(|| Catalogue::open(vec![gone.into()]))
        .await
        .unwrap();
    assert!(opened.is_err_and(|error| matches!(error, ArchiveError::Unreadable(..))));
}

#[tokio::test(flavor = "multi_thread")]
async fn the_program_reads_buckets_of_three_makers() {
    let bucket = Arc::new(Bucket::default());
    bucket.put(archive(700.0), "first");
    let at = format!("http://{}", listening(&bucket).await);
    let key = serde_json::json!({
        "gcs_base_url": at, "disable_oauth": true, "client_email": "", "private_key": "", "private_key_id": "",
    });
    let key = key.to_string();
    let makers: [(&str, &[(&str, &str)]); 3] = [
        (
            "gs",
            &[("GOOGLE_SERVICE_ACCOUNT_KEY", &key), ("GOOGLE_ALLOW_HTTP", "true")],
        ),
        (
            "s3",
            &[
                ("AWS_ENDPOINT", &at),
                ("AWS_ALLOW_HTTP", "true"),
                ("AWS_REGION", "eu-north-1"),
                ("AWS_ACCESS_KEY_ID", "name"),
                ("AWS_SECRET_ACCESS_KEY", "secret"),
            ],
        ),
        (
            "az",
            &[
                ("AZURE_STORAGE_ENDPOINT", &at),
                ("AZURE_ALLOW_HTTP", "true"),
                ("AZURE_STORAGE_ACCOUNT_NAME", "name"),
                ("AZURE_STORAGE_ACCOUNT_KEY", "c2VjcmV0"),
            ],
        ),
    ];
    for (maker, settings) in makers {
        let mut command = program();
        command.arg(format!("{maker}://maps/square.pmtiles"));
        command.args(["--listen", "127.0.0.1:0"]).envs(settings.iter().copied());
        let asked = move || {
            let server = Running::of(command);
            server.get("/square/height?longitude=-157.5&latitude=-67.5")
        };
        let reply = tokio::task::spawn_blocking(asked).await.unwrap();
        assert!(
            reply.starts_with("HTTP/1.1 200") && reply.contains("\"height\":700.0,"),
            "{maker}: {reply}"
        );
    }
    // Each program looks at the object and reads of it.
    assert!(bucket.asked.load(Ordering::Relaxed) >= 6);
}
