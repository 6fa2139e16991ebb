//! Raster tiles of heights, in Web Mercator, for MapLibre and its kin: from the surface that is drawn.
//!
//! ```text
//! pixel centres ─▶ heights of the surface of a zoom ─▶ voids filled ─▶ rounded once ─▶ numbers in colours ─▶ PNG, WebP
//! ```
//!
//! | | a colour (r, g, b) is, in metres |
//! | --- | --- |
//! | terrarium | 256 r + g + b / 256 − 32,768 |
//! | mapbox | (65,536 r + 256 g + b) / 10 − 10,000 |

mod address;
mod fill;
mod gradients;
mod image;

use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{Path, Query, Request, State};
use axum::http::{HeaderMap, header};
use axum::response::Response;
use axum::routing::get;
use serde::Deserialize;
use serde_json::json;
use terrain_tiles::address::TileAddress;

use crate::answer::Description;
use crate::bodies::Key;
use crate::coding::Coding;
use crate::failure::Failure;
use crate::form::tile_address;
use crate::heights::{Heights, Place, Status};
use crate::service::Service;
use crate::tiles::json_document;
use crate::tileset::{TileError, Tileset};
pub(crate) use address::RasterRequest;
use address::{LATITUDES, MercatorTile};
pub(crate) use image::{Encoding, Format};

/// Rounding takes no more than this part of the surface's error.
const PART_OF_ERROR: f64 = 0.25;
/// Metres: where errors are large, heights are rounded to no more than this.
const COARSEST_QUANTUM: f64 = 32.0;

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
    let format = image::Format::named(ending)?;
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
    let body = service.bodies.get(key, draw).await;
    Ok(description.respond(request.headers(), body.map_err(|error| error.answered(missing))?))
}

async fn tile_json(
    service: &Service,
    name: &str,
    wanted: &Wanted,
    headers: &HeaderMap,
    encoding: Encoding,
) -> Result<Response, Failure> {
    let tileset = service.find(name)?;
    let size = address::size(wanted.size.unwrap_or(address::SIZES[0]))?;
    let format = image::Format::named(wanted.format.as_deref().unwrap_or("png"))?;
    let finest = address::finest_zoom(&tileset, size);
    let [west, south, east, north] = tileset.metadata().bounds;
    let [west, east] = if east > 180.0 { [-180.0, 180.0] } else { [west, east] };
    let [south, north] = [south, north].map(|latitude| latitude.clamp(-LATITUDES, LATITUDES));
    let at = |zoom: u8| json!({"zoom": zoom, "error": address::error(&tileset, zoom, size), "quantum": quantum(&tileset, zoom, size, encoding)});
    let address = format!(
        "{}/{name}/{}/{{z}}/{{x}}/{{y}}.{}?v={}&size={size}",
        address_of(service, headers)?,
        encoding.name(),
        format.name(),
        tileset.version
    );
    let document = json!({
        "tilejson": "3.0.0",
        "name": tileset.name,
        "tiles": [address],
        "encoding": encoding.name(),
        "tileSize": size,
        "minzoom": 0,
        "maxzoom": finest,
        "bounds": [west, south, east, north],
        "attribution": tileset.metadata().source.files.join(", "),
        "heights_above": tileset.metadata().source.tiles_above(),
        "from": "surface",
        "zooms": (0..=finest).map(at).collect::<Vec<_>>(),
    });
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
    let description =
        Description::new(wanted.format.content_type(), &tag, Coding::Identity).immutable(tileset.is_named_in(query));
    if let Some(response) = description.not_modified(headers) {
        return Ok(response);
    }
    let key = Key::Raster(tileset.generation, wanted);
    let heights = service.heights.clone();
    let body = service.bodies.get(key, move || draw(&heights, &tileset, &wanted)).await;
    let body = body.map_err(|error| error.answered(|| format!("there is no tile {z}/{x}/{file}")))?;
    Ok(description.respond(headers, body))
}

/// Blocks for some 100 ms.
fn draw(heights: &Heights, tileset: &Arc<Tileset>, wanted: &RasterRequest) -> Result<Bytes, TileError> {
    let size = wanted.size as usize;
    let places = pixel_centres(wanted.tile, wanted.size);
    let found = heights.at(tileset, wanted.surface_zoom(tileset), &places)?;
    let mut metres: Vec<Option<f64>> = found
        .iter()
        .map(|height| match height.status {
            Status::Measured => Some(height.metres),
            Status::Outside => Some(0.0),
            Status::Void => None,
        })
        .collect();
    fill::fill_voids(&mut metres, size);
    let quantum = quantum(tileset, wanted.tile.zoom, wanted.size, wanted.encoding);
    let colours: Vec<u8> = metres
        .iter()
        .flat_map(|metres| wanted.encoding.colour(metres.unwrap_or(0.0), quantum))
        .collect();
    image::write(wanted.format, &colours, wanted.size).map_err(|error| Failure::internal(error).into())
}

/// Row by row from the north.
fn pixel_centres(tile: MercatorTile, size: u32) -> Vec<Place> {
    let at = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(size);
    let rows = (0..size).map(|row| tile.latitude(at(row)));
    rows.flat_map(|latitude| {
        (0..size).map(move |column| Place {
            longitude: tile.longitude(at(column)),
            latitude,
        })
    })
    .collect()
}

/// Metres to which heights of a zoom are rounded: a power of two times the encoding's own step.
fn quantum(tileset: &Tileset, zoom: u8, size: u32, encoding: Encoding) -> f64 {
    let most = (address::error(tileset, zoom, size) * PART_OF_ERROR).min(COARSEST_QUANTUM);
    let mut quantum = encoding.step();
    while quantum * 2.0 <= most {
        quantum *= 2.0;
    }
    quantum
}

#[cfg(test)]
#[path = "raster_dem_tests.rs"]
mod tests;
