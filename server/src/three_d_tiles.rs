//! Requests for 3D Tiles: two tilesets of each archive.

mod part;

use axum::Router;
use axum::extract::{Path, Request, State};
use axum::response::Response;
use axum::routing::get;
use terrain_codec::address::TileAddress;
use terrain_tiles::formats::three_d_tiles::{DOCUMENT_ZOOMS, Packing, SUBTREE_LEVELS};

use crate::coding::Coding;
use crate::failure::Failure;
use crate::service::Service;
use crate::tiles::answer_from;

use crate::form::{Form, TileRequest, tile_address, whole_number};
pub(crate) use part::Part;

pub(crate) fn routes() -> Router<Service> {
    Router::new()
        .route("/{name}/3d-tiles/tileset.json", get(explicit))
        .route("/{name}/3d-tiles/{z}/{x}/{file}", get(of_explicit))
        .route("/{name}/3d-terrain/tileset.json", get(implicit))
        .route("/{name}/3d-terrain/{root}/{z}/{x}/{file}", get(of_implicit))
}

/// Where documents are that stand for no tile.
const EARTH: TileAddress = TileAddress { zoom: 0, x: 0, y: 0 };

async fn explicit(state: State<Service>, path: Path<String>, request: Request) -> Result<Response, Failure> {
    let part = Part::Explicit(asked_packing(&request)?);
    answer(state, path, EARTH, part, request).await
}

async fn implicit(state: State<Service>, path: Path<String>, request: Request) -> Result<Response, Failure> {
    let part = Part::Implicit(asked_packing(&request)?);
    answer(state, path, EARTH, part, request).await
}

async fn of_explicit(
    state: State<Service>,
    Path((name, z, x, file)): Path<(String, String, String, String)>,
    request: Request,
) -> Result<Response, Failure> {
    let (_, ending) = file.split_once('.').unwrap_or((&file, ""));
    let address = tile_address([&z, &x, &file])?;
    let part = match ending {
        "glb" => Part::Measured(asked_packing(&request)?),
        "json" if address.zoom.is_multiple_of(DOCUMENT_ZOOMS) && address.zoom > 0 => {
            Part::Document(asked_packing(&request)?)
        }
        "json" => {
            return Err(Failure::NotFound(format!(
                "documents are at every {DOCUMENT_ZOOMS}th zoom"
            )));
        }
        _ => {
            return Err(Failure::BadRequest(format!(
                "tiles end in .glb, documents in .json, not in “{file}”"
            )));
        }
    };
    answer(state, Path(name), address, part, request).await
}

async fn of_implicit(
    state: State<Service>,
    Path((name, root, z, x, file)): Path<(String, String, String, String, String)>,
    request: Request,
) -> Result<Response, Failure> {
    let (_, ending) = file.split_once('.').unwrap_or((&file, ""));
    let address = address_below_root(&root, [&z, &x, &file])?;
    let part = match ending {
        "glb" => Part::Whole(asked_packing(&request)?),
        "subtree" if address.zoom.is_multiple_of(SUBTREE_LEVELS) => Part::Subtree,
        "subtree" => {
            return Err(Failure::NotFound(format!(
                "subtrees are at every {SUBTREE_LEVELS}th zoom"
            )));
        }
        _ => {
            return Err(Failure::BadRequest(format!(
                "tiles end in .glb, subtrees in .subtree, not in “{file}”"
            )));
        }
    };
    answer(state, Path(name), address, part, request).await
}

/// `packing=…` in the query; plain if it is not there.
fn asked_packing(request: &Request) -> Result<Packing, Failure> {
    let query = request.uri().query().unwrap_or_default();
    let mut asked = query.split('&').filter_map(|part| part.strip_prefix("packing="));
    asked.next().map_or(Ok(Packing::Plain), |name| {
        Packing::named(name).ok_or_else(|| Failure::BadRequest(format!("a packing is plain or meshopt, not “{name}”")))
    })
}

/// Columns are counted from each root's west.
fn address_below_root(root: &str, place: [&str; 3]) -> Result<TileAddress, Failure> {
    let below = tile_address(place)?;
    let columns = 1_u32 << below.zoom;
    let root = whole_number(root).filter(|&root| root < 2 && below.x < columns);
    let root = root.ok_or_else(|| {
        Failure::BadRequest("there are the roots 0 and 1, each with 2^z columns at zoom z".to_owned())
    })?;
    Ok(TileAddress {
        x: below.x + root * columns,
        ..below
    })
}

async fn answer(
    State(service): State<Service>,
    Path(name): Path<String>,
    address: TileAddress,
    part: Part,
    request: Request,
) -> Result<Response, Failure> {
    let (headers, query) = (request.headers(), request.uri().query().unwrap_or_default());
    let form = Form::ThreeDTiles {
        part,
        coding: Coding::accepted(headers),
    };
    answer_from(&service, &name, &TileRequest { address, form }, query, headers).await
}
