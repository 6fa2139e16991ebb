//! Serves terrain archives over HTTP: to CesiumJS and its kin as quantized-mesh, to our own viewer as the progressive
//! tiles that they are, and to a browser the viewer itself.
//!
//! | path | what |
//! | --- | --- |
//! | `/` | the viewer, embedded in the program |
//! | `/healthz`, `/readyz` | `ok` while the server runs, and while it has archives and is not about to stop |
//! | `/metrics` | figures for Prometheus |
//! | `/tilesets` | name, version and metadata of every archive, as JSON |
//! | `/{name}/layer.json` | what CesiumJS asks first |
//! | `/{name}/{z}/{x}/{y}.terrain` | quantized-mesh 1.0, extensions on request |
//! | `/{name}/3d-tiles/tileset.json` | 3D Tiles with certified errors, and below it the tiles as GLB |
//! | `/{name}/3d-terrain/tileset.json` | the implicit tileset that CesiumJS takes for its globe, and below it subtrees and tiles |
//! | `/{name}/height`, `/{name}/profile` and others | heights at places and along paths: [`elevation`] |
//! | `/{name}/terrarium.json`, `/{name}/mapbox.json` | TileJSON of raster tiles of heights, and below it the tiles |
//! | `/{name}/gradients/{z}/{x}/{y}.webp` | normals of a tile's square, for light: `raster_dem/gradients.rs`, or `.png` |
//! | `/docs`, `/openapi.json` | a page to try them on, and their description |
//! | `/{name}/{z}/{x}/{y}.spt` | our own tile, by byte ranges where asked |
//! | `/curved.html?model={name}` | the viewer of curved models |
//! | `/{name}/curved.clod` | curved levels of detail |
//! | `/model.html?model={name}` | the viewer of progressive meshes |
//! | `/{name}/model.spm` | a mesh with its levels of detail |
//!
//! Errors are one sentence of JSON: `{"error": "…"}`; 400 for what no archive could have, 404 for what these do not have.

mod answer;
mod bodies;
mod catalogue;
mod coding;
mod documentation;
mod elevation;
mod failure;
mod form;
mod guard;
mod heights;
mod listen;
mod mercator;
mod metrics;
mod models;
mod observe;
mod page;
mod raster_dem;
mod remembered;
mod remote;
mod service;
mod settings;
mod three_d_tiles;
mod tiles;
mod tileset;

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use terrain_tiles::layer_json::Projection;
use tower::ServiceBuilder;
use tower_http::cors::{AllowOrigin, Any, CorsLayer};
use tower_http::timeout::{RequestBodyTimeoutLayer, TimeoutLayer};

pub use catalogue::Catalogue;
pub use listen::serve;
pub use metrics::Metrics;
pub use models::ModelFile;
pub use observe::ACCESS;
use service::Service;
pub use service::Shared;
pub use settings::{AccessLog, Given, Settings};

/// The whole service.
///
/// # Errors
/// When an origin of the settings cannot stand in a header.
pub fn router(service: Arc<Shared>, settings: &Settings) -> Result<Router, header::InvalidHeaderValue> {
    let seconds = Duration::from_secs(settings.answer_timeout);
    let services = elevation::routes()
        .layer(DefaultBodyLimit::max(settings.max_body << 10))
        .layer(RequestBodyTimeoutLayer::new(seconds))
        .layer(TimeoutLayer::with_status_code(StatusCode::REQUEST_TIMEOUT, seconds));
    let layer_json =
        |service, name, query, headers| tiles::layer_json(Projection::Geographic, service, name, query, headers);
    let router = Router::new()
        .route("/openapi.json", get(elevation::document))
        .route("/docs", get(documentation::front))
        .route("/docs/{*path}", get(documentation::file))
        .route("/healthz", get("ok"))
        .route("/readyz", get(ready))
        .route("/metrics", get(observe::metrics))
        .route("/tilesets", get(tiles::list))
        .route("/{name}/layer.json", get(layer_json))
        .route("/{name}/curved.clod", get(tiles::curved))
        .route("/{name}/model.spm", get(tiles::progressive))
        .route("/{name}/{z}/{x}/{file}", get(tiles::tile))
        .merge(services)
        .merge(raster_dem::routes())
        .merge(mercator::routes())
        .merge(three_d_tiles::routes())
        .fallback(page::embedded)
        .with_state(Arc::clone(&service));
    let router = match settings.base_path.as_str() {
        "" => router,
        base => Router::new().nest_service(base, router),
    };
    // Around the router as a whole: a layer of a router is copied for every request.
    let around = ServiceBuilder::new()
        .layer(cross_origin(&settings.allow_origin)?)
        .layer(from_fn_with_state(service, observe::observe))
        .service(router);
    Ok(Router::new().fallback_service(around))
}

/// Pages of `origins`, or all if there are none, may read everything here, and see the headers that range requests and
/// caches need.
fn cross_origin(origins: &[String]) -> Result<CorsLayer, header::InvalidHeaderValue> {
    let list: Vec<HeaderValue> = origins.iter().map(HeaderValue::try_from).collect::<Result<_, _>>()?;
    let layer = CorsLayer::new()
        .allow_headers(Any)
        .allow_methods([Method::GET, Method::HEAD, Method::POST, Method::OPTIONS])
        .expose_headers([header::ETAG, header::CONTENT_RANGE, header::ACCEPT_RANGES]);
    Ok(if list.is_empty() {
        layer.allow_origin(Any).vary([])
    } else {
        // A list goes into Vary: Origin by itself.
        layer.allow_origin(AllowOrigin::list(list)).vary([header::ORIGIN])
    })
}

async fn ready(State(service): State<Service>) -> (StatusCode, &'static str) {
    if service.is_stopping() {
        (StatusCode::SERVICE_UNAVAILABLE, "stopping")
    } else if service.catalogue.tilesets().is_empty() {
        (StatusCode::SERVICE_UNAVAILABLE, "no archive")
    } else {
        (StatusCode::OK, "ok")
    }
}
