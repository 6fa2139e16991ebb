//! Answers as HTTP (RFC 9110) wants them: strong ETags of the content, conditions, ranges, and failures in one sentence.

use std::fmt;

use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use http_range_header::parse_range_header;
use twox_hash::XxHash3_128;

/// Why there is no answer.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The request makes no sense for any archive: 400.
    BadRequest(String),
    /// It makes sense, but these archives have no such thing: 404.
    NotFound(String),
    /// The archive is damaged, or the program wrong: 500.
    Internal(String),
}

impl Failure {
    pub(crate) fn internal(error: impl fmt::Display) -> Self {
        eprintln!("error: {error}");
        Self::Internal(error.to_string())
    }

    pub(crate) fn status(&self) -> StatusCode {
        match self {
            Self::BadRequest(_) => StatusCode::BAD_REQUEST,
            Self::NotFound(_) => StatusCode::NOT_FOUND,
            Self::Internal(_) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadRequest(reason) | Self::NotFound(reason) | Self::Internal(reason) => f.write_str(reason),
        }
    }
}

/// A body and what is said about it.
pub(crate) struct Answer {
    content_type: HeaderValue,
    body: Bytes,
    gzip: bool,
    ranges: bool,
    immutable: bool,
    vary: Option<&'static str>,
}

impl Answer {
    pub(crate) fn new(content_type: &'static str, body: Bytes) -> Self {
        let content_type = HeaderValue::from_static(content_type);
        Self {
            content_type,
            body,
            gzip: false,
            ranges: false,
            immutable: false,
            vary: None,
        }
    }

    /// The body is gzipped.
    pub(crate) fn with_gzip(self, gzip: bool) -> Self {
        Self { gzip, ..self }
    }

    /// Parts of the body may be asked for.
    pub(crate) fn with_ranges(self) -> Self {
        Self { ranges: true, ..self }
    }

    /// The request headers on which the body depends.
    pub(crate) fn varying_by(self, headers: &'static str) -> Self {
        Self {
            vary: Some(headers),
            ..self
        }
    }

    /// Caches need not ask again: the address changes with the content.
    pub(crate) fn immutable(self, immutable: bool) -> Self {
        Self { immutable, ..self }
    }

    /// The response to a request with `headers`: 200, 206, 304 or 416.
    pub(crate) fn respond(self, headers: &HeaderMap) -> Response {
        let etag = format!("\"{:032x}\"", XxHash3_128::oneshot(&self.body));
        let mut response = if matches(headers, header::IF_NONE_MATCH, &etag) {
            StatusCode::NOT_MODIFIED.into_response()
        } else {
            self.body_or_part(headers, &etag)
        };
        let cache = if self.immutable {
            "public, max-age=31536000, immutable"
        } else {
            "public, no-cache"
        };
        let fields = response.headers_mut();
        fields.insert(header::CACHE_CONTROL, HeaderValue::from_static(cache));
        fields.insert(
            header::ETAG,
            HeaderValue::try_from(etag).expect("hexadecimal digits in quotes"),
        );
        if let Some(vary) = self.vary {
            fields.insert(header::VARY, HeaderValue::from_static(vary));
        }
        response
    }

    fn body_or_part(&self, headers: &HeaderMap, etag: &str) -> Response {
        let length = self.body.len();
        let mut response = match self.part(headers, etag) {
            Part::Whole => self.body.clone().into_response(),
            Part::Range(first, last) => {
                let content_range = [(header::CONTENT_RANGE, format!("bytes {first}-{last}/{length}"))];
                (
                    StatusCode::PARTIAL_CONTENT,
                    content_range,
                    self.body.slice(first..=last),
                )
                    .into_response()
            }
            Part::Unsatisfiable => {
                let content_range = [(header::CONTENT_RANGE, format!("bytes */{length}"))];
                return (StatusCode::RANGE_NOT_SATISFIABLE, content_range).into_response();
            }
        };
        let fields = response.headers_mut();
        fields.insert(header::CONTENT_TYPE, self.content_type.clone());
        if self.gzip {
            fields.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        }
        if self.ranges {
            fields.insert(header::ACCEPT_RANGES, HeaderValue::from_static("bytes"));
        }
        response
    }

    /// What a Range header asks for. Several ranges at once, other units, and a range of what the client has an outdated
    /// part of (If-Range) get the whole, as the standard allows.
    fn part(&self, headers: &HeaderMap, etag: &str) -> Part {
        let outdated = headers.contains_key(header::IF_RANGE) && !matches(headers, header::IF_RANGE, etag);
        let text = headers.get(header::RANGE).and_then(|value| value.to_str().ok());
        let Some(parsed) = text
            .filter(|_| self.ranges && !outdated)
            .and_then(|text| parse_range_header(text).ok())
        else {
            return Part::Whole;
        };
        match parsed.validate(self.body.len() as u64).as_deref() {
            Ok([range]) => Part::Range(*range.start() as usize, *range.end() as usize),
            Ok(_) => Part::Whole,
            Err(_) => Part::Unsatisfiable,
        }
    }
}

/// How much of a body to send.
enum Part {
    Whole,
    /// First and last byte.
    Range(usize, usize),
    Unsatisfiable,
}

/// Whether a list of entity tags has `etag`. Weak ones count: what a proxy compressed is still the same tile.
fn matches(headers: &HeaderMap, name: HeaderName, etag: &str) -> bool {
    let tags = headers
        .get_all(name)
        .into_iter()
        .filter_map(|value| value.to_str().ok());
    tags.flat_map(|value| value.split(','))
        .map(|tag| tag.trim().trim_start_matches("W/"))
        .any(|tag| tag == etag || tag == "*")
}

/// Whether the client takes gzip, by its Accept-Encoding.
pub(crate) fn accepts_gzip(headers: &HeaderMap) -> bool {
    let values = headers
        .get_all(header::ACCEPT_ENCODING)
        .into_iter()
        .filter_map(|value| value.to_str().ok());
    let accepted = |coding: &str| {
        let (name, weight) = coding.split_once(';').unwrap_or((coding, ""));
        let refused = weight.trim().strip_prefix("q=").and_then(|q| q.parse().ok()) == Some(0.0);
        ["gzip", "x-gzip"].contains(&name.trim().to_ascii_lowercase().as_str()) && !refused
    };
    values.flat_map(|value| value.split(',')).any(accepted)
}
