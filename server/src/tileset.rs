//! One generation of an archive, and its tiles.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::body::Bytes;
use terrain_codec::address::{Rectangle, TileAddress};
use terrain_codec::tile::Tile;
use terrain_codec::{LevelLimits, spt};
use terrain_tiles::archive::{ArchiveError, Reader};
use terrain_tiles::formats::quantized_mesh::{Extensions, QuantizedMesh, addresses_for, addresses_under};
use terrain_tiles::layer_json::{LayerForm, LayerJson};
use terrain_tiles::metadata::Metadata;
use terrain_tiles::shading::{FinestSurface, Shading};
use terrain_tiles::tile_file::SquareTile;

use crate::failure::Failure;
use crate::remote::Remote;

/// How many archives this process has opened.
static GENERATIONS: AtomicU64 = AtomicU64::new(0);

/// An open archive and what it is called.
pub(crate) struct Tileset {
    /// The archive's file name without its ending.
    pub(crate) name: String,
    /// Of its content: two archives of one version hold the same.
    pub(crate) version: String,
    /// Number of this open archive among all that were opened.
    pub(crate) generation: u64,
    /// `layer.json` in its usual form.
    layer_json: Bytes,
    archive: Reader,
    /// Of all archives.
    shading: Arc<Shading>,
    /// Of what is drawn where nothing was measured, and of where there is water.
    surroundings_checksum: u64,
}

/// Why a tile cannot be had.
#[derive(Clone, Debug)]
pub(crate) enum TileError {
    /// There is none.
    Missing,
    /// The archive cannot be read there, or has other bytes than were written.
    Unreadable(String),
    /// Something else.
    Failure(Failure),
}

