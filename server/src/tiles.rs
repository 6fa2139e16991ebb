//! Requests for archives' lists, documents and tiles.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::{Path, RawQuery, Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use serde_json::json;
use terrain_tiles::layer_json::{LayerForm, Projection};
use terrain_tiles::tile_file::SquareTile;
use twox_hash::XxHash3_128;

use crate::answer::Description;
use crate::bodies::Key;
use crate::coding::Coding;
use crate::failure::Failure;
use crate::form::{Form, MercatorRequest, TileRequest, asked_rows};
use crate::heights::Heights;
use crate::models::ModelKind;
use crate::service::Service;
use crate::tileset::{TileError, Tileset};

/// Smaller documents are not worth compressing.
const COMPRESSED_FROM_BYTES: usize = 1 << 10;

pub(crate) async fn list(State(service): State<Service>, headers: HeaderMap) -> Result<Response, Failure> {
    let tilesets = service.catalogue.tilesets();
    let entries: Vec<_> = tilesets
        .values()
        .map(|tileset| json!({"name": tileset.name, "version": tileset.version, "metadata": tileset.metadata()}))
        .collect();
    let document = serde_json::to_vec(&entries).map_err(Failure::internal)?;
    json_document(&service, document.into(), &headers).await
}

/// `layer.json` of an archive in a projection.
pub(crate) async fn layer_json(
    projection: Projection,
    State(service): State<Service>,
    Path(name): Path<String>,
    RawQuery(query): RawQuery,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    let query = query.unwrap_or_default();
    let parents = url::form_urlencoded::parse(query.as_bytes()).filter(|(key, _)| key == "parent");
    let form = LayerForm {
        projection,
        rows: asked_rows(&query),
        parent: parents.map(|(_, url)| url.into_owned()).next(),
    };
    let document = service.find(&name)?.layer_json(&form);
    json_document(&service, document, &headers).await
}

/// A document that was made for this answer; its tag is a hash.
pub(crate) async fn json_document(service: &Service, body: Bytes, headers: &HeaderMap) -> Result<Response, Failure> {
    let coding = if body.len() < COMPRESSED_FROM_BYTES {
        Coding::Identity
    } else {
        Coding::accepted(headers)
    };
    let tag = format!("{:032x}", XxHash3_128::oneshot(&body));
    let description = Description::new("application/json", &tag, coding).varying_by("accept-encoding");
    let body = service.bodies.document(&tag, body, coding).await?;
    Ok(description.respond(headers, body))
}

/// Request for curved levels of detail.
pub(crate) async fn curved(
    State(service): State<Service>,
    Path(name): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    model(&service, ModelKind::Curved, &name, &headers)
}

/// Request for a progressive mesh.
pub(crate) async fn progressive(
    State(service): State<Service>,
    Path(name): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    model(&service, ModelKind::Progressive, &name, &headers)
}

fn model(service: &Service, kind: ModelKind, name: &str, headers: &HeaderMap) -> Result<Response, Failure> {
    let mut files = service.models.iter();
    let file = files
        .find(|file| file.kind == kind && file.name == name)
        .ok_or_else(|| Failure::NotFound(format!("there is no model “{name}” of this kind")))?;
    let description = Description::new("application/octet-stream", &file.tag, Coding::Identity);
    Ok(description.respond(headers, file.bytes.clone()))
}

pub(crate) async fn tile(
    State(service): State<Service>,
    Path((name, z, x, file)): Path<(String, String, String, String)>,
    request: Request,
) -> Result<Response, Failure> {
    let (headers, query) = (request.headers(), request.uri().query().unwrap_or_default());
    let request = TileRequest::parse([&z, &x, &file], query, headers)?;
    answer_from(&service, &name, &request, query, headers).await
}

/// What is made of one archive when it is asked for.
pub(crate) trait Wanted: Copy + Send + 'static {
    /// Changes whenever the bytes do, but for their content coding; none where there is nothing.
    fn tag(&self, tileset: &Tileset) -> Option<String>;

    /// What the answer's headers say of it.
    fn description(&self, tag: &str) -> Description;

    /// Where its body is among the bodies.
    fn key(&self, generation: u64) -> Key;

    /// The bytes; `heights` are of all archives. Blocks while it reads and encodes.
    fn body(&self, tileset: &Tileset, heights: &Heights) -> Result<Bytes, TileError>;

    /// Its address in words.
    fn address(&self) -> String;
}

impl Wanted for TileRequest {
    fn tag(&self, tileset: &Tileset) -> Option<String> {
        self.tag(tileset)
    }

    fn description(&self, tag: &str) -> Description {
        match self.form {
            Form::Progressive => Description::new("application/octet-stream", tag, self.coding()),
            Form::QuantizedMesh { .. } => quantized_mesh(tag, self.coding()),
            Form::ThreeDTiles { part, .. } => {
                Description::new(part.content_type(), tag, self.coding()).varying_by("accept-encoding")
            }
        }
    }

    fn key(&self, generation: u64) -> Key {
        Key::Tile(generation, self.address, self.form)
    }

    fn body(&self, tileset: &Tileset, _: &Heights) -> Result<Bytes, TileError> {
        self.body(tileset)
    }

    fn address(&self) -> String {
        self.address.to_string()
    }
}

impl Wanted for MercatorRequest {
    fn tag(&self, tileset: &Tileset) -> Option<String> {
        self.tag(tileset)
    }

    fn description(&self, tag: &str) -> Description {
        quantized_mesh(tag, self.coding)
    }

    fn key(&self, generation: u64) -> Key {
        Key::Mercator(generation, *self)
    }

    fn body(&self, tileset: &Tileset, _: &Heights) -> Result<Bytes, TileError> {
        self.body(tileset)
    }

    fn address(&self) -> String {
        let SquareTile { zoom, x, y } = self.tile;
        format!("{zoom}/{x}/{y} of Web Mercator, rows counted from the north")
    }
}

fn quantized_mesh(tag: &str, coding: Coding) -> Description {
    Description::new("application/vnd.quantized-mesh", tag, coding).varying_by("accept, accept-encoding")
}

/// The answer from the archive of a name.
pub(crate) async fn answer_from(
    service: &Service,
    name: &str,
    request: &impl Wanted,
    query: &str,
    headers: &HeaderMap,
) -> Result<Response, Failure> {
    let tileset = service.find(name)?;
    let answered = answer(service, &tileset, request, query, headers).await;
    let answered = match answered {
        Err(TileError::Unreadable(reason)) => {
            // Somebody may be overwriting the file.
            tracing::warn!("{reason}");
            service.look_again().await;
            let now = service.find(name)?;
            answer(service, &now, request, query, headers).await
        }
        answered => answered,
    };
    answered.map_err(|error| error.answered(|| format!("tileset “{name}” has no tile {}", request.address())))
}

async fn answer(
    service: &Service,
    tileset: &Arc<Tileset>,
    request: &impl Wanted,
    query: &str,
    headers: &HeaderMap,
) -> Result<Response, TileError> {
    let tag = request.tag(tileset).ok_or(TileError::Missing)?;
    let description = request.description(&tag).immutable(tileset.is_named_in(query));
    if let Some(response) = description.not_modified(headers) {
        return Ok(response);
    }
    let key = request.key(tileset.generation);
    let (source, heights, wanted) = (Arc::clone(tileset), service.heights.clone(), *request);
    // Reading, decoding and encoding a tile takes milliseconds of one core, drawing a raster some 100.
    let make = move || wanted.body(&source, &heights);
    let body = service.bodies.get(key.clone(), make).await?;
    Ok(description.respond_from(key, headers, body))
}
