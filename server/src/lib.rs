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
//! | `/{name}/{z}/{x}/{y}.spt` | our own tile, by byte ranges where asked |
//!
//! Errors are one sentence of JSON: `{"error": "…"}`; 400 for what no archive could have, 404 for what these do not have.

mod answer;
mod bodies;
mod catalogue;
mod coding;
mod failure;
mod guard;
mod listen;
mod observe;
mod page;
mod settings;
mod tiles;
mod tileset;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use tower_http::cors::{AllowOrigin, Any, CorsLayer};
use tower_http::timeout::{RequestBodyTimeoutLayer, TimeoutLayer};

use bodies::Bodies;
pub use catalogue::Catalogue;
use failure::Failure;
pub use listen::serve;
pub use observe::{ACCESS, Metrics};
pub use settings::{AccessLog, Given, Settings};
use tileset::Tileset;

/// All that the handlers share.
type Service = Arc<Shared>;

/// What a server is made of, besides its connections.
pub struct Shared {
    /// The archives.
    pub catalogue: Arc<Catalogue>,
    /// The figures.
    pub metrics: Metrics,
    bodies: Bodies,
    token: Option<String>,
    is_stopping: AtomicBool,
}

impl Shared {
    /// A server of `catalogue`.
    #[must_use]
    pub fn new(catalogue: Catalogue, settings: &Settings) -> Arc<Self> {
        Arc::new(Self {
            catalogue: Arc::new(catalogue),
            metrics: Metrics::default(),
            bodies: Bodies::new(settings.cache << 20),
            token: settings.token.clone(),
            is_stopping: AtomicBool::new(false),
        })
    }

    /// From now on the server says that it is not ready.
    pub fn is_about_to_stop(&self) {
        self.is_stopping.store(true, Ordering::Relaxed);
    }

    /// Looks at the archives again, on a thread where that may block.
    pub async fn look_again(&self) {
        let catalogue = Arc::clone(&self.catalogue);
        if let Err(error) = tokio::task::spawn_blocking(move || catalogue.refresh()).await {
            tracing::error!("the archives could not be looked at: {error}");
        }
    }

    fn find(&self, name: &str) -> Result<Arc<Tileset>, Failure> {
        self.catalogue
            .find(name)
            .ok_or_else(|| Failure::NotFound(format!("there is no tileset “{name}”; /tilesets lists those there are")))
    }
}

/// The whole service.
///
/// # Errors
/// When an origin of the settings cannot stand in a header.
pub fn router(service: Arc<Shared>, settings: &Settings) -> Result<Router, header::InvalidHeaderValue> {
    let seconds = Duration::from_secs(settings.answer_timeout);
    let router = Router::new()
        .route("/healthz", get("ok"))
        .route("/readyz", get(ready))
        .route("/metrics", get(observe::metrics))
        .route("/tilesets", get(tiles::list))
        .route("/{name}/layer.json", get(tiles::layer_json))
        .route("/{name}/{z}/{x}/{file}", get(tiles::tile))
        .fallback(page::embedded)
        .layer(DefaultBodyLimit::max(settings.max_body << 10))
        .layer(TimeoutLayer::with_status_code(StatusCode::REQUEST_TIMEOUT, seconds))
        .layer(RequestBodyTimeoutLayer::new(seconds))
        .layer(from_fn_with_state(Arc::clone(&service), guard::guard))
        .layer(cross_origin(&settings.allow_origin)?)
        .layer(from_fn_with_state(Arc::clone(&service), observe::observe))
        .with_state(service);
    Ok(match settings.base_path.as_str() {
        "" => router,
        base => Router::new().nest_service(base, router),
    })
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
    if service.is_stopping.load(Ordering::Relaxed) {
        (StatusCode::SERVICE_UNAVAILABLE, "stopping")
    } else if service.catalogue.tilesets().is_empty() {
        (StatusCode::SERVICE_UNAVAILABLE, "no archive")
    } else {
        (StatusCode::OK, "ok")
    }
}
