//! What happens, as figures for Prometheus and as lines of the access log.

use std::net::SocketAddr;
use std::time::Instant;

use axum::body::HttpBody;
use axum::extract::{ConnectInfo, Request, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};

use crate::failure::Failure;
use crate::service::{Service, Shared};

/// Target of the lines of the access log.
pub const ACCESS: &str = "access";

/// Ends of paths, or of names of files, that are counted apart; all others are the page's.
const ROUTES: [&str; 11] = [
    "terrain", "spt", "json", "tilesets", "png", "webp", "height", "profile", "metrics", "healthz", "readyz",
];

/// What kind of thing is asked for, by the end of its path: one of a few, whatever is asked.
fn route(path: &str) -> &'static str {
    let end = path.rsplit(['/', '.']).next().unwrap_or_default();
    ROUTES.into_iter().find(|route| *route == end).unwrap_or("page")
}

/// A request that is being answered.
pub(crate) struct Asked {
    start: Instant,
    route: &'static str,
    /// None where there is no access log.
    line: Option<Line>,
}

/// What a line of the access log tells of a request.
struct Line {
    peer: String,
    method: String,
    uri: String,
    agent: String,
}

impl Asked {
    pub(crate) fn new(service: &Shared, request: &Request) -> Self {
        Self {
            start: Instant::now(),
            route: route(request.uri().path()),
            line: service.has_access_log.then(|| Line::of(request)),
        }
    }

    /// Counts the answer, and logs it.
    pub(crate) fn answered(self, service: &Shared, response: &Response) {
        let (elapsed, status) = (self.start.elapsed(), response.status().as_u16());
        let bytes = response.body().size_hint().lower();
        service.metrics.count(self.route, status, elapsed, bytes);
        if let Some(Line {
            peer,
            method,
            uri,
            agent,
        }) = self.line
        {
            let milliseconds = elapsed.as_secs_f64() * 1e3;
            tracing::info!(target: ACCESS, peer, method, uri, status, bytes, milliseconds, agent);
        }
    }
}

impl Line {
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
    let tilesets = service.catalogue.tilesets().len();
    let text = service.metrics.text(tilesets).map_err(Failure::internal)?;
    let content_type = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    Ok(([(header::CONTENT_TYPE, content_type)], text).into_response())
}
