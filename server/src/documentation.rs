//! The page to try the services on: Swagger UI over `/openapi.json`.

use std::sync::Arc;

use axum::extract::Path;
use axum::http::header;
use axum::response::{IntoResponse, Redirect, Response};
use utoipa_swagger_ui::Config;

use crate::failure::Failure;

pub(crate) async fn front() -> Redirect {
    Redirect::permanent("docs/index.html")
}

pub(crate) async fn file(Path(path): Path<String>) -> Result<Response, Failure> {
    let config = Arc::new(Config::from("../openapi.json"));
    let file = utoipa_swagger_ui::serve(&path, config).map_err(Failure::internal)?;
    let file = file.ok_or_else(|| Failure::NotFound(format!("there is nothing at /docs/{path}")))?;
    Ok(([(header::CONTENT_TYPE, file.content_type)], file.bytes.into_owned()).into_response())
}
