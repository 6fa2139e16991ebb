//! Encoded bodies, kept in memory: what is asked for again is neither read nor encoded again, and what several ask for at once is
//! made once.

use std::sync::Arc;

use axum::body::Bytes;
use moka::future::Cache;

use crate::coding::Coding;
use crate::failure::Failure;
use crate::form::Form;
use crate::raster_dem::RasterRequest;
use terrain_tiles::address::TileAddress;
use terrain_tiles::raster_dem::image::Format;

/// Which body.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Key {
    /// A tile of a generation of an archive.
    Tile(u64, TileAddress, Form),
    /// A raster tile of a generation of an archive.
    Raster(u64, RasterRequest),
    /// Normals of a tile's square.
    Gradients(u64, TileAddress, Format),
    /// A document by its tag, which tells its content.
    Document(String, Coding),
}

/// Bodies by their keys; those long unused go when there are too many bytes.
#[derive(Clone)]
pub(crate) struct Bodies(Cache<Key, Bytes>);

impl Bodies {
    pub(crate) fn new(most_bytes: u64) -> Self {
        let weight = |_: &Key, body: &Bytes| body.len().try_into().unwrap_or(u32::MAX);
        Self(Cache::builder().weigher(weight).max_capacity(most_bytes).build())
    }

    /// The body at `key`, made by `make` on a thread where it may block, if it is not there.
    pub(crate) async fn get<E: From<Failure> + Clone + Send + Sync + 'static>(
        &self,
        key: Key,
        make: impl FnOnce() -> Result<Bytes, E> + Send + 'static,
    ) -> Result<Bytes, E> {
        if let Some(body) = self.0.get(&key).await {
            return Ok(body);
        }
        let made = async {
            let joined = tokio::task::spawn_blocking(make).await;
            joined.map_err(Failure::internal).map_err(E::from)?
        };
        self.0
            .try_get_with(key, made)
            .await
            .map_err(|error: Arc<E>| (*error).clone())
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
