//! Serves terrain archives over HTTP: to CesiumJS and its kin as quantized-mesh, to our own viewer as the progressive
//! tiles that they are, and to a browser the viewer itself.
//!
//! | path | what |
//! | --- | --- |
//! | `/` | the viewer, embedded in the program |
//! | `/healthz` | `ok` while the server runs |
//! | `/tilesets` | name, version and metadata of every archive, as JSON |
//! | `/{name}/layer.json` | what CesiumJS asks first |
//! | `/{name}/{z}/{x}/{y}.terrain` | quantized-mesh 1.0, normals on request |
//! | `/{name}/{z}/{x}/{y}.spt` | our own tile, by byte ranges where asked |
//! | `/curved.html?model={name}` | the viewer of curved models |
//! | `/{name}/curved.clod` | curved levels of detail |
//!
//! Errors are one sentence of JSON: `{"error": "…"}`; 400 for what no archive could have, 404 for what these do not have.

mod answer;
pub mod curved;
mod page;
mod tileset;

use std::sync::Arc;

use axum::Router;
use axum::extract::{Path, RawQuery, State};
use axum::http::{HeaderMap, Method, header};
use axum::response::{IntoResponse, Json, Response};
use axum::routing::get;
use serde_json::json;
use tower_http::cors::{Any, CorsLayer};

use answer::{Answer, Failure};
pub use tileset::Tileset;
use tileset::{Form, TileRequest};

/// All that the handlers share.
type Tilesets = Arc<Vec<Arc<Tileset>>>;

/// The whole service over `tilesets`. Of tilesets with one name only the first is ever served.
pub fn router(tilesets: Vec<Tileset>) -> Router {
    let tilesets: Tilesets = Arc::new(tilesets.into_iter().map(Arc::new).collect());
    Router::new()
        .route("/healthz", get("ok"))
        .route("/tilesets", get(list))
        .route("/{name}/layer.json", get(layer_json))
        .route("/{name}/{z}/{x}/{file}", get(tile))
        .fallback_service(get(page::embedded))
        .with_state(tilesets)
        .layer(cross_origin())
}

/// Any page may read everything here, and see the headers that range requests and caches need.
fn cross_origin() -> CorsLayer {
    CorsLayer::new()
        .allow_origin(Any)
        .allow_headers(Any)
        .allow_methods([Method::GET, Method::HEAD, Method::OPTIONS])
        .expose_headers([header::ETAG, header::CONTENT_RANGE, header::ACCEPT_RANGES])
        .vary([])
}

async fn list(State(tilesets): State<Tilesets>, headers: HeaderMap) -> Response {
    let entries: Vec<_> = tilesets
        .iter()
        .map(|tileset| json!({"name": tileset.name, "version": tileset.version, "metadata": tileset.metadata()}))
        .collect();
    json_answer(&entries.into()).respond(&headers)
}

async fn layer_json(
    State(tilesets): State<Tilesets>,
    Path(name): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    let document = find(&tilesets, &name)?.layer_json();
    Ok(json_answer(&document).respond(&headers))
}

async fn tile(
    State(tilesets): State<Tilesets>,
    Path((name, z, x, file)): Path<(String, String, String, String)>,
    RawQuery(query): RawQuery,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    let tileset = Arc::clone(find(&tilesets, &name)?);
    let query = query.unwrap_or_default();
    let request = TileRequest::parse([&z, &x, &file], &query, &headers)?;
    let is_current = query
        .split('&')
        .any(|part| part.strip_prefix("v=") == Some(&tileset.version));
    let form = request.form;
    // Reading, decoding and encoding a tile takes milliseconds of one core: not on the threads that serve sockets.
    let bytes = tokio::task::spawn_blocking(move || tileset.tile(&request))
        .await
        .map_err(Failure::internal)??;
    let answer = match form {
        Form::Progressive => Answer::new("application/octet-stream", bytes).with_ranges(),
        Form::QuantizedMesh { gzip, .. } => Answer::new("application/vnd.quantized-mesh", bytes)
            .with_gzip(gzip)
            .varying_by("accept, accept-encoding"),
    };
    Ok(answer.immutable(is_current).respond(&headers))
}

fn find<'a>(tilesets: &'a Tilesets, name: &str) -> Result<&'a Arc<Tileset>, Failure> {
    tilesets
        .iter()
        .find(|tileset| tileset.name == name)
        .ok_or_else(|| Failure::NotFound(format!("there is no tileset “{name}”; /tilesets lists those there are")))
}

fn json_answer(value: &serde_json::Value) -> Answer {
    Answer::new("application/json", value.to_string().into_bytes().into())
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        (self.status(), Json(json!({"error": self.to_string()}))).into_response()
    }
}
