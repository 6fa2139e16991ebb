//! Requests for quantized-mesh in Web Mercator.

use axum::Router;
use axum::extract::{Path, Request, State};
use axum::response::Response;
use axum::routing::get;
use terrain_tiles::layer_json::Projection;

use crate::failure::Failure;
use crate::form::MercatorRequest;
use crate::service::Service;
use crate::tiles::{answer_from, layer_json};

pub(crate) fn routes() -> Router<Service> {
    let document = |service, name, query, headers| layer_json(Projection::WebMercator, service, name, query, headers);
    Router::new()
        .route("/{name}/mercator/layer.json", get(document))
        .route("/{name}/mercator/{z}/{x}/{file}", get(tile))
}

async fn tile(
    State(service): State<Service>,
    Path([name, z, x, file]): Path<[String; 4]>,
    request: Request,
) -> Result<Response, Failure> {
    let (headers, query) = (request.headers(), request.uri().query().unwrap_or_default());
    let wanted = MercatorRequest::parse([&z, &x, &file], query, headers)?;
    answer_from(&service, &name, &wanted, query, headers).await
}