impl Tileset {
    /// Opens the archive at a path, or the one that was found at an address.
    pub(crate) fn open(path: &Path, remote: Option<Remote>, shading: Arc<Shading>) -> Result<Self, ArchiveError> {
        let archive = match remote {
            Some(remote) => Reader::over(path, Box::new(remote))?,
            None => Reader::open(path)?,
        };
        let version = format!("{:032x}", archive.version());
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self {
            layer_json: layer_json(&name, &version, archive.metadata(), &LayerForm::default()),
            name,
            version,
            generation: GENERATIONS.fetch_add(1, Ordering::Relaxed),
            surroundings_checksum: checksum_of(archive.metadata()),
            archive,
            shading,
        })
    }

    /// What the archive says of itself.
    pub(crate) fn metadata(&self) -> &Metadata {
        self.archive.metadata()
    }

    /// `layer.json`.
    pub(crate) fn layer_json(&self, form: &LayerForm) -> Bytes {
        if *form == LayerForm::default() {
            return self.layer_json.clone();
        }
        layer_json(&self.name, &self.version, self.metadata(), form)
    }

    /// Whether a client that asks with `query` names this version: what it gets then never changes.
    pub(crate) fn is_named_in(&self, query: &str) -> bool {
        query
            .split('&')
            .any(|part| part.strip_prefix("v=") == Some(&self.version))
    }

    /// What the bytes of a tile hash to, if there is one.
    pub(crate) fn checksum(&self, address: TileAddress) -> Option<u64> {
        self.archive.checksum(address)
    }

    /// Of all that a tile without normals is made of for other clients, if there is one: the tile, those beside it, what is outside, and
    /// water.
    pub(crate) fn checksum_with_surroundings(&self, address: TileAddress) -> Option<u64> {
        self.is_drawn(address).then(|| {
            let own = (self.checksum(address), self.surroundings_checksum);
            self.checksum_of_all(own, address.around())
        })
    }

    /// The same of a tile of Web Mercator.
    pub(crate) fn checksum_in_mercator(&self, tile: SquareTile) -> Option<u64> {
        self.is_drawn_in_mercator(tile)
            .then(|| self.checksum_of_all(self.surroundings_checksum, self.standing_for_all(addresses_for(tile))))
    }

    /// Whether a square has a tile for other clients: where there is a tile, or ground beside tiles.
    pub(crate) fn is_drawn(&self, address: TileAddress) -> bool {
        self.checksum(address).is_some() || self.has_ground(address)
    }

    /// Whether a square of Web Mercator has one: it reaches into one of those.
    pub(crate) fn is_drawn_in_mercator(&self, tile: SquareTile) -> bool {
        addresses_under(tile).into_iter().any(|address| self.is_drawn(address))
    }

    fn checksum_of_all(&self, of_others: impl Hash, addresses: impl IntoIterator<Item = TileAddress>) -> u64 {
        let mut hasher = DefaultHasher::new();
        of_others.hash(&mut hasher);
        let checksums = addresses.into_iter().map(|address| self.archive.checksum(address));
        checksums.for_each(|checksum| checksum.hash(&mut hasher));
        hasher.finish()
    }

    /// The tiles that stand for squares.
    fn standing_for_all(&self, addresses: Vec<TileAddress>) -> BTreeSet<TileAddress> {
        addresses
            .into_iter()
            .filter_map(|address| self.standing_for(address))
            .collect()
    }

    /// The tile that stands for a square, the one there or the leaf above, if there is one.
    pub(crate) fn standing_for(&self, address: TileAddress) -> Option<TileAddress> {
        self.archive.standing_for(address)
    }

    /// The decoded tile, if there is one. Blocks while it reads and decodes.
    pub(crate) fn tile(&self, address: TileAddress) -> Result<Option<Tile>, TileError> {
        let Some(bytes) = self.stored(address)? else {
            return Ok(None);
        };
        spt::decode(&bytes, &LevelLimits::default())
            .map(Some)
            .map_err(|error| TileError::failure(format!("tile {address} of “{}”: {error}", self.name)))
    }

    /// The finest surface of a tile, if there is one, shaded or without normals. Blocks while it reads and decodes.
    pub(crate) fn surface(
        &self,
        address: TileAddress,
        is_shaded: bool,
    ) -> Result<Option<Arc<FinestSurface>>, TileError> {
        if is_shaded {
            return self
                .shading
                .surface(self.generation, address, &|address| self.tile(address));
        }
        let unshaded = |tile| Arc::new(FinestSurface::unshaded(tile));
        Ok(self.tile(address)?.map(unshaded))
    }

    pub(crate) fn stored(&self, address: TileAddress) -> Result<Option<Vec<u8>>, TileError> {
        self.archive
            .tile(address)
            .map_err(|error| TileError::Unreadable(error.to_string()))
    }

    /// Whether there is something to draw although nothing is measured: at the roots, since every client starts from both, and beside
    /// tiles.
    pub(crate) fn has_ground(&self, address: TileAddress) -> bool {
        let is_there = |address| self.checksum(address).is_some();
        let is_beside = || address.around().into_iter().any(is_there);
        address.zoom == 0 || (self.standing_for(address).is_none() && is_beside())
    }

    /// A tile of the geographic scheme. Blocks while it reads and decodes.
    pub(crate) fn quantized_mesh(
        &self,
        address: TileAddress,
        extensions: Extensions,
    ) -> Result<QuantizedMesh, TileError> {
        let outside = &self.metadata().outside;
        let surface = |address| self.surface(address, extensions.normals);
        let mut mesh = match surface(address)? {
            Some(own) => QuantizedMesh::from_tile(&own, surface, outside)?,
            None if self.has_ground(address) => QuantizedMesh::unmeasured(address, surface, outside)?,
            None => return Err(TileError::Missing),
        };
        mesh.normals = mesh.normals.filter(|_| extensions.normals);
        mesh.water_mask = self.water_mask(extensions, address);
        Ok(mesh)
    }

    /// Where there is water in a tile, if it is asked for and known.
    fn water_mask(&self, extensions: Extensions, tile: impl Into<Rectangle>) -> Option<Vec<u8>> {
        let water = &self.metadata().water;
        (extensions.water_mask && !water.is_empty()).then(|| water.mask(tile))
    }

    /// A tile of Web Mercator. Blocks while it reads and decodes.
    pub(crate) fn quantized_mesh_in_mercator(
        &self,
        tile: SquareTile,
        extensions: Extensions,
    ) -> Result<QuantizedMesh, TileError> {
        let standing = |address| {
            let standing = self.standing_for(address);
            standing.map_or(Ok(None), |address| self.surface(address, extensions.normals))
        };
        let mut mesh = QuantizedMesh::in_mercator(tile, standing, &self.metadata().outside)?;
        mesh.normals = mesh.normals.filter(|_| extensions.normals);
        mesh.water_mask = self.water_mask(extensions, tile);
        Ok(mesh)
    }
}

fn layer_json(name: &str, version: &str, metadata: &Metadata, form: &LayerForm) -> Bytes {
    serde_json::to_vec(&LayerJson::new(name, version, metadata, form))
        .expect("strings, numbers and lists of them always become JSON")
        .into()
}

/// Of what is where nothing was measured, and of where there is water.
fn checksum_of(metadata: &Metadata) -> u64 {
    let parts = (&metadata.outside, &metadata.water);
    let document = serde_json::to_vec(&parts).expect("numbers and lists of them always become JSON");
    let mut hasher = DefaultHasher::new();
    document.hash(&mut hasher);
    hasher.finish()
}

impl From<io::Error> for TileError {
    fn from(error: io::Error) -> Self {
        Self::failure(error)
    }
}

impl From<Failure> for TileError {
    fn from(failure: Failure) -> Self {
        Self::Failure(failure)
    }
}

impl TileError {
    /// What is answered; `missing` says what there is not.
    pub(crate) fn answered(self, missing: impl FnOnce() -> String) -> Failure {
        match self {
            Self::Missing => Failure::NotFound(missing()),
            Self::Unreadable(reason) => Failure::internal(reason),
            Self::Failure(failure) => failure,
        }
    }

    pub(crate) fn failure(error: impl std::fmt::Display) -> Self {
        Self::Failure(Failure::internal(error))
    }
}
