//! Heights at places, from the surfaces of archives, and what is known of each.
//!
//! ```text
//! places ─▶ surfaces of the tiles that they are in, each decoded once ─▶ height, error, status
//! ```

use std::sync::Arc;

use moka::sync::Cache;
use serde::Serialize;
use terrain_codec::address::TileAddress;
pub(crate) use terrain_tiles::ground::Place;
use terrain_tiles::ground::{Ground, answers};
use utoipa::ToSchema;

use crate::tileset::{TileError, Tileset};

/// Decoded surfaces kept in memory, bytes.
const GROUND_BYTES: u64 = 256 << 20;

/// Whether there is ground at a place; what is known best comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Status {
    /// The surface has a height there.
    Measured,
    /// It has one, but its source has a void there, which was filled from its rim: no error is certified.
    Filled,
    /// Within the archive's bounds, but its source has no samples there.
    Void,
    /// Out of the archive's bounds.
    Outside,
}

/// What is known of the ground at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Height {
    pub(crate) status: Status,
    /// Where there is ground.
    metres: f64,
    /// How far the source may be from it, certified, where it is measured.
    error: f64,
}

/// Surfaces of tiles, ready to be asked.
#[derive(Clone)]
pub(crate) struct Heights(Cache<(u64, TileAddress), Option<Arc<Ground>>>);

impl Default for Heights {
    fn default() -> Self {
        let weight = |_: &(u64, TileAddress), ground: &Option<Arc<Ground>>| {
            let bytes = ground.as_ref().map_or(0, |ground| ground.size());
            u32::try_from(bytes).unwrap_or(u32::MAX)
        };
        Self(Cache::builder().weigher(weight).max_capacity(GROUND_BYTES).build())
    }
}

impl Heights {
    /// The surface of the tile that stands for the square at `address`, if there is one. Blocks while it reads and decodes.
    pub(crate) fn ground(&self, tileset: &Tileset, address: TileAddress) -> Result<Option<Arc<Ground>>, TileError> {
        let key = (tileset.generation, address);
        let make = || {
            let standing = tileset.standing_for(address);
            let tile = standing.map(|address| tileset.tile(address)).transpose()?.flatten();
            Ok(tile.map(|tile| Arc::new(Ground::of(&tile))))
        };
        self.0
            .try_get_with(key, make)
            .map_err(|error: Arc<TileError>| (*error).clone())
    }

    /// Heights at `places` on the surface of `zoom`, in their order. Blocks while it reads and decodes tiles.
    pub(crate) fn at(&self, tileset: &Tileset, zoom: u8, places: &[Place]) -> Result<Vec<Height>, TileError> {
        let ask = |ground: &Ground, place: Place| {
            let metres = ground.height(place.longitude, place.latitude)?;
            let is_filled = ground.is_filled(place.longitude, place.latitude);
            Some(Height {
                status: if is_filled { Status::Filled } else { Status::Measured },
                metres,
                error: ground.error(),
            })
        };
        let found = answers(zoom, places, |address| self.ground(tileset, address), ask)?;
        let or_none = |(height, place): (Option<Height>, &Place)| {
            height.unwrap_or_else(|| Height::none(tileset.metadata().covers(place.longitude, place.latitude)))
        };
        Ok(found.into_iter().zip(places).map(or_none).collect())
    }
}

impl Height {
    fn none(is_covered: bool) -> Self {
        Self {
            status: if is_covered { Status::Void } else { Status::Outside },
            metres: 0.0,
            error: 0.0,
        }
    }

    /// Metres, where there is ground.
    pub(crate) fn metres(&self) -> Option<f64> {
        matches!(self.status, Status::Measured | Status::Filled).then_some(self.metres)
    }

    /// By how many metres the source may be higher or lower, certified, where it is measured.
    pub(crate) fn error(&self) -> Option<f64> {
        (self.status == Status::Measured).then_some(self.error)
    }
}
