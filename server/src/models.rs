//! Models under their names: files of curved levels (`.clod`) and progressive meshes (`.spm`), as they are.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::Context;
use axum::body::Bytes;
use terrain_codec::LevelLimits;
use terrain_codec::clod::{self, CurvedLimits};
use terrain_codec::spm;
use twox_hash::XxHash3_128;

/// What a model's file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ModelKind {
    /// Curved levels of detail.
    Curved,
    /// A mesh with its levels of detail.
    Progressive,
}

impl ModelKind {
    /// By a file's name; none if that is another's.
    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "clod" => Some(Self::Curved),
            "spm" => Some(Self::Progressive),
            _ => None,
        }
    }

    /// The page that shows it.
    #[must_use]
    pub fn page(self) -> &'static str {
        match self {
            Self::Curved => "curved.html",
            Self::Progressive => "model.html",
        }
    }

    fn check(self, bytes: &[u8]) -> anyhow::Result<()> {
        match self {
            Self::Curved => clod::decode(bytes, &CurvedLimits::default()).map(drop)?,
            Self::Progressive => spm::decode(bytes, &LevelLimits::default()).map(drop)?,
        }
        Ok(())
    }
}

/// A model's file and what it is called.
pub struct ModelFile {
    /// The file's name without its ending.
    pub name: String,
    /// What it is.
    pub kind: ModelKind,
    /// Of its bytes.
    pub(crate) tag: String,
    pub(crate) bytes: Bytes,
}

impl ModelFile {
    /// Whether a file is one, by its name.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        ModelKind::of(path).is_some()
    }

    /// The name of two models of one kind, which are at one address; those of two kinds are not.
    #[must_use]
    pub fn twin(models: &[Self]) -> Option<&str> {
        let mut known = BTreeSet::new();
        let twin = models.iter().find(|model| !known.insert((model.kind, &model.name)));
        twin.map(|model| model.name.as_str())
    }

    /// Reads the file at `path` and looks it through.
    ///
    /// # Errors
    /// What is wrong with the file, and which.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let named = || path.display().to_string();
        let kind = ModelKind::of(path)
            .context("neither a .clod nor a .spm file")
            .with_context(named)?;
        let bytes = fs::read(path).with_context(named)?;
        kind.check(&bytes).with_context(named)?;
        Ok(Self {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            kind,
            tag: format!("{:032x}", XxHash3_128::oneshot(&bytes)),
            bytes: bytes.into(),
        })
    }
}
