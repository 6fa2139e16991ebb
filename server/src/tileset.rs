//! One generation of an archive, and its tiles in the forms that clients ask for.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::body::Bytes;
use axum::http::{HeaderMap, header};
use terrain_tiles::address::TileAddress;
use terrain_tiles::archive::{ArchiveError, Reader};
use terrain_tiles::formats::quantized_mesh::{self, Extensions, QuantizedMesh, addresses_around};
use terrain_tiles::formats::{LevelLimits, spt};
use terrain_tiles::layer_json::LayerJson;
use terrain_tiles::metadata::Metadata;
use terrain_tiles::outside::Outside;
use terrain_tiles::tile::Tile;

use crate::coding::Coding;
use crate::failure::Failure;

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
    /// `layer.json`.
    pub(crate) layer_json: Bytes,
    archive: Reader,
    /// Of what is drawn where nothing was measured.
    outside_checksum: u64,
}

/// In which form a tile is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Form {
    /// As it is in the archive.
    Progressive,
    /// For CesiumJS and others.
    QuantizedMesh { extensions: Extensions, coding: Coding },
}

/// Which tile is wanted, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TileRequest {
    pub(crate) address: TileAddress,
    pub(crate) form: Form,
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
    /// Opens the archive at `path`.
    pub(crate) fn open(path: &Path) -> Result<Self, ArchiveError> {
        let archive = Reader::open(path)?;
        let version = format!("{:032x}", archive.version());
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let document = serde_json::to_vec(&LayerJson::new(&name, &version, archive.metadata()));
        Ok(Self {
            name,
            version,
            generation: GENERATIONS.fetch_add(1, Ordering::Relaxed),
            layer_json: document
                .expect("strings, numbers and lists of them always become JSON")
                .into(),
            outside_checksum: checksum_of(&archive.metadata().outside),
            archive,
        })
    }

    /// What the archive says of itself.
    pub(crate) fn metadata(&self) -> &Metadata {
        self.archive.metadata()
    }

    /// Whether a place, in degrees, is within the bounds of the archive's data.
    pub(crate) fn covers(&self, longitude: f64, latitude: f64) -> bool {
        let [west, south, east, north] = self.metadata().bounds;
        // East exceeds 180° where data cross the antimeridian.
        let is_across = [longitude, longitude + 360.0].iter().any(|x| (west..=east).contains(x));
        is_across && (south..=north).contains(&latitude)
    }

    /// Whether a client that asks with `query` names this version: what it gets then never changes.
    pub(crate) fn is_named_in(&self, query: &str) -> bool {
        query
            .split('&')
            .any(|part| part.strip_prefix("v=") == Some(&self.version))
    }

    /// Whether there is a tile.
    pub(crate) fn has(&self, address: TileAddress) -> bool {
        self.archive.checksum(address).is_some()
    }

    /// Changes exactly when the tile's bytes in `form` do, but for their content coding; none where there is no tile.
    pub(crate) fn tag(&self, request: &TileRequest) -> Option<String> {
        let checksum = self.archive.checksum(request.address);
        match request.form {
            Form::Progressive => checksum.map(|checksum| format!("{checksum:016x}")),
            Form::QuantizedMesh { extensions, .. } => {
                let is_root = request.address.zoom == 0;
                let own = checksum.or(is_root.then_some(0))?;
                let checksum = self.checksum_with_surroundings(request.address, own);
                let Extensions {
                    normals,
                    measured_triangles,
                } = extensions;
                let flags = u8::from(normals) + 2 * u8::from(measured_triangles);
                // Another program may encode it otherwise.
                Some(format!(
                    "{checksum:016x}-{flags}-{}",
                    env!("CARGO_PKG_VERSION").replace('.', "-")
                ))
            }
        }
    }

    /// Of all that a tile for other clients is made of: the tile, those beside it, and what is outside.
    fn checksum_with_surroundings(&self, address: TileAddress, own: u64) -> u64 {
        let beside = addresses_around(address)
            .into_iter()
            .map(|address| self.archive.checksum(address));
        let mut hasher = DefaultHasher::new();
        (own, self.outside_checksum).hash(&mut hasher);
        beside.for_each(|checksum| checksum.hash(&mut hasher));
        hasher.finish()
    }

    /// The tile's bytes. Blocks while it reads and encodes.
    pub(crate) fn body(&self, request: &TileRequest) -> Result<Bytes, TileError> {
        match request.form {
            Form::Progressive => Ok(self.stored(request.address)?.ok_or(TileError::Missing)?.into()),
            Form::QuantizedMesh { extensions, coding } => {
                let bytes = quantized_mesh::encode(&self.quantized_mesh(request.address, extensions)?, extensions);
                coding.encode(bytes.into()).map_err(TileError::failure)
            }
        }
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

    /// The decoded tiles around one.
    fn tiles_around(&self, address: TileAddress) -> Result<Vec<Tile>, TileError> {
        let tiles = addresses_around(address).into_iter().map(|address| self.tile(address));
        tiles.filter_map(Result::transpose).collect()
    }

    fn stored(&self, address: TileAddress) -> Result<Option<Vec<u8>>, TileError> {
        self.archive
            .tile(address)
            .map_err(|error| TileError::Unreadable(error.to_string()))
    }

    /// Both roots always have one, since every client starts from both.
    fn quantized_mesh(&self, address: TileAddress, extensions: Extensions) -> Result<QuantizedMesh, TileError> {
        let outside = &self.metadata().outside;
        match self.tile(address)? {
            Some(tile) => {
                let beside = if extensions.normals {
                    self.tiles_around(address)?
                } else {
                    Vec::new()
                };
                Ok(QuantizedMesh::from_tile(&tile, &beside, outside))
            }
            None if address.zoom == 0 => Ok(QuantizedMesh::unmeasured(address, outside)),
            None => Err(TileError::Missing),
        }
    }
}

