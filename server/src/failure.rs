//! Why there is no answer, and what is said about it.

use std::fmt;

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde_json::json;

/// Why there is no answer.
#[derive(Clone, Debug)]
pub(crate) enum Failure {
    /// The request makes no sense for any archive: 400.
    BadRequest(String),
    /// Whoever asks has not shown the token: 401.
    Unauthorized,
    /// It makes sense, but these archives have no such thing: 404.
    NotFound(String),
    /// It has a body of no told length: 411.
    LengthRequired,
    /// The archive is damaged, or the program wrong: 500. What went wrong is in the log and nowhere else.
    Internal,
}

impl Failure {
    /// Logs what went wrong, with the paths that no client may see.
    pub(crate) fn internal(error: impl fmt::Display) -> Self {
        tracing::error!("{error}");
        Self::Internal
    }

    fn status(&self) -> StatusCode {
        match self {
            Self::BadRequest(_) => StatusCode::BAD_REQUEST,
            Self::Unauthorized => StatusCode::UNAUTHORIZED,
            Self::NotFound(_) => StatusCode::NOT_FOUND,
            Self::LengthRequired => StatusCode::LENGTH_REQUIRED,
            Self::Internal => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BadRequest(reason) | Self::NotFound(reason) => reason,
            Self::Unauthorized => "this server answers requests with its token only",
            Self::LengthRequired => "a body needs a Content-Length here, and no Transfer-Encoding",
            Self::Internal => "the server failed; its log says why",
        })
    }
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        let mut response = (self.status(), Json(json!({"error": self.to_string()}))).into_response();
        let fields = response.headers_mut();
        fields.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        match self {
            Self::Unauthorized => drop(fields.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"))),
            // Where the body ends is in doubt, and so is where the next request begins.
            Self::LengthRequired => drop(fields.insert(header::CONNECTION, HeaderValue::from_static("close"))),
            _ => {}
        }
        response
    }
}
