//! Encoded bodies, kept in memory: what is asked for again is neither read nor encoded again, and what several ask for at once is
//! made once.

use axum::body::Bytes;
use quick_cache::Weighter;
use quick_cache::sync::Cache;

use crate::coding::Coding;
use crate::failure::Failure;
use crate::form::{Form, MercatorRequest};
use crate::raster_dem::{GradientsRequest, RasterRequest};
use terrain_codec::address::TileAddress;

/// Which body.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Key {
    /// A tile of a generation of an archive.
    Tile(u64, TileAddress, Form),
    /// A raster tile of a generation of an archive.
    Raster(u64, RasterRequest),
    /// A quantized-mesh in Web Mercator, of a generation of an archive.
    Mercator(u64, MercatorRequest),
    /// Normals of a tile's square.
    Gradients(u64, GradientsRequest),
    /// A document by its tag, which tells its content.
    Document(String, Coding),
}

/// Bodies are as large as this on average, bytes: the cache makes room for its own books by it.
const USUAL_BYTES: u64 = 20_000;

/// Bodies by their keys; those long unused go when there are too many bytes.
pub(crate) struct Bodies(Cache<Key, Bytes, Length>);

#[derive(Clone)]
struct Length;

impl Weighter<Key, Bytes> for Length {
    fn weight(&self, _: &Key, body: &Bytes) -> u64 {
        1 + body.len() as u64
    }
}

impl Bodies {
    pub(crate) fn new(most_bytes: u64) -> Self {
        let usual = usize::try_from(most_bytes / USUAL_BYTES).unwrap_or(usize::MAX);
        Self(Cache::with_weighter(usual, most_bytes, Length))
    }

    /// The body at `key`, made by `make` on a thread where it may block, if it is not there.
    pub(crate) async fn get<E: From<Failure> + Send + 'static>(
        &self,
        key: Key,
        make: impl FnOnce() -> Result<Bytes, E> + Send + 'static,
    ) -> Result<Bytes, E> {
        let made = async {
            let joined = tokio::task::spawn_blocking(make).await;
            joined.map_err(Failure::internal).map_err(E::from)?
        };
        self.0.get_or_insert_async(&key, made).await
    }

    /// The body at `key`, if it is in memory.
    pub(crate) fn there(&self, key: &Key) -> Option<Bytes> {
        self.0.get(key)
    }

    /// A document in `coding`.
    pub(crate) async fn document(&self, tag: &str, body: Bytes, coding: Coding) -> Result<Bytes, Failure> {
        if coding == Coding::Identity {
            return Ok(body);
        }
        let make = move || coding.encode(body).map_err(Failure::internal);
        self.get(Key::Document(tag.to_owned(), coding), make).await
    }
}
