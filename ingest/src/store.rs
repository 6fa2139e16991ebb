//! Where jobs keep their outputs: named bytes in a folder or a bucket. What is at a name is whole, or not there; a name is made
//! from a hash of all inputs, so that what is there need not be made again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use object_store::local::LocalFileSystem;
use object_store::path::Path as Key;
use object_store::{Error, ObjectStore, ObjectStoreExt, PutPayload, prefix::PrefixStore};
use tokio::runtime::Runtime;
use twox_hash::XxHash3_128;
use url::Url;

/// Variables of the environment that say how to reach a bucket begin with one of these.
const SETTINGS: [&str; 3] = ["AWS_", "AZURE_", "GOOGLE_"];

/// A hash of 128 bits; what it names has such inputs or such a content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Name(pub(crate) u128);

impl Name {
    /// The name of what is made from such parts, in this order.
    pub(crate) fn of<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut hasher = XxHash3_128::new();
        for part in parts {
            hasher.write(&(part.len() as u64).to_le_bytes());
            hasher.write(part);
        }
        Self(hasher.finish_128())
    }

    /// The name of which this is the text.
    pub(crate) fn parse(text: &str) -> Result<Self> {
        Ok(Self(u128::from_str_radix(text, 16)?))
    }

    pub(crate) fn bytes(self) -> [u8; 16] {
        self.0.to_be_bytes()
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

/// A folder or a bucket.
#[derive(Clone)]
pub struct Store {
    objects: Arc<dyn ObjectStore>,
    runtime: Arc<Runtime>,
    location: String,
    /// Where it is a folder of this machine.
    folder: Option<PathBuf>,
}

impl Store {
    /// The store at a folder, which is made where it is missing, or at an address: `s3://bucket/path`, `gs://…`, `az://…`. How to
    /// reach a bucket is taken from the environment, as each cloud's own tools do.
    ///
    /// # Errors
    /// When the folder cannot be made, or the address means nothing.
    pub fn open(location: &str) -> Result<Self> {
        let runtime = Arc::new(
            tokio::runtime::Builder::new_multi_thread()
                .worker_threads(2)
                .enable_all()
                .build()?,
        );
        if !location.contains("://") {
            return Self::in_folder(Path::new(location), runtime);
        }
        let url = Url::parse(location).with_context(|| format!("{location}: is no address"))?;
        if url.scheme() == "file" {
            let Ok(folder) = url.to_file_path() else {
                bail!("{location}: is no folder of this machine");
            };
            return Self::in_folder(&folder, runtime);
        }
        let settings = std::env::vars()
            .filter(|(name, _)| SETTINGS.iter().any(|prefix| name.starts_with(prefix)))
            .map(|(name, value)| (name.to_lowercase(), value));
        let (bucket, path) = object_store::parse_url_opts(&url, settings).with_context(|| location.to_owned())?;
        Ok(Self {
            objects: Arc::new(PrefixStore::new(bucket, path)),
            runtime,
            location: location.to_owned(),
            folder: None,
        })
    }

    /// The store at a folder, if there is such a folder, or at an address.
    ///
    /// # Errors
    /// When the folder cannot be used, or the address means nothing.
    pub fn find(location: &str) -> Result<Option<Self>> {
        let is_there = location.contains("://") || Path::new(location).is_dir();
        is_there.then(|| Self::open(location)).transpose()
    }

    fn in_folder(folder: &Path, runtime: Arc<Runtime>) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        let objects = LocalFileSystem::new_with_prefix(folder).with_context(|| folder.display().to_string())?;
        Ok(Self {
            objects: Arc::new(objects),
            runtime,
            location: folder.display().to_string(),
            folder: Some(folder.to_owned()),
        })
    }

    /// As it was given.
    #[must_use]
    pub fn location(&self) -> &str {
        &self.location
    }

    /// The folder of this machine that it is, if it is one.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// The bytes at a name, if there are any.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn get(&self, key: &str) -> Result<Option<Vec<u8>>> {
        let read = async { self.objects.get(&Key::from(key)).await?.bytes().await };
        match self.runtime.block_on(read) {
            Ok(bytes) => Ok(Some(bytes.into())),
            Err(Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(self.failed(key, error)),
        }
    }

    /// The bytes at a name that some job has put there.
    ///
    /// # Errors
    /// When they are not there, or the store cannot be read.
    pub(crate) fn expect(&self, key: &str) -> Result<Vec<u8>> {
        let bytes = self.get(key)?;
        bytes.with_context(|| format!("{}: {key} is missing", self.location))
    }

    /// Whether there are bytes at a name.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn has(&self, key: &str) -> Result<bool> {
        match self.runtime.block_on(self.objects.head(&Key::from(key))) {
            Ok(_) => Ok(true),
            Err(Error::NotFound { .. }) => Ok(false),
            Err(error) => Err(self.failed(key, error)),
        }
    }

    /// Puts bytes at a name, all at once.
    ///
    /// # Errors
    /// When the store cannot be written, as when the disk is full.
    pub(crate) fn put(&self, key: &str, bytes: Vec<u8>) -> Result<()> {
        let (key_there, payload) = (Key::from(key), PutPayload::from(bytes));
        match self.runtime.block_on(self.objects.put(&key_there, payload)) {
            Ok(_) => Ok(()),
            Err(error) => Err(self.failed(key, error)),
        }
    }

    /// One line, the system's own word last.
    fn failed(&self, key: &str, error: Error) -> anyhow::Error {
        let error = anyhow::Error::new(error);
        let cause = error.root_cause().to_string();
        anyhow::anyhow!("{}/{key}: {cause}", self.location)
    }
}
