//! What a server is made of, and what its handlers share.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::bodies::Bodies;
use crate::catalogue::Catalogue;
use crate::failure::Failure;
use crate::heights::Heights;
use crate::metrics::Metrics;
use crate::models::ModelFile;
use crate::remembered::Remembered;
use crate::settings::{AccessLog, Settings};
use crate::tileset::Tileset;

/// All that the handlers share.
pub(crate) type Service = Arc<Shared>;

/// What a server is made of, besides its connections.
pub struct Shared {
    /// The archives.
    pub catalogue: Arc<Catalogue>,
    /// Models.
    pub models: Vec<ModelFile>,
    /// The figures.
    pub metrics: Metrics,
    pub(crate) bodies: Bodies,
    pub(crate) remembered: Remembered,
    pub(crate) has_access_log: bool,
    pub(crate) heights: Heights,
    pub(crate) token: Option<String>,
    pub(crate) base_path: String,
    pub(crate) public_url: Option<String>,
    is_stopping: AtomicBool,
}

impl Shared {
    /// A server of the archives of `catalogue`, and of models.
    #[must_use]
    pub fn new(catalogue: Catalogue, models: Vec<ModelFile>, settings: &Settings) -> Arc<Self> {
        Arc::new(Self {
            catalogue: Arc::new(catalogue),
            models,
            metrics: Metrics::default(),
            bodies: Bodies::new(settings.cache << 20),
            remembered: Remembered::default(),
            has_access_log: settings.access_log != AccessLog::Off,
            heights: Heights::default(),
            token: settings.token.clone(),
            base_path: settings.base_path.clone(),
            public_url: settings.public_url.clone(),
            is_stopping: AtomicBool::new(false),
        })
    }

    /// From now on the server says that it is not ready.
    pub fn is_about_to_stop(&self) {
        self.is_stopping.store(true, Ordering::Relaxed);
    }

    /// Looks at the archives again, on a thread where that may block.
    pub async fn look_again(&self) {
        let catalogue = Arc::clone(&self.catalogue);
        if let Err(error) = tokio::task::spawn_blocking(move || catalogue.refresh()).await {
            tracing::error!("the archives could not be looked at: {error}");
        }
    }

    pub(crate) fn is_stopping(&self) -> bool {
        self.is_stopping.load(Ordering::Relaxed)
    }

    pub(crate) fn find(&self, name: &str) -> Result<Arc<Tileset>, Failure> {
        self.catalogue
            .find(name)
            .ok_or_else(|| Failure::NotFound(format!("there is no tileset “{name}”; /tilesets lists those there are")))
    }
}
