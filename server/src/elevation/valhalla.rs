//! Valhalla's height service: its request, in the address or as the body, and its answers.

use axum::extract::{Path, Query, State};
use axum::response::Json;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::{IntoParams, ToSchema};

use super::forms::{decoded, places_of};
use super::found::{Surface, find, parse};
use super::path::{self, Station};

use crate::failure::Failure;
use crate::service::Service;

/// The request, as JSON in the address.
#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct InAddress {
    /// What is otherwise the body.
    json: String,
}

/// A path, and what is wanted of it.
#[derive(Deserialize, ToSchema)]
pub(super) struct Shape {
    shape: Option<Vec<Corner>>,
    /// Or a polyline of 6 decimals, or of as many as `shape_format` says.
    encoded_polyline: Option<String>,
    /// `polyline6` or `polyline5`.
    shape_format: Option<String>,
    /// With distances along the path.
    #[serde(default)]
    range: bool,
    /// Metres from place to place.
    resample_distance: Option<f64>,
    /// Decimals of heights, 0 to 2.
    #[serde(default)]
    height_precision: u8,
    id: Option<String>,
}

#[derive(Clone, Copy, Deserialize, Serialize, ToSchema)]
pub(super) struct Corner {
    lat: f64,
    lon: f64,
}

#[utoipa::path(get, path = "/{name}/valhalla/height", params(("name" = String, Path), InAddress),
    responses((status = 200, body = Value), (status = 400)))]
pub(super) async fn height(
    State(service): State<Service>,
    Path(name): Path<String>,
    Query(InAddress { json }): Query<InAddress>,
) -> Result<Json<Value>, Failure> {
    answer(&service, &name, parse(&json)?).await
}

#[utoipa::path(post, path = "/{name}/valhalla/height", params(("name" = String, Path)), request_body = Shape,
    responses((status = 200, body = Value), (status = 400)))]
pub(super) async fn height_of_shape(
    State(service): State<Service>,
    Path(name): Path<String>,
    body: String,
) -> Result<Json<Value>, Failure> {
    answer(&service, &name, parse(&body)?).await
}

async fn answer(service: &Service, name: &str, shape: Shape) -> Result<Json<Value>, Failure> {
    let stations = shape.stations()?;
    let (places, distances): (Vec<_>, Vec<f64>) = stations.into_iter().unzip();
    let found = find(service, name, Surface::default(), places).await?;
    let scale = 10_f64.powi(i32::from(shape.height_precision.min(2)));
    let heights: Vec<Value> = found
        .heights
        .iter()
        .map(|(height, _)| {
            height
                .metres()
                .map_or(Value::Null, |metres| number((metres * scale).round() / scale))
        })
        .collect();
    let corners: Vec<Corner> = found
        .places
        .iter()
        .map(|place| Corner {
            lat: place.latitude,
            lon: place.longitude,
        })
        .collect();
    let mut answer = json!({ "shape": corners });
    if shape.range {
        let pairs = distances.iter().zip(heights);
        answer["range_height"] = pairs
            .map(|(distance, height)| json!([distance.round(), height]))
            .collect();
    } else {
        answer["height"] = heights.into();
    }
    if let Some(id) = shape.id {
        answer["id"] = id.into();
    }
    Ok(Json(answer))
}

/// Whole metres without a decimal point, as Valhalla writes them.
fn number(value: f64) -> Value {
    if value.fract() == 0.0 {
        json!(value as i64)
    } else {
        json!(value)
    }
}

impl Shape {
    fn stations(&self) -> Result<Vec<Station>, Failure> {
        let places = match (&self.shape, &self.encoded_polyline, self.shape_format.as_deref()) {
            (Some(corners), None, _) => {
                let pairs: Vec<[f64; 2]> = corners.iter().map(|corner| [corner.lon, corner.lat]).collect();
                places_of(&pairs)?
            }
            (None, Some(polyline), None | Some("polyline6")) => decoded(polyline, 6)?,
            (None, Some(polyline), Some("polyline5")) => decoded(polyline, 5)?,
            _ => {
                return Err(Failure::BadRequest(
                    "a shape or an encoded polyline is needed".to_owned(),
                ));
            }
        };
        match self.resample_distance {
            Some(spacing) => path::spaced(&places, spacing),
            None if places.len() == 1 => Ok(vec![(places[0], 0.0)]),
            None => path::corners(&places),
        }
    }
}
