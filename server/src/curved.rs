//! Curved models under their names: `.clod` files, as they are.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use axum::Router;
use axum::body::Bytes;
use axum::extract::{self, State};
use axum::http::HeaderMap;
use axum::response::Response;
use axum::routing::get;
use terrain_tiles::formats::clod::{self, CurvedLimits};

use crate::answer::{Answer, Failure};

/// A file of curved levels and what it is called.
pub struct CurvedFile {
    /// The file's name without its ending.
    pub name: String,
    bytes: Bytes,
}

impl CurvedFile {
    /// Whether a file is one, by its name.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        path.extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("clod"))
    }

    /// Reads the file at `path` and looks it through.
    ///
    /// # Errors
    /// What is wrong with the file, and which.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let bytes = fs::read(path).with_context(|| path.display().to_string())?;
        clod::decode(&bytes, &CurvedLimits::default()).with_context(|| path.display().to_string())?;
        Ok(Self {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            bytes: bytes.into(),
        })
    }
}

/// The service over curved models, beside that over tilesets.
pub fn router(files: Vec<CurvedFile>) -> Router {
    Router::new()
        .route("/{name}/curved.clod", get(curved))
        .with_state(Arc::new(files))
        .layer(crate::cross_origin())
}

async fn curved(
    State(files): State<Arc<Vec<CurvedFile>>>,
    extract::Path(name): extract::Path<String>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    let file = files
        .iter()
        .find(|file| file.name == name)
        .ok_or_else(|| Failure::NotFound(format!("there is no curved model “{name}”")))?;
    let answer = Answer::new("application/octet-stream", file.bytes.clone());
    Ok(answer.with_ranges().respond(&headers))
}
