//! Raster tiles of heights and of normals, drawn when they are asked for.

mod gradients;
mod request;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{Path, Query, Request, State};
use axum::http::{HeaderMap, header};
use axum::response::Response;
use axum::routing::get;
use serde::Deserialize;
use serde_json::json;
use terrain_codec::address::TileAddress;
use terrain_tiles::raster_dem::image::Encoding;
use terrain_tiles::raster_dem::{RasterForm, SIZES};
use terrain_tiles::tile_file::SquareTile;

use crate::answer::Description;
use crate::bodies::Key;
use crate::coding::Coding;
use crate::failure::Failure;
use crate::heights::Heights;
use crate::service::Service;
use crate::tiles::{Wanted, answer_from, json_document};
use crate::tileset::{TileError, Tileset};
pub(crate) use request::{GradientsRequest, RasterRequest};

pub(crate) fn routes() -> Router<Service> {
    Router::new()
        .route("/{name}/terrarium.json", get(terrarium_json))
        .route("/{name}/mapbox.json", get(mapbox_json))
        .route("/{name}/terrarium/{z}/{x}/{file}", get(terrarium))
        .route("/{name}/mapbox/{z}/{x}/{file}", get(mapbox))
        .route("/{name}/gradients/{z}/{x}/{file}", get(normals))
}

/// What may be asked of TileJSON.
#[derive(Deserialize)]
struct Asked {
    /// Pixels along a side of a tile.
    size: Option<u32>,
    /// `png` or `webp`.
    format: Option<String>,
}

async fn terrarium_json(
    state: State<Service>,
    name: Path<String>,
    asked: Query<Asked>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    tile_json(&state, &name, &asked, &headers, Encoding::Terrarium).await
}

async fn mapbox_json(
    state: State<Service>,
    name: Path<String>,
    asked: Query<Asked>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    tile_json(&state, &name, &asked, &headers, Encoding::Mapbox).await
}

async fn terrarium(state: State<Service>, path: Path<[String; 4]>, request: Request) -> Result<Response, Failure> {
    let (headers, query) = (request.headers(), request.uri().query().unwrap_or_default());
    raster(Encoding::Terrarium, &state, &path, query, headers).await
}

async fn mapbox(state: State<Service>, path: Path<[String; 4]>, request: Request) -> Result<Response, Failure> {
    let (headers, query) = (request.headers(), request.uri().query().unwrap_or_default());
    raster(Encoding::Mapbox, &state, &path, query, headers).await
}

async fn raster(
    encoding: Encoding,
    service: &Service,
    [name, z, x, file]: &[String; 4],
    query: &str,
    headers: &HeaderMap,
) -> Result<Response, Failure> {
    let wanted = RasterRequest::parse([z, x, file], query, encoding)?;
    answer_from(service, name, &wanted, query, headers).await
}

/// Normals of the square of one of our own tiles; its rows count from the south, as theirs.
async fn normals(
    State(service): State<Service>,
    Path([name, z, x, file]): Path<[String; 4]>,
    request: Request,
) -> Result<Response, Failure> {
    let query = request.uri().query().unwrap_or_default();
    let wanted = GradientsRequest::parse([&z, &x, &file])?;
    answer_from(&service, &name, &wanted, query, request.headers()).await
}

impl Wanted for RasterRequest {
    fn tag(&self, tileset: &Tileset) -> Option<String> {
        let is_there = self.is_of(tileset.metadata());
        is_there.then(|| format!("{}-{}", &tileset.version[..16], self.name()))
    }

    fn description(&self, tag: &str) -> Description {
        Description::new(self.form.format.content_type(), tag, Coding::Identity)
    }

    fn key(&self, generation: u64) -> Key {
        Key::Raster(generation, *self)
    }

    fn body(&self, tileset: &Tileset, heights: &Heights) -> Result<Bytes, TileError> {
        let ground_at = |address| heights.ground(tileset, address);
        let drawn = self.form.draw(tileset.metadata(), self.tile, ground_at);
        drawn.map(Bytes::from)
    }

    fn address(&self) -> String {
        let SquareTile { zoom, x, y } = self.tile;
        format!("{zoom}/{x}/{y}.{} of heights", self.form.format.name())
    }
}

impl Wanted for GradientsRequest {
    fn tag(&self, tileset: &Tileset) -> Option<String> {
        let TileAddress { zoom, x, y } = self.address;
        let is_there = tileset.checksum(self.address).is_some();
        let version = &tileset.version[..16];
        is_there.then(|| format!("{version}-gradients-{zoom}-{x}-{y}-{}", self.format.name()))
    }

    fn description(&self, tag: &str) -> Description {
        Description::new(self.format.content_type(), tag, Coding::Identity)
    }

    fn key(&self, generation: u64) -> Key {
        Key::Gradients(generation, *self)
    }

    fn body(&self, tileset: &Tileset, heights: &Heights) -> Result<Bytes, TileError> {
        gradients::draw(heights, tileset, self.address, self.format)
    }

    fn address(&self) -> String {
        format!("{}.{} of normals", self.address, self.format.name())
    }
}

async fn tile_json(
    service: &Service,
    name: &str,
    asked: &Asked,
    headers: &HeaderMap,
    encoding: Encoding,
) -> Result<Response, Failure> {
    let tileset = service.find(name)?;
    let form = RasterForm {
        size: request::size(asked.size.unwrap_or(SIZES[0]))?,
        encoding,
        format: request::format(asked.format.as_deref().unwrap_or("png"))?,
    };
    let address = format!(
        "{}/{name}/{}/{{z}}/{{x}}/{{y}}.{}?v={}&size={}",
        address_of(service, headers)?,
        encoding.name(),
        form.format.name(),
        tileset.version,
        form.size,
    );
    let metadata = tileset.metadata();
    let mut document = form.description(metadata, form.finest_zoom(metadata), metadata.bounds_with_outside());
    document["tilejson"] = json!("3.0.0");
    document["name"] = json!(tileset.name);
    document["tiles"] = json!([address]);
    let body = serde_json::to_vec(&document).map_err(Failure::internal)?;
    json_document(service, body.into(), headers).await
}

/// Where the client reaches this server: clients do not complete addresses that do not begin with it.
fn address_of(service: &Service, headers: &HeaderMap) -> Result<String, Failure> {
    if let Some(address) = &service.public_url {
        return Ok(address.trim_end_matches('/').to_owned());
    }
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok());
    let host = host.ok_or_else(|| Failure::BadRequest("a request has one Host".to_owned()))?;
    Ok(format!("http://{host}{}", service.base_path))
}
