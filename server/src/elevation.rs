//! The elevation service: heights at places and along paths, as this server says them, as Google's Elevation API does, and as
//! Valhalla does.
//!
//! | path | what |
//! | --- | --- |
//! | `/{name}/height` | heights at places, each with its certified error |
//! | `/{name}/profile` | heights along a path, each with its distance |
//! | `/{name}/maps/api/elevation/json` | Google's Elevation API |
//! | `/{name}/valhalla/height` | Valhalla's |
//!
//! `{name}` may be several names with commas between them: the first that has a height at a place is taken.

mod forms;
mod found;
mod google;
mod path;
mod valhalla;

use std::sync::Arc;

use axum::Router;
use axum::extract::{Path, Query, State};
use axum::response::{IntoResponse, Json, Response};
use axum::routing::get;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, OpenApi, ToSchema};

use crate::failure::Failure;
use crate::heights::{Height, Place, Status};
use crate::service::Service;
use crate::tileset::Tileset;
use forms::{Asked, places_of};
use found::{Surface, find, parse, to_millimetres};

/// What the page at `/docs/` shows.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "Terrain heights",
        description = "Heights of certified error, from the surface that is drawn."
    ),
    paths(
        height,
        height_of_many,
        profile,
        profile_of_path,
        google::elevation,
        valhalla::height,
        valhalla::height_of_shape
    )
)]
pub(crate) struct Document;

pub(crate) fn routes() -> Router<Service> {
    Router::new()
        .route("/{name}/height", get(height).post(height_of_many))
        .route("/{name}/profile", get(profile).post(profile_of_path))
        .route("/{name}/maps/api/elevation/json", get(google::elevation))
        .route(
            "/{name}/valhalla/height",
            get(valhalla::height).post(valhalla::height_of_shape),
        )
}

/// Heights at places.
#[derive(Serialize, ToSchema)]
struct Heights {
    /// What they were taken from, in the order in which it was asked.
    tilesets: Vec<Taken>,
    points: Vec<Point>,
}

/// An archive that heights were taken from.
#[derive(Serialize, ToSchema)]
struct Taken {
    name: String,
    version: String,
    /// Zoom of the surface.
    zoom: u8,
    /// What heights are above.
    heights_above: String,
    /// What those of the source were above.
    source_datum: String,
    /// Files of the source.
    source: Vec<String>,
}

/// The ground at a place.
#[derive(Serialize, ToSchema)]
struct Point {
    longitude: f64,
    latitude: f64,
    /// Metres; null where there is no ground.
    height: Option<f64>,
    /// By how many metres the source's surface may be higher or lower, certified; null where it was not measured.
    error: Option<f64>,
    status: Status,
    /// Which of the tilesets it is from, counted from 0.
    tileset: usize,
    /// Metres along the path from its beginning; of profiles only.
    #[serde(skip_serializing_if = "Option::is_none")]
    distance: Option<f64>,
}

#[utoipa::path(get, path = "/{name}/height", params(("name" = String, Path, description = "Archive, or several with commas between"), Asked, Surface),
    responses((status = 200, body = Heights), (status = 400), (status = 404)))]
async fn height(
    State(service): State<Service>,
    Path(name): Path<String>,
    Query(asked): Query<Asked>,
    Query(surface): Query<Surface>,
) -> Result<Json<Heights>, Failure> {
    answer(&service, &name, surface, asked.places()?, None).await
}

/// A batch.
#[derive(Deserialize, ToSchema)]
struct Batch {
    /// Longitude and latitude of each, at most 10,000.
    points: Vec<[f64; 2]>,
    /// Zoom of the surface: 0 is the coarsest, the default the finest.
    zoom: Option<u8>,
}

#[utoipa::path(post, path = "/{name}/height", params(("name" = String, Path)), request_body = Batch,
    responses((status = 200, body = Heights), (status = 400), (status = 404)))]
