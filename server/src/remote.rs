//! Archives that are elsewhere, read by ranges of bytes: `s3://`, `gs://`, `az://`, `http://` and `https://` addresses.
//!
//! ```text
//! range ─▶ blocks, each fetched once while there is room for it ─▶ bytes
//! ```
//! Blocks are of the object that was opened: once another one is in its place, nothing more is read of it. What fails for a moment is
//! tried again.

use std::fmt::Display;
use std::io;
use std::path::Path;
use std::sync::Arc;

use axum::body::Bytes;
use moka::sync::Cache;
use object_store::path::Path as Key;
use object_store::{Error, GetOptions, GetRange, ObjectMeta, ObjectStore, ObjectStoreExt};
use terrain_tiles::archive::ByteSource;
use tokio::runtime::Handle;
use url::Url;

/// Bytes that are fetched at once: most tiles are smaller.
const BLOCK: u64 = 128 << 10;
/// Bytes kept in memory of each archive.
const KEPT: u64 = 32 << 20;
/// Variables of the environment that say how to reach a bucket begin with one of these.
const SETTINGS: [&str; 3] = ["AWS_", "AZURE_", "GOOGLE_"];

/// Whether a source is an address, not a path of this machine.
pub(crate) fn is_address(source: &Path) -> bool {
    source.to_string_lossy().contains("://")
}

/// Where an object is, and the connections to there.
#[derive(Clone)]
pub(crate) struct Address {
    objects: Arc<dyn ObjectStore>,
    key: Key,
    runtime: Handle,
}

/// An object, as it was when it was looked at.
pub(crate) struct Remote {
    address: Address,
    meta: ObjectMeta,
    blocks: Cache<u64, Bytes>,
}

impl Address {
    /// On a thread of a runtime.
    ///
    /// # Errors
    /// Where the address means nothing.
    pub(crate) fn parse(source: &Path) -> io::Result<Self> {
        let url = Url::parse(&source.to_string_lossy()).map_err(invalid)?;
        let of_environment = std::env::vars()
            .filter(|(name, _)| SETTINGS.iter().any(|prefix| name.starts_with(prefix)))
            .map(|(name, value)| (name.to_lowercase(), value));
        let plain = (url.scheme() == "http").then(|| ("allow_http".to_owned(), "true".to_owned()));
        let (objects, key) = object_store::parse_url_opts(&url, of_environment.chain(plain)).map_err(invalid)?;
        Ok(Self {
            objects: objects.into(),
            key,
            runtime: Handle::try_current().map_err(invalid)?,
        })
    }

    /// Looks at what is there. Blocks: it is called on a thread where that is no harm.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where there is nothing; another kind where it cannot be reached.
    pub(crate) fn look(&self) -> io::Result<Remote> {
        let meta = self.runtime.block_on(self.objects.head(&self.key)).map_err(failed)?;
        Ok(Remote {
            address: self.clone(),
            meta,
            blocks: Cache::builder()
                .weigher(|_, block: &Bytes| block.len() as u32)
                .max_capacity(KEPT)
                .build(),
        })
    }
}

impl Remote {
    /// Changes when the object is replaced: its size, when it was written, and its entity tag.
    pub(crate) fn identity(&self) -> (u64, i64, Option<String>) {
        let ObjectMeta {
            size,
            last_modified,
            e_tag,
            ..
        } = &self.meta;
        (*size, last_modified.timestamp(), e_tag.clone())
    }

    fn block(&self, number: u64) -> io::Result<Bytes> {
        let fetch = || {
            let start = number * BLOCK;
            let options = GetOptions {
                range: Some(GetRange::Bounded(start..(start + BLOCK).min(self.meta.size))),
                if_match: self.meta.e_tag.clone().filter(|tag| !tag.starts_with("W/")),
                ..GetOptions::default()
            };
            let Address { objects, key, runtime } = &self.address;
            let get = async { objects.get_opts(key, options).await?.bytes().await };
            runtime.block_on(get).map_err(failed)
        };
        let found = self.blocks.try_get_with(number, fetch);
        found.map_err(|error: Arc<io::Error>| io::Error::new(error.kind(), error.to_string()))
    }
}

impl ByteSource for Remote {
    fn size(&self) -> io::Result<u64> {
        Ok(self.meta.size)
    }

    fn read(&self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
        let end = offset.saturating_add(length as u64).min(self.meta.size);
        let mut bytes = Vec::with_capacity(end.saturating_sub(offset) as usize);
        let mut at = offset;
        while at < end {
            let block = self.block(at / BLOCK)?;
            let first = (at % BLOCK) as usize;
            let count = (block.len().saturating_sub(first)).min((end - at) as usize);
            if count == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            bytes.extend_from_slice(&block[first..first + count]);
            at += count as u64;
        }
        Ok(bytes)
    }
}

fn invalid(error: impl Display) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, error.to_string())
}

fn failed(error: Error) -> io::Error {
    let kind = match error {
        Error::NotFound { .. } => io::ErrorKind::NotFound,
        _ => io::ErrorKind::Other,
    };
    io::Error::new(kind, error.to_string())
}
