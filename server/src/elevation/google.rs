//! Google's Elevation API: its parameters, its answers, and its words for what is wrong.

use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Json, Response};
use serde::{Deserialize, Serialize};
use terrain_codec::ellipsoid::METRES_IN_A_DEGREE;
use utoipa::{IntoParams, ToSchema};

use super::forms::places_in;
use super::found::{Surface, find};
use super::path;
use crate::failure::Failure;
use crate::heights::Place;
use crate::service::Service;
use crate::tileset::Tileset;

/// What may be asked.
#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct Asked {
    /// `lat,lng|lat,lng|…`, or `enc:` and an encoded polyline.
    locations: Option<String>,
    /// The same, as a path that is cut into `samples` places.
    path: Option<String>,
    samples: Option<usize>,
}

#[derive(Serialize, ToSchema)]
struct Answer {
    results: Vec<GoogleElevation>,
    status: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_message: Option<String>,
}

#[derive(Serialize, ToSchema)]
struct GoogleElevation {
    /// Metres above what the archive's heights are above; null where nothing is measured.
    elevation: Option<f64>,
    location: Location,
    /// Metres from sample to sample of the source.
    resolution: Option<f64>,
}

#[derive(Serialize, ToSchema)]
struct Location {
    lat: f64,
    lng: f64,
}

#[utoipa::path(get, path = "/{name}/maps/api/elevation/json", params(("name" = String, Path), Asked),
    responses((status = 200, body = Answer), (status = 400)))]
pub(super) async fn elevation(
    State(service): State<Service>,
    Path(name): Path<String>,
    Query(asked): Query<Asked>,
) -> Result<Response, Failure> {
    let found = match asked.places() {
        Ok(places) => find(&service, &name, Surface::default(), places).await?,
        Err(Failure::BadRequest(reason)) => {
            let answer = Answer {
                results: Vec::new(),
                status: "INVALID_REQUEST",
                error_message: Some(reason),
            };
            return Ok((StatusCode::BAD_REQUEST, Json(answer)).into_response());
        }
        Err(failure) => return Err(failure),
    };
    let results = found
        .places
        .iter()
        .zip(&found.heights)
        .map(|(place, (height, tileset))| GoogleElevation {
            elevation: height.metres(),
            location: Location {
                lat: place.latitude,
                lng: place.longitude,
            },
            resolution: height.metres().map(|_| resolution(&found.tilesets[*tileset])),
        });
    let answer = Answer {
        results: results.collect(),
        status: "OK",
        error_message: None,
    };
    Ok(Json(answer).into_response())
}

impl Asked {
    fn places(&self) -> Result<Vec<Place>, Failure> {
        match (&self.locations, &self.path, self.samples) {
            (Some(text), None, None) => places_in(text),
            (None, Some(text), Some(samples)) => {
                let stations = path::samples(&places_in(text)?, samples)?;
                Ok(stations.into_iter().map(|(place, _)| place).collect())
            }
            _ => Err(Failure::BadRequest(
                "locations are needed, or a path with the number of samples".to_owned(),
            )),
        }
    }
}

/// From south to north; the metadata tell bounds and how many rows of samples there are.
fn resolution(tileset: &Tileset) -> f64 {
    let [_, south, _, north] = tileset.metadata().bounds;
    let cells = tileset.metadata().source.samples[1].saturating_sub(1).max(1);
    (north - south) * METRES_IN_A_DEGREE / cells as f64
}
