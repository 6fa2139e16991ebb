//! Answers that were given before: where an address names the version of its archive, whoever asks the same again is answered without
//! a look at what the address means.
//!
//! ```text
//! address, Accept, Accept-Encoding, Origin ─▶ headers of the answer, and the body's place among the bodies
//! ```
//! An archive that comes, goes or changes makes all be forgotten, bodies that are no longer in memory one.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::Request;
use axum::http::uri::PathAndQuery;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::response::Response;
use quick_cache::sync::Cache;

use crate::bodies::{Bodies, Key};

/// So many answers; each takes about a kilobyte.
const MOST: usize = 1 << 14;
/// With one of these, an answer is not the usual one.
const CONDITIONS: [header::HeaderName; 5] = [
    header::RANGE,
    header::IF_RANGE,
    header::IF_MATCH,
    header::IF_NONE_MATCH,
    header::IF_MODIFIED_SINCE,
];

/// All that such an answer depends on.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Question {
    address: PathAndQuery,
    accept: Option<HeaderValue>,
    accept_encoding: Option<HeaderValue>,
    /// Other pages may be allowed less.
    origin: Option<HeaderValue>,
}

impl Question {
    /// None of a request that depends on more.
    pub(crate) fn of(request: &Request) -> Option<Self> {
        let headers = request.headers();
        let is_usual = request.method() == Method::GET && !CONDITIONS.iter().any(|name| headers.contains_key(name));
        let once = |name: header::HeaderName| {
            let mut values = headers.get_all(name).into_iter();
            let first = values.next();
            values.next().is_none().then(|| first.cloned())
        };
        Some(Self {
            address: request.uri().path_and_query().filter(|_| is_usual)?.clone(),
            accept: once(header::ACCEPT)?,
            accept_encoding: once(header::ACCEPT_ENCODING)?,
            origin: once(header::ORIGIN)?,
        })
    }
}

struct Answer {
    /// Of the catalogue.
    epoch: u64,
    headers: HeaderMap,
    body: Key,
}

pub(crate) struct Remembered(Cache<Question, Arc<Answer>>);

impl Default for Remembered {
    fn default() -> Self {
        Self(Cache::new(MOST))
    }
}

impl Remembered {
    /// `epoch` is the catalogue's now.
    pub(crate) fn answer(&self, question: &Question, epoch: u64, bodies: &Bodies) -> Option<Response> {
        let answer = self.0.get(question).filter(|answer| answer.epoch == epoch)?;
        let mut response = Response::new(Body::from(bodies.there(&answer.body)?));
        response.headers_mut().clone_from(&answer.headers);
        Some(response)
    }

    /// Keeps an answer that says which body it has: [`Key`] is among its extensions. `epoch` is that of before it was asked for.
    pub(crate) fn keep(&self, question: Question, epoch: u64, response: &Response) {
        let body = response.extensions().get::<Key>();
        if let Some(body) = body.filter(|_| response.status() == StatusCode::OK) {
            let answer = Answer {
                epoch,
                headers: response.headers().clone(),
                body: body.clone(),
            };
            self.0.insert(question, Arc::new(answer));
        }
    }
}
