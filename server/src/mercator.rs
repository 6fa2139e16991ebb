//! Requests for quantized-mesh in Web Mercator.

use axum::Router;
use axum::extract::{Path, RawQuery, Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use axum::routing::get;
use terrain_tiles::layer_json::Projection;

use crate::answer::Description;
use crate::bodies::Key;
use crate::failure::Failure;
use crate::form::MercatorRequest;
use crate::service::Service;
use crate::tiles::layer_json_in;

pub(crate) fn routes() -> Router<Service> {
    Router::new()
        .route("/{name}/mercator/layer.json", get(layer_json))
        .route("/{name}/mercator/{z}/{x}/{file}", get(tile))
}

async fn layer_json(
    State(service): State<Service>,
    Path(name): Path<String>,
    RawQuery(query): RawQuery,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    let query = query.unwrap_or_default();
    layer_json_in(Projection::WebMercator, &service, &name, &query, &headers).await
}

async fn tile(
    State(service): State<Service>,
    Path([name, z, x, file]): Path<[String; 4]>,
    request: Request,
) -> Result<Response, Failure> {
    let (headers, query) = (request.headers(), request.uri().query().unwrap_or_default());
    let wanted = MercatorRequest::parse([&z, &x, &file], query, headers)?;
    let missing = || format!("tileset “{name}” has no tile {z}/{x}/{file} of Web Mercator");
    let tileset = service.find(&name)?;
    let tag = wanted.tag(&tileset).ok_or_else(|| Failure::NotFound(missing()))?;
    let description = Description::new("application/vnd.quantized-mesh", &tag, wanted.coding)
        .varying_by("accept, accept-encoding")
        .immutable(tileset.is_named_in(query));
    if let Some(response) = description.not_modified(headers) {
        return Ok(response);
    }
    let key = Key::Mercator(tileset.generation, wanted);
    let body = service.bodies.get(key.clone(), move || wanted.body(&tileset)).await;
    let body = body.map_err(|error| error.answered(missing))?;
    Ok(description.respond_from(key, headers, body))
}
