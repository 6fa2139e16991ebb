//! The viewer: the files of `web/dist`, embedded when the program was built.

use axum::body::Bytes;
use axum::http::{HeaderMap, Uri};
use axum::response::Response;
use rust_embed::{EmbeddedFile, RustEmbed};

use crate::answer::{Answer, Failure};

#[derive(RustEmbed)]
#[folder = "web/dist"]
struct Files;

/// The embedded file at the request's path; `/` is `index.html`.
pub(crate) async fn embedded(uri: Uri, headers: HeaderMap) -> Result<Response, Failure> {
    let path = match uri.path().trim_start_matches('/') {
        "" => "index.html",
        path => path,
    };
    let EmbeddedFile { data, .. } =
        Files::get(path).ok_or_else(|| Failure::NotFound(format!("there is nothing at /{path}")))?;
    // The bundler puts a hash of the content in the names below assets/.
    let answer = Answer::new(content_type(path), Bytes::from(data.into_owned()));
    Ok(answer.immutable(path.starts_with("assets/")).respond(&headers))
}

fn content_type(path: &str) -> &'static str {
    match path.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("json" | "map") => "application/json",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("ico") => "image/x-icon",
        Some("woff2") => "font/woff2",
        _ => "application/octet-stream",
    }
}
