//! Heights of places from one archive or several.

use std::sync::Arc;

use serde::Deserialize;
use utoipa::IntoParams;

use crate::failure::Failure;
use crate::heights::{Height, Place};
use crate::service::Service;
use crate::tileset::{TileError, Tileset};

/// Which surface.
#[derive(Clone, Copy, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct Surface {
    /// Zoom of the surface: 0 is the coarsest, the default the finest.
    pub(super) zoom: Option<u8>,
}

/// Heights, and which of the tilesets each is from.
pub(super) struct Found {
    pub(super) tilesets: Vec<Arc<Tileset>>,
    pub(super) places: Vec<Place>,
    pub(super) heights: Vec<(Height, usize)>,
}

/// Heights at `places` from the tilesets that `names` has, the first that has one at each place.
pub(super) async fn find(
    service: &Service,
    names: &str,
    surface: Surface,
    places: Vec<Place>,
) -> Result<Found, Failure> {
    let tilesets: Vec<Arc<Tileset>> = names
        .split(',')
        .map(|name| service.find(name))
        .collect::<Result<_, _>>()?;
    let heights = service.heights.clone();
    let work = move || {
        let mut found: Vec<(Height, usize)> = Vec::new();
        for (index, tileset) in tilesets.iter().enumerate() {
            let here = heights.at(tileset, surface.zoom_of(tileset), &places)?;
            if index == 0 {
                found = here.into_iter().map(|height| (height, 0)).collect();
                continue;
            }
            for (best, height) in found.iter_mut().zip(here) {
                if height.status < best.0.status {
                    *best = (height, index);
                }
            }
        }
        Ok(Found {
            tilesets,
            places,
            heights: found,
        })
    };
    let joined = tokio::task::spawn_blocking(work).await.map_err(Failure::internal)?;
    joined.map_err(|error: TileError| error.answered(|| "there is no such tile".to_owned()))
}

impl Surface {
    pub(super) fn zoom_of(self, tileset: &Tileset) -> u8 {
        let finest = tileset.metadata().max_zoom;
        self.zoom.unwrap_or(finest).min(finest)
    }
}

/// Far below every certified error, and half the bytes.
pub(super) fn to_millimetres(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}

pub(super) fn parse<'a, T: Deserialize<'a>>(body: &'a str) -> Result<T, Failure> {
    serde_json::from_str(body).map_err(|error| Failure::BadRequest(format!("the body: {error}")))
}