async fn height_of_many(
    State(service): State<Service>,
    Path(name): Path<String>,
    body: String,
) -> Result<Json<Heights>, Failure> {
    let Batch { points, zoom } = parse(&body)?;
    answer(&service, &name, Surface { zoom }, places_of(&points)?, None).await
}

/// A path, and how it is cut.
#[derive(Deserialize, ToSchema, IntoParams)]
#[into_params(parameter_in = Query)]
struct Cut {
    /// So many places, evenly along the path.
    samples: Option<usize>,
    /// Or metres from one place to the next, at most.
    spacing: Option<f64>,
}

#[utoipa::path(get, path = "/{name}/profile", params(("name" = String, Path), Asked, Cut, Surface),
    responses((status = 200, body = Heights), (status = 400), (status = 404)))]
async fn profile(
    State(service): State<Service>,
    Path(name): Path<String>,
    Query(asked): Query<Asked>,
    Query(cut): Query<Cut>,
    Query(surface): Query<Surface>,
) -> Result<Json<Heights>, Failure> {
    profile_along(&service, &name, surface, &asked.places()?, &cut).await
}

/// A path to take a profile along.
#[derive(Deserialize, ToSchema)]
struct AlongPath {
    /// Longitude and latitude of its corners; from one to the next runs a geodesic.
    path: Vec<[f64; 2]>,
    #[serde(flatten)]
    cut: Cut,
    /// Zoom of the surface: 0 is the coarsest, the default the finest.
    zoom: Option<u8>,
}

#[utoipa::path(post, path = "/{name}/profile", params(("name" = String, Path)), request_body = AlongPath,
    responses((status = 200, body = Heights), (status = 400), (status = 404)))]
async fn profile_of_path(
    State(service): State<Service>,
    Path(name): Path<String>,
    body: String,
) -> Result<Json<Heights>, Failure> {
    let AlongPath { path, cut, zoom } = parse(&body)?;
    profile_along(&service, &name, Surface { zoom }, &places_of(&path)?, &cut).await
}

async fn profile_along(
    service: &Service,
    name: &str,
    surface: Surface,
    corners: &[Place],
    cut: &Cut,
) -> Result<Json<Heights>, Failure> {
    let stations = match (cut.samples, cut.spacing) {
        (Some(samples), None) => path::samples(corners, samples)?,
        (None, Some(spacing)) => path::spaced(corners, spacing)?,
        (None, None) => path::corners(corners)?,
        (Some(_), Some(_)) => return Err(Failure::BadRequest("either samples or spacing cuts a path".to_owned())),
    };
    let (places, distances) = stations.into_iter().unzip();
    answer(service, name, surface, places, Some(distances)).await
}

async fn answer(
    service: &Service,
    name: &str,
    surface: Surface,
    places: Vec<Place>,
    distances: Option<Vec<f64>>,
) -> Result<Json<Heights>, Failure> {
    let found = find(service, name, surface, places).await?;
    let taken = |tileset: &Arc<Tileset>| Taken {
        name: tileset.name.clone(),
        version: tileset.version.clone(),
        zoom: surface.zoom_of(tileset),
        heights_above: tileset.metadata().source.tiles_above().to_owned(),
        source_datum: tileset.metadata().source.vertical_datum.clone(),
        source: tileset.metadata().source.files.clone(),
    };
    let point = |(index, (place, (height, tileset))): (usize, (&Place, &(Height, usize)))| Point {
        longitude: place.longitude,
        latitude: place.latitude,
        height: height.metres().map(to_millimetres),
        error: height.error(),
        status: height.status,
        tileset: *tileset,
        distance: distances.as_ref().map(|distances| distances[index]),
    };
    Ok(Json(Heights {
        tilesets: found.tilesets.iter().map(taken).collect(),
        points: found.places.iter().zip(&found.heights).enumerate().map(point).collect(),
    }))
}

/// `/openapi.json`.
pub(crate) async fn document() -> Response {
    Json(Document::openapi()).into_response()
}

#[cfg(test)]
#[path = "elevation_tests.rs"]
mod tests;