fn checksum_of(outside: &Outside) -> u64 {
    let document = serde_json::to_vec(outside).expect("numbers and lists of them always become JSON");
    let mut hasher = DefaultHasher::new();
    document.hash(&mut hasher);
    hasher.finish()
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

    fn failure(error: impl std::fmt::Display) -> Self {
        Self::Failure(Failure::internal(error))
    }
}

impl TileRequest {
    /// From the path's last three segments, the query and the headers.
    pub(crate) fn parse([z, x, file]: [&str; 3], query: &str, headers: &HeaderMap) -> Result<Self, Failure> {
        let (y, ending) = file.split_once('.').unwrap_or((file, ""));
        let form = match ending {
            "spt" => Form::Progressive,
            "terrain" => Form::QuantizedMesh {
                extensions: asked_extensions(query, headers),
                coding: Coding::accepted(headers),
            },
            _ => {
                return Err(Failure::BadRequest(format!(
                    "tiles end in .terrain or .spt, not in “{file}”"
                )));
            }
        };
        let numbers = whole_number(z)
            .and_then(|zoom| u8::try_from(zoom).ok())
            .zip(whole_number(x))
            .zip(whole_number(y));
        let address = numbers.and_then(|((zoom, x), y)| TileAddress::new(zoom, x, y)).ok_or_else(|| {
            Failure::BadRequest(format!(
                "{z}/{x}/{file} is no tile: zooms are 0 to 26, zoom z has columns 0 to 2^(z+1) − 1 and rows 0 to 2^z − 1"
            ))
        })?;
        Ok(Self { address, form })
    }

    pub(crate) fn coding(&self) -> Coding {
        match self.form {
            Form::Progressive => Coding::Identity,
            Form::QuantizedMesh { coding, .. } => coding,
        }
    }
}

/// A number of nothing but digits.
pub(crate) fn whole_number(text: &str) -> Option<u32> {
    let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|_| digits)
}

/// Clients ask for extensions in the query or in any part of their Accept header: `extensions=a-b`.
fn asked_extensions(query: &str, headers: &HeaderMap) -> Extensions {
    let accepted = headers
        .get_all(header::ACCEPT)
        .into_iter()
        .filter_map(|value| value.to_str().ok());
    let lists = accepted
        .chain([query])
        .flat_map(|text| text.split("extensions=").skip(1));
    let names = lists
        .filter_map(|rest| rest.split([',', ';', '&', ' ']).next())
        .flat_map(|list| list.split('-'));
    Extensions::named(names)
}
