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
use terrain_tiles::address::TileAddress;
use terrain_tiles::raster_dem::image::Encoding;
use terrain_tiles::raster_dem::{RasterForm, SIZES};

use crate::answer::Description;
use crate::bodies::Key;
use crate::coding::Coding;
use crate::failure::Failure;
use crate::form::tile_address;
use crate::service::Service;
use crate::tiles::json_document;
pub(crate) use request::RasterRequest;

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
struct Wanted {
    /// Pixels along a side of a tile.
    size: Option<u32>,
    /// `png` or `webp`.
    format: Option<String>,
}

async fn terrarium_json(
    state: State<Service>,
    name: Path<String>,
    wanted: Query<Wanted>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    tile_json(&state, &name, &wanted, &headers, Encoding::Terrarium).await
}

async fn mapbox_json(
    state: State<Service>,
    name: Path<String>,
    wanted: Query<Wanted>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    tile_json(&state, &name, &wanted, &headers, Encoding::Mapbox).await
}

async fn terrarium(state: State<Service>, path: Path<[String; 4]>, request: Request) -> Result<Response, Failure> {
    tile(
        &state,
        &path,
        request.uri().query(),
        request.headers(),
        Encoding::Terrarium,
    )
    .await
}

async fn mapbox(state: State<Service>, path: Path<[String; 4]>, request: Request) -> Result<Response, Failure> {
    tile(
        &state,
        &path,
        request.uri().query(),
        request.headers(),
        Encoding::Mapbox,
    )
    .await
}

/// Normals of the square of one of our own tiles; its rows count from the south, as theirs.
async fn normals(
    State(service): State<Service>,
    Path([name, z, x, file]): Path<[String; 4]>,
    request: Request,
) -> Result<Response, Failure> {
    let tileset = service.find(&name)?;
    let (_, ending) = file.split_once('.').unwrap_or((&file, ""));
    let format = request::format(ending)?;
    let missing = || format!("tileset “{name}” has no normals {z}/{x}/{file}");
    let address = tile_address([&z, &x, &file])?;
    if tileset.checksum(address).is_none() {
        return Err(Failure::NotFound(missing()));
    }
    let TileAddress { zoom, x, y } = address;
    let tag = format!("{}-gradients-{zoom}-{x}-{y}-{}", &tileset.version[..16], format.name());
    let description = Description::new(format.content_type(), &tag, Coding::Identity)
        .immutable(tileset.is_named_in(request.uri().query().unwrap_or_default()));
    if let Some(response) = description.not_modified(request.headers()) {
        return Ok(response);
    }
    let key = Key::Gradients(tileset.generation, address, format);
    let heights = service.heights.clone();
    let draw = move || gradients::draw(&heights, &tileset, address, format);
    let body = service.bodies.get(key.clone(), draw).await;
    let body = body.map_err(|error| error.answered(missing))?;
    Ok(description.respond_from(key, request.headers(), body))
}

async fn tile_json(
    service: &Service,
    name: &str,
    wanted: &Wanted,
    headers: &HeaderMap,
    encoding: Encoding,
) -> Result<Response, Failure> {
    let tileset = service.find(name)?;
    let form = RasterForm {
        size: request::size(wanted.size.unwrap_or(SIZES[0]))?,
        encoding,
        format: request::format(wanted.format.as_deref().unwrap_or("png"))?,
    };
    let address = format!(
        "{}/{name}/{}/{{z}}/{{x}}/{{y}}.{}?v={}&size={}",
        address_of(service, headers)?,
        encoding.name(),
        form.format.name(),
        tileset.version,
        form.size,
    );
    let mut document = form.description(tileset.metadata(), form.finest_zoom(tileset.metadata()));
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

async fn tile(
    service: &Service,
    path: &[String; 4],
    query: Option<&str>,
    headers: &HeaderMap,
    encoding: Encoding,
) -> Result<Response, Failure> {
    let [name, z, x, file] = path;
    let query = query.unwrap_or_default();
    let tileset = service.find(name)?;
    let wanted = RasterRequest::parse([z, x, file], query, encoding, &tileset)?;
    let tag = format!("{}-{}", &tileset.version[..16], wanted.tag());
    let description = Description::new(wanted.form.format.content_type(), &tag, Coding::Identity)
        .immutable(tileset.is_named_in(query));
    if let Some(response) = description.not_modified(headers) {
        return Ok(response);
    }
    let key = Key::Raster(tileset.generation, wanted);
    let heights = service.heights.clone();
    // Blocks for some 100 ms.
    let draw = move || {
        let ground_at = |address| heights.ground(&tileset, address);
        let drawn = wanted.form.draw(tileset.metadata(), wanted.tile, ground_at);
        drawn.map(Bytes::from)
    };
    let body = service.bodies.get(key.clone(), draw).await;
    let body = body.map_err(|error| error.answered(|| format!("there is no tile {z}/{x}/{file}")))?;
    Ok(description.respond_from(key, headers, body))
}
