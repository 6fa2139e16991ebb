//! What happens, as figures for Prometheus and as lines of the access log.

use std::net::SocketAddr;
use std::time::Instant;

use axum::body::HttpBody;
use axum::extract::{ConnectInfo, Request, State};
use axum::http::header;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::failure::Failure;
use crate::guard;
use crate::remembered::Question;
use crate::service::Service;

/// Target of the lines of the access log.
pub const ACCESS: &str = "access";

/// Ends of paths, or of names of files, that are counted apart; all others are the page's.
const ROUTES: [&str; 11] = [
    "terrain", "spt", "json", "tilesets", "png", "webp", "height", "profile", "metrics", "healthz", "readyz",
];

/// Refuses the request or has it answered; counts the answer, and logs it.
pub(crate) async fn observe(State(service): State<Service>, request: Request, next: Next) -> Response {
    let start = Instant::now();
    let route = route(request.uri().path());
    let asked = service.has_access_log.then(|| Asked::of(&request));
    let response = match guard::check(&service, &request) {
        Ok(()) => answer(&service, request, next).await,
        Err(failure) => failure.into_response(),
    };
    let (elapsed, status) = (start.elapsed(), response.status().as_u16());
    let bytes = response.body().size_hint().lower();
    service.metrics.count(route, status, elapsed, bytes);
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

/// From memory, or by whoever knows.
async fn answer(service: &Service, request: Request, next: Next) -> Response {
    let Some(question) = Question::of(&request) else {
        return next.run(request).await;
    };
    let epoch = service.catalogue.epoch();
    if let Some(response) = service.remembered.answer(&question, epoch, &service.bodies) {
        service.metrics.remembered.inc();
        return response;
    }
    let response = next.run(request).await;
    service.remembered.keep(question, epoch, &response);
    response
}

/// What kind of thing is asked for, by the end of its path: one of a few, whatever is asked.
fn route(path: &str) -> &'static str {
    let end = path.rsplit(['/', '.']).next().unwrap_or_default();
    ROUTES.into_iter().find(|route| *route == end).unwrap_or("page")
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
    let tilesets = service.catalogue.tilesets().len();
    let text = service.metrics.text(tilesets).map_err(Failure::internal)?;
    let content_type = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    Ok(([(header::CONTENT_TYPE, content_type)], text).into_response())
}
