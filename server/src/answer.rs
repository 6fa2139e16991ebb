//! Answers as HTTP (RFC 9110) wants them: strong ETags, conditions, ranges.
//!
//! What is said of a body is known before the body is: a client that has it already costs no reading and no hashing.

use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use http_range_header::parse_range_header;

use crate::bodies::Key;
use crate::coding::Coding;

/// What is said of a body.
#[derive(Clone)]
pub(crate) struct Description {
    content_type: HeaderValue,
    /// In its quotes.
    tag: HeaderValue,
    coding: Coding,
    immutable: bool,
    vary: Option<&'static str>,
}

impl Description {
    /// Of a body that has changed exactly if `tag` has. The tag is letters, digits and hyphens.
    pub(crate) fn new(content_type: &'static str, tag: &str, coding: Coding) -> Self {
        let tag = match coding {
            Coding::Identity => format!("\"{tag}\""),
            coding => format!("\"{tag}-{}\"", coding.name()),
        };
        Self {
            content_type: HeaderValue::from_static(content_type),
            tag: HeaderValue::try_from(tag).expect("letters, digits and hyphens in quotes"),
            coding,
            immutable: false,
            vary: None,
        }
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

    /// 304, if the client has the body already.
    pub(crate) fn not_modified(&self, headers: &HeaderMap) -> Option<Response> {
        let conditions = headers.get_all(header::IF_NONE_MATCH);
        let mut tags = conditions
            .into_iter()
            .filter_map(|value| value.to_str().ok())
            .flat_map(|value| value.split(','))
            // Weak ones count: what a proxy compressed is still the same tile.
            .map(|tag| tag.trim().trim_start_matches("W/"));
        tags.any(|tag| tag == "*" || tag.as_bytes() == self.tag.as_bytes())
            .then(|| self.described(StatusCode::NOT_MODIFIED.into_response()))
    }

    /// The response to a request with `headers`: 200, 206, 304 or 416.
    pub(crate) fn respond(&self, headers: &HeaderMap, body: Bytes) -> Response {
        if let Some(response) = self.not_modified(headers) {
            return response;
        }
        let length = body.len();
        let response = match self.part(headers, length) {
            Part::Whole => body.into_response(),
            Part::Range(first, last) => {
                let content_range = [(header::CONTENT_RANGE, format!("bytes {first}-{last}/{length}"))];
                (StatusCode::PARTIAL_CONTENT, content_range, body.slice(first..=last)).into_response()
            }
            Part::Unsatisfiable => {
                let content_range = [(header::CONTENT_RANGE, format!("bytes */{length}"))];
                return self.described((StatusCode::RANGE_NOT_SATISFIABLE, content_range).into_response());
            }
        };
        let mut response = self.described(response);
        let fields = response.headers_mut();
        fields.insert(header::CONTENT_TYPE, self.content_type.clone());
        fields.insert(header::ACCEPT_RANGES, HeaderValue::from_static("bytes"));
        if self.coding != Coding::Identity {
            fields.insert(header::CONTENT_ENCODING, HeaderValue::from_static(self.coding.name()));
        }
        response
    }

    /// The same where the body is the one at `key`, and says so if the address changes with it.
    pub(crate) fn respond_from(&self, key: Key, headers: &HeaderMap, body: Bytes) -> Response {
        let mut response = self.respond(headers, body);
        if self.immutable {
            response.extensions_mut().insert(key);
        }
        response
    }

    fn described(&self, mut response: Response) -> Response {
        let cache = if self.immutable {
            "public, max-age=31536000, immutable"
        } else {
            "public, no-cache"
        };
        let fields = response.headers_mut();
        fields.insert(header::CACHE_CONTROL, HeaderValue::from_static(cache));
        fields.insert(header::ETAG, self.tag.clone());
        if let Some(vary) = self.vary {
            fields.insert(header::VARY, HeaderValue::from_static(vary));
        }
        response
    }

    /// What a Range header asks for. Several ranges at once, other units, and a range of what the client has an outdated
    /// part of get the whole, as the standard allows. If-Range takes strong tags only (RFC 9110, 13.1.5), and here no dates.
    fn part(&self, headers: &HeaderMap, length: usize) -> Part {
        let is_current = headers.get(header::IF_RANGE).is_none_or(|tag| tag == self.tag);
        let text = headers.get(header::RANGE).and_then(|value| value.to_str().ok());
        let Some(parsed) = text
            .filter(|_| is_current)
            .and_then(|text| parse_range_header(text).ok())
        else {
            return Part::Whole;
        };
        match parsed.validate(length as u64).as_deref() {
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
