//! The viewer: the files of `web/dist`, embedded when the program was built.

use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, Uri};
use axum::response::Response;
use rust_embed::{EmbeddedFile, RustEmbed};

use crate::answer::Description;
use crate::coding::Coding;
use crate::failure::Failure;
use crate::service::Service;

#[derive(RustEmbed)]
#[folder = "web/dist"]
struct Files;

/// The embedded file at the request's path; `/` is `index.html`.
pub(crate) async fn embedded(
    State(service): State<Service>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    let path = match uri.path().trim_start_matches('/') {
        "" => "index.html",
        path => path,
    };
    let EmbeddedFile { data, metadata } =
        Files::get(path).ok_or_else(|| Failure::NotFound(format!("there is nothing at /{path}")))?;
    let (content_type, is_compressible) = content_type(path);
    let coding = if is_compressible {
        Coding::accepted(&headers)
    } else {
        Coding::Identity
    };
    let tag: String = metadata.sha256_hash()[..16]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    // The bundler puts a hash of the content in the names below assets/.
    let description = Description::new(content_type, &tag, coding)
        .varying_by("accept-encoding")
        .immutable(path.starts_with("assets/"));
    if let Some(response) = description.not_modified(&headers) {
        return Ok(response);
    }
    let body = service
        .bodies
        .document(&tag, Bytes::from(data.into_owned()), coding)
        .await?;
    Ok(description.respond(&headers, body))
}

/// What a file is, and whether it is worth compressing.
fn content_type(path: &str) -> (&'static str, bool) {
    match path.rsplit('.').next() {
        Some("html") => ("text/html; charset=utf-8", true),
        Some("js") => ("text/javascript; charset=utf-8", true),
        Some("css") => ("text/css; charset=utf-8", true),
        Some("json" | "map") => ("application/json", true),
        Some("wasm") => ("application/wasm", true),
        Some("svg") => ("image/svg+xml", true),
        Some("png") => ("image/png", false),
        Some("ico") => ("image/x-icon", false),
        Some("woff2") => ("font/woff2", false),
        _ => ("application/octet-stream", false),
    }
}
