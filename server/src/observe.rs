//! What happens, as figures for Prometheus and as lines of the access log.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Instant;

use axum::body::HttpBody;
use axum::extract::{ConnectInfo, MatchedPath, Request, State};
use axum::http::header;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;

use crate::Service;
use crate::failure::Failure;

/// Target of the lines of the access log.
pub const ACCESS: &str = "access";

/// Bounds of the classes that answers' times are counted in, seconds.
const SECONDS: [f64; 10] = [0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0];

/// All figures; shared by whoever counts.
#[derive(Clone)]
pub struct Metrics {
    registry: Arc<Registry>,
    requests: Family<Answered, Counter>,
    seconds: Family<Route, Histogram, fn() -> Histogram>,
    body_bytes: Counter,
    /// Open connections.
    pub(crate) connections: Gauge,
    /// Connections that waited because too many were open.
    pub(crate) waiting: Counter,
    tilesets: Gauge,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Route {
    route: String,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Answered {
    route: String,
    status: u16,
}

impl Default for Metrics {
    fn default() -> Self {
        let mut registry = Registry::with_prefix("terrain");
        let requests = Family::default();
        let seconds = Family::new_with_constructor(time_classes as fn() -> Histogram);
        let body_bytes = Counter::default();
        let connections = Gauge::default();
        let waiting = Counter::default();
        let tilesets = Gauge::default();
        registry.register("requests", "Answers by route and status", requests.clone());
        registry.register("answer_seconds", "Time until an answer's body begins", seconds.clone());
        registry.register("body_bytes", "Bytes of answers' bodies", body_bytes.clone());
        registry.register("connections", "Open connections", connections.clone());
        registry.register(
            "waiting_connections",
            "Connections that had to wait for others",
            waiting.clone(),
        );
        registry.register("tilesets", "Archives that are served", tilesets.clone());
        Self {
            registry: Arc::new(registry),
            requests,
            seconds,
            body_bytes,
            connections,
            waiting,
            tilesets,
        }
    }
}

fn time_classes() -> Histogram {
    Histogram::new(SECONDS)
}

/// Counts the answer, and logs it.
pub(crate) async fn observe(State(service): State<Service>, request: Request, next: Next) -> Response {
    let start = Instant::now();
    let route = match request.extensions().get::<MatchedPath>() {
        Some(path) => path.as_str().to_owned(),
        None => "page".to_owned(),
    };
    let asked = tracing::enabled!(target: ACCESS, tracing::Level::INFO).then(|| Asked::of(&request));
    let response = next.run(request).await;
    let (elapsed, status) = (start.elapsed(), response.status().as_u16());
    let bytes = response.body().size_hint().lower();
    let metrics = &service.metrics;
    metrics
        .seconds
        .get_or_create(&Route { route: route.clone() })
        .observe(elapsed.as_secs_f64());
    metrics.requests.get_or_create(&Answered { route, status }).inc();
    metrics.body_bytes.inc_by(bytes);
    if let Some(Asked {
        peer,
        method,
        uri,
        agent,
    }) = asked
    {
        let milliseconds = elapsed.as_secs_f64() * 1e3;
        tracing::info!(target: ACCESS, peer, method, uri, status, bytes, milliseconds, agent);
    }
    response
}

/// What a line of the access log tells of a request.
struct Asked {
    peer: String,
    method: String,
    uri: String,
    agent: String,
}

impl Asked {
    fn of(request: &Request) -> Self {
        let peer = request.extensions().get::<ConnectInfo<SocketAddr>>();
        let agent = request
            .headers()
            .get(header::USER_AGENT)
            .and_then(|value| value.to_str().ok());
        Self {
            peer: peer.map_or_else(|| "-".to_owned(), |ConnectInfo(peer)| peer.to_string()),
            method: request.method().to_string(),
            uri: request.uri().to_string(),
            agent: agent.unwrap_or("-").to_owned(),
        }
    }
}

/// `/metrics`, in the text format of OpenMetrics.
pub(crate) async fn metrics(State(service): State<Service>) -> Result<Response, Failure> {
    let metrics = &service.metrics;
    metrics.tilesets.set(service.catalogue.tilesets().len() as i64);
    let mut text = String::new();
    encode(&mut text, &metrics.registry).map_err(Failure::internal)?;
    let content_type = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    Ok(([(header::CONTENT_TYPE, content_type)], text).into_response())
}
