//! An archive that is asked for heights.

use std::path::Path;
use std::sync::Arc;

use glam::DVec2;
use quick_cache::Weighter;
use quick_cache::sync::Cache;
use terrain_codec::address::TileAddress;
use terrain_codec::{DecodeError, LevelLimits, spt};
use terrain_tiles::archive::{ArchiveError, Reader};
use terrain_tiles::ground::{self, Ground, Point, answer, tile_at};

use crate::frame::Frame;

/// Surfaces are as large as this on average, bytes: the cache makes room for its own books by it.
const USUAL_BYTES: u64 = 500_000;

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum HeightsError {
    /// The archive cannot be read.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// A tile is damaged.
    #[error("tile {0}: {1}")]
    Tile(TileAddress, DecodeError),
}

/// What there is at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The surface, and how far the source may be from it there along the vertical, certified, metres.
    Measured(Point, f64),
    /// The surface where its source has a void, which was filled from its rim: no error is certified.
    Filled(Point),
    /// Within the archive's bounds, but its source has no samples there.
    Void,
    /// Out of the archive's bounds.
    Outside,
}

/// An open archive, with decoded surfaces of a bounded size. Whatever is asked first, and by however many threads, answers are the
/// same.
pub struct Heights {
    archive: Reader,
    grounds: Cache<TileAddress, Option<Arc<Ground>>, Bytes>,
}

#[derive(Clone)]
struct Bytes;

impl Weighter<TileAddress, Option<Arc<Ground>>> for Bytes {
    fn weight(&self, _: &TileAddress, ground: &Option<Arc<Ground>>) -> u64 {
        1 + ground.as_ref().map_or(0, |ground| ground.size() as u64)
    }
}

impl Heights {
    /// Opens the archive at `path`; decoded surfaces take `cache_bytes` at most, besides those that are being asked.
    ///
    /// # Errors
    /// Where the archive cannot be read.
    pub fn open(path: &Path, cache_bytes: u64) -> Result<Self, HeightsError> {
        let items = (cache_bytes / USUAL_BYTES).max(16) as usize;
        Ok(Self {
            archive: Reader::open(path)?,
            grounds: Cache::with_weighter(items, cache_bytes, Bytes),
        })
    }

    /// The archive's finest zoom.
    #[must_use]
    pub fn finest_zoom(&self) -> u8 {
        self.archive.metadata().max_zoom
    }

    /// What heights are above.
    #[must_use]
    pub fn above(&self) -> &str {
        self.archive.metadata().source.tiles_above()
    }

    /// What is at degrees of longitude and latitude, on the surface of `zoom`, or of the finest if that has no such zoom. Blocks
    /// while it reads and decodes a tile that nobody asked before, and allocates nothing otherwise.
    ///
    /// # Errors
    /// Where the tile cannot be read.
    pub fn at(&self, longitude: f64, latitude: f64, zoom: u8) -> Result<Place, HeightsError> {
        if !(longitude.is_finite() && (-90.0..=90.0).contains(&latitude)) {
            return Ok(Place::Outside);
        }
        let place = ground::Place::turned(longitude, latitude);
        let ground::Place { longitude, latitude } = place;
        let address = tile_at(zoom.min(self.finest_zoom()), longitude, latitude);
        let ask = |ground: &Ground| {
            let point = ground.point(longitude, latitude)?;
            Some(if ground.is_filled(longitude, latitude) {
                Place::Filled(point)
            } else {
                Place::Measured(point, ground.error())
            })
        };
        let found = answer(address, place, |address| self.ground(address), ask)?;
        Ok(match found {
            Some(place) => place,
            None => self.without_ground(longitude, latitude),
        })
    }

    /// What is at metres east and north in a local frame, on the surface of `zoom`, or of the finest: where the frame's vertical meets
    /// it, and where it does so more than once, the highest such point. The height is metres up in the frame, the error is along its
    /// up, and the normal is in its axes. The archive's heights are taken as above the ellipsoid.
    ///
    /// # Errors
    /// Where a tile cannot be read.
    pub fn in_frame(&self, frame: &Frame, east: f64, north: f64, zoom: u8) -> Result<Place, HeightsError> {
        let Some(line) = frame.upright(DVec2::new(east, north)) else {
            return Ok(Place::Outside);
        };
        let zoom = zoom.min(self.finest_zoom());
        let metadata = self.archive.metadata();
        // The surface is no further from the samples than its error.
        let [lowest, highest] = metadata.heights;
        let error = metadata.finest_error(zoom);
        let met = line.meet(zoom, [lowest - error, highest + error], |address| self.ground(address))?;
        let Some(met) = met else {
            return Ok(self.without_ground(line.place().x, line.place().y));
        };
        let point = Point {
            height: met.along,
            normal: frame.axes.transpose() * met.normal,
        };
        Ok(if met.is_filled {
            Place::Filled(point)
        } else {
            Place::Measured(point, met.error)
        })
    }

    fn without_ground(&self, longitude: f64, latitude: f64) -> Place {
        if self.archive.metadata().covers(longitude, latitude) {
            Place::Void
        } else {
            Place::Outside
        }
    }

    fn ground(&self, address: TileAddress) -> Result<Option<Arc<Ground>>, HeightsError> {
        self.grounds.get_or_insert_with(&address, || {
            let standing = self.archive.standing_for(address);
            let Some(bytes) = standing
                .map(|address| self.archive.tile(address))
                .transpose()?
                .flatten()
            else {
                return Ok(None);
            };
            let tile = spt::decode(&bytes, &LevelLimits::default());
            let tile = tile.map_err(|error| HeightsError::Tile(address, error))?;
            Ok(Some(Arc::new(Ground::of(&tile))))
        })
    }
}
