//! What answers requests: routes, and what is around all of them.
//!
//! ```text
//! request ─▶ asked before? ─▶ that answer
//!                         └─▶ other origins ─▶ guard ─▶ routes
//! ```

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::Response;
use axum::routing::get;
use terrain_tiles::layer_json::Projection;
use tower::{ServiceBuilder, ServiceExt};
use tower_http::cors::{AllowOrigin, Any, CorsLayer};
use tower_http::timeout::{RequestBodyTimeoutLayer, TimeoutLayer};

use crate::metrics::Metrics;
use crate::observe::Asked;
use crate::remembered::Question;
use crate::service::{Service, Shared};
use crate::settings::Settings;
use crate::{documentation, elevation, guard, mercator, observe, page, raster_dem, three_d_tiles, tiles};

/// All that answers requests.
pub struct Server {
    shared: Service,
    router: Router,
}

impl Server {
    /// # Errors
    /// When an origin of the settings cannot stand in a header.
    pub fn new(shared: Arc<Shared>, settings: &Settings) -> Result<Self, header::InvalidHeaderValue> {
        Ok(Self {
            router: router(Arc::clone(&shared), settings)?,
            shared,
        })
    }

    /// The figures.
    #[must_use]
    pub fn metrics(&self) -> &Metrics {
        &self.shared.metrics
    }

    /// Answers a request, counts the answer, and logs it.
    pub async fn answer(&self, request: Request) -> Response {
        let asked = Asked::new(&self.shared, &request);
        let response = self.remembered_or_made(request).await;
        asked.answered(&self.shared, &response);
        response
    }

    /// Without a look at the routes if the same was asked before.
    async fn remembered_or_made(&self, request: Request) -> Response {
        let shared = &self.shared;
        let question = Question::of(&request).filter(|_| guard::check(shared, &request).is_ok());
        let epoch = shared.catalogue.epoch();
        if let Some(question) = &question
            && let Some(response) = shared.remembered.answer(question, epoch, &shared.bodies)
        {
            shared.metrics.remembered.inc();
            return response;
        }
        let Ok(response) = self.router.clone().oneshot(request).await;
        if let Some(question) = question {
            shared.remembered.keep(question, epoch, &response);
        }
        response
    }
}

fn router(service: Service, settings: &Settings) -> Result<Router, header::InvalidHeaderValue> {
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
    // Around the router as a whole: a layer of a router is copied for every request. What a browser asks before it sends a token is
    // answered before the guard looks for one.
    let around = ServiceBuilder::new()
        .layer(cross_origin(&settings.allow_origin)?)
        .layer(from_fn_with_state(service, guard::guard))
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
