//! One archive under one name, and its tiles in the forms that clients ask for.

use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::time::UNIX_EPOCH;

use axum::body::Bytes;
use axum::http::{HeaderMap, header};
use flate2::Compression;
use flate2::write::GzEncoder;
use moka::sync::Cache;
use terrain_tiles::address::TileAddress;
use terrain_tiles::archive::{ArchiveError, Reader};
use terrain_tiles::formats::quantized_mesh::{self, Extensions, QuantizedMesh};
use terrain_tiles::formats::{LevelLimits, spt};
use terrain_tiles::layer_json::LayerJson;
use terrain_tiles::metadata::Metadata;

use crate::answer::{Failure, accepts_gzip};

/// How much of each archive's encoded tiles is kept in memory, in bytes: some 10,000 tiles.
const CACHE_BYTES: u64 = 256 << 20;

/// An open archive and what it is called.
pub struct Tileset {
    /// The archive's file name without its ending.
    pub name: String,
    /// Changes whenever the file does: from its length and its time of change.
    pub version: String,
    archive: Reader,
    encoded: Cache<TileRequest, Bytes>,
}

/// In which form a tile is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Form {
    /// As it is in the archive.
    Progressive,
    /// For CesiumJS and others.
    QuantizedMesh { extensions: Extensions, gzip: bool },
}

/// Which tile is wanted, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TileRequest {
    pub(crate) address: TileAddress,
    pub(crate) form: Form,
}

impl Tileset {
    /// Opens the archive at `path`.
    ///
    /// # Errors
    /// One line that says what is wrong with the file.
    pub fn open(path: &Path) -> Result<Self, ArchiveError> {
        let archive = Reader::open(path)?;
        let version = version(path).map_err(|error| ArchiveError::Io(path.into(), error))?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let weight = |_: &TileRequest, bytes: &Bytes| bytes.len().try_into().unwrap_or(u32::MAX);
        let encoded = Cache::builder().weigher(weight).max_capacity(CACHE_BYTES).build();
        Ok(Self {
            name,
            version,
            archive,
            encoded,
        })
    }

    /// What the archive says of itself.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        self.archive.metadata()
    }

    pub(crate) fn layer_json(&self) -> serde_json::Value {
        serde_json::to_value(LayerJson::new(&self.name, &self.version, self.metadata()))
            .expect("strings, numbers and lists of them always become JSON")
    }

    /// The tile's bytes. Blocks while it reads and encodes.
    pub(crate) fn tile(&self, request: &TileRequest) -> Result<Bytes, Failure> {
        match request.form {
            Form::Progressive => self
                .stored(request.address)?
                .map(Bytes::from)
                .ok_or_else(|| self.no_tile(request.address)),
            Form::QuantizedMesh { extensions, gzip } => {
                if let Some(bytes) = self.encoded.get(request) {
                    return Ok(bytes);
                }
                let bytes = quantized_mesh::encode(&self.quantized_mesh(request.address)?, extensions);
                let bytes = Bytes::from(if gzip {
                    compress(&bytes).map_err(Failure::internal)?
                } else {
                    bytes
                });
                self.encoded.insert(*request, bytes.clone());
                Ok(bytes)
            }
        }
    }

    fn stored(&self, address: TileAddress) -> Result<Option<Vec<u8>>, Failure> {
        self.archive.tile(address).map_err(Failure::internal)
    }

    /// Both roots always have one, since every client starts from both.
    fn quantized_mesh(&self, address: TileAddress) -> Result<QuantizedMesh, Failure> {
        match self.stored(address)? {
            Some(bytes) => {
                let tile = spt::decode(&bytes, &LevelLimits::default())
                    .map_err(|error| Failure::internal(format!("tile {address} of “{}”: {error}", self.name)))?;
                Ok(QuantizedMesh::from_tile(&tile))
            }
            None if address.zoom == 0 => Ok(QuantizedMesh::ellipsoid(address)),
            None => Err(self.no_tile(address)),
        }
    }

    fn no_tile(&self, address: TileAddress) -> Failure {
        Failure::NotFound(format!("tileset “{}” has no tile {address}", self.name))
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
                gzip: accepts_gzip(headers),
            },
            _ => {
                return Err(Failure::BadRequest(format!(
                    "tiles end in .terrain or .spt, not in “{file}”"
                )));
            }
        };
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            text.parse::<u32>().ok().filter(|_| digits)
        };
        let numbers = number(z)
            .and_then(|zoom| u8::try_from(zoom).ok())
            .zip(number(x))
            .zip(number(y));
        let address = numbers.and_then(|((zoom, x), y)| TileAddress::new(zoom, x, y)).ok_or_else(|| {
            Failure::BadRequest(format!(
                "{z}/{x}/{file} is no tile: zooms are 0 to 26, zoom z has columns 0 to 2^(z+1) − 1 and rows 0 to 2^z − 1"
            ))
        })?;
        Ok(Self { address, form })
    }
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

fn compress(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

fn version(path: &Path) -> io::Result<String> {
    let file = fs::metadata(path)?;
    let changed = file.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
    Ok(format!("{:x}-{:x}", file.len(), changed.as_nanos()))
}
