//! The archive: one PMTiles v3 file of `.spt` tiles, with a [`Metadata`] block in JSON. Layout: PMTiles specification
//! version 3, Protomaps 2022; tile type 0 (unknown), tiles stored as they are, directories and metadata gzipped.
//!
//! PMTiles ids are those of one square cut in four at each zoom, rows from the north; the geographic scheme has two
//! squares at zoom 0, rows from the south. So a tile goes where the northern half of that square has it, one zoom on:
//!
//! ```text
//! geographic zoom 0          PMTiles zoom 1
//! ┌───────┬───────┐          ┌───────┬───────┐
//! │ 0/0/0 │ 0/1/0 │    ▶     │ 1/0/0 │ 1/1/0 │       z′ = z + 1
//! └───────┴───────┘          ├───────┼───────┤       x′ = x
//!                            │ never │ used  │       y′ = 2^z − 1 − y
//!                            └───────┴───────┘
//! ```
//!
//! A tile's parent and children are then its parent and children in PMTiles, too.
//!
//! The JSON block has a checksum of every tile, so that no damaged or overwritten byte passes for a tile.

use std::fs::{self, File};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use futures_util::TryStreamExt;
use pmtiles::{
    AsyncBackend, AsyncPmTilesReader, BackendResponse, Compression, DirEntry, HashMapCache, Header, PmtError,
    PmtResult, TileCoord, TileId, TileType,
};
use serde::{Deserialize, Serialize};
use terrain_codec::address::{self, MAX_ZOOM, TileAddress};
use thiserror::Error;
use twox_hash::{XxHash3_64, XxHash3_128};

use crate::metadata::{FORMAT, Metadata, VERSION};
use crate::new_file::NewFile;
use crate::tile_file::{self, Kind, SquareTile, TileFile};

/// Largest tile that is written or read, in bytes: what the length field of the tile format can say is more, but no
/// sound tile comes near this.
pub const MAX_TILE_BYTES: usize = 1 << 28;

/// Why an archive cannot be written or read. Each says it in one line that begins with the file's path.
#[derive(Debug, Error)]
pub enum ArchiveError {
    /// The operating system refused.
    #[error("{0}: {1}")]
    Io(PathBuf, io::Error),
    /// The file is no sound PMTiles archive.
    #[error("{0}: not a readable PMTiles archive: {1}")]
    Unreadable(PathBuf, String),
    /// The file is a PMTiles archive, but none of ours.
    #[error("{0}: a PMTiles archive, but not of {FORMAT} version {VERSION}: {1}")]
    Foreign(PathBuf, String),
    /// The bytes of a tile are not those that were written.
    #[error("{0}: tile {1} is damaged, or the file was overwritten")]
    Damaged(PathBuf, TileAddress),
    /// The caller added what cannot be stored.
    #[error("{0}: tile {1} {2}")]
    BadTile(PathBuf, TileAddress, &'static str),
}

/// Writes an archive. Nothing is seen at the final path before [`Writer::finish`]; a writer that is dropped leaves
/// nothing behind. Tiles may be added in any order, and the bytes depend on the tiles and the metadata alone.
pub struct Writer {
    path: PathBuf,
    file: TileFile,
    tiles: Vec<Added>,
}

/// What is kept of a tile that was added.
struct Added {
    id: u64,
    address: TileAddress,
    checksum: u64,
}

impl Writer {
    /// Starts an archive that will be at `path`, in a folder that exists and can be written to.
    ///
    /// # Errors
    /// [`ArchiveError::Io`] when no file can be made in the folder.
    pub fn create(path: &Path) -> Result<Self, ArchiveError> {
        let file = TileFile::create_in(folder_of(path)).map_err(|error| ArchiveError::Io(path.into(), error))?;
        Ok(Self {
            path: path.into(),
            file,
            tiles: Vec::new(),
        })
    }

    /// Adds the bytes of the tile at `address`.
    ///
    /// # Errors
    /// [`ArchiveError::BadTile`] when `bytes` are none or too many, [`ArchiveError::Io`] when the disk is full.
    pub fn add(&mut self, address: TileAddress, bytes: &[u8]) -> Result<(), ArchiveError> {
        if bytes.is_empty() || bytes.len() > MAX_TILE_BYTES {
            return Err(ArchiveError::BadTile(
                self.path.clone(),
                address,
                "is empty or larger than 256 MiB",
            ));
        }
        self.file
            .add(square_tile(address), bytes)
            .map_err(|error| ArchiveError::Io(self.path.clone(), error))?;
        self.tiles.push(Added {
            id: tile_id(address),
            address,
            checksum: checksum(bytes),
        });
        Ok(())
    }

    /// Writes the archive and moves it to its path, over any file that is there.
    ///
    /// # Errors
    /// [`ArchiveError::BadTile`] when an address was added twice, [`ArchiveError::Io`] otherwise.
    pub fn finish(mut self, metadata: &Metadata) -> Result<(), ArchiveError> {
        self.tiles.sort_by_key(|tile| tile.id);
        if let Some(pair) = self.tiles.windows(2).find(|pair| pair[0].id == pair[1].id) {
            return Err(ArchiveError::BadTile(self.path, pair[0].address, "was added twice"));
        }
        let path = self.path.clone();
        self.write(metadata).map_err(|error| ArchiveError::Io(path, error))
    }

    fn write(self, metadata: &Metadata) -> io::Result<()> {
        let block = Block {
            metadata,
            checksums: checksum_text(self.tiles.iter().map(|tile| tile.checksum)),
        };
        let header = tile_file::Header {
            kind: Kind::Unknown,
            is_gzipped: false,
            are_equal_tiles_one: false,
            zooms: [metadata.min_zoom + 1, metadata.max_zoom + 1],
            bounds: metadata.bounds,
            json: serde_json::to_string(&block)?,
        };
        let mut target = NewFile::create(&self.path)?;
        self.file.write(header, target.file())?;
        target.finish()
    }
}

/// The JSON block: what the archive says of itself, and of every tile's bytes.
#[derive(Serialize)]
struct Block<'a> {
    #[serde(flatten)]
    metadata: &'a Metadata,
    checksums: String,
}

/// The part of the block that is of no use outside this module.
#[derive(Deserialize)]
struct Checksums {
    checksums: String,
}

/// XXH3 of 64 bits finds accidents; it is no defence against whoever writes an archive.
fn checksum(bytes: &[u8]) -> u64 {
    XxHash3_64::oneshot(bytes)
}

/// Checksums in the order of the directory, little-endian, as base64.
fn checksum_text(checksums: impl Iterator<Item = u64>) -> String {
    BASE64_STANDARD.encode(checksums.flat_map(u64::to_le_bytes).collect::<Vec<u8>>())
}

fn parse_checksums(json: &str, tiles: usize) -> Result<Vec<u64>, String> {
    let block: Checksums = serde_json::from_str(json).map_err(|error| format!("its checksums: {error}"))?;
    let bytes = BASE64_STANDARD
        .decode(block.checksums)
        .map_err(|error| format!("its checksums: {error}"))?;
    let (checksums, rest) = bytes.as_chunks();
    if checksums.len() != tiles || !rest.is_empty() {
        return Err(format!("it has {tiles} tiles, but checksums of {}", checksums.len()));
    }
    Ok(checksums.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect())
}

/// An open archive; shared freely between threads.
pub struct Reader {
    path: PathBuf,
    metadata: Metadata,
    version: u128,
    /// In the order of their ids, and so are `ids` and `checksums`.
    addresses: Vec<TileAddress>,
    ids: Vec<u64>,
    checksums: Vec<u64>,
    tiles: Arc<AsyncPmTilesReader<Source, HashMapCache>>,
}

impl Reader {
    /// Opens the archive at `path` and reads its metadata and the list of its tiles.
    ///
    /// # Errors
    /// [`ArchiveError::Io`] when the file cannot be opened, [`ArchiveError::Unreadable`] when it is no file, no PMTiles
    /// archive or a broken one, [`ArchiveError::Foreign`] when it holds something else.
    pub fn open(path: &Path) -> Result<Self, ArchiveError> {
        let failed = |error| ArchiveError::Io(path.into(), error);
        // To open a pipe would wait for whoever writes into it.
        if !fs::metadata(path).map_err(failed)?.is_file() {
            return Err(ArchiveError::Unreadable(
                path.into(),
                "it is no regular file".to_owned(),
            ));
        }
        let file = File::open(path).map_err(failed)?;
        Self::over(path, Box::new(PlainFile(file)))
    }

    /// Opens the archive of which `source` has the bytes; `path` is what it is called in messages.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn over(path: &Path, source: Box<dyn ByteSource>) -> Result<Self, ArchiveError> {
        let failed = |error| ArchiveError::Io(path.into(), error);
        let unreadable = |error: PmtError| ArchiveError::Unreadable(path.into(), error.to_string());
        let foreign = |reason: String| ArchiveError::Foreign(path.into(), reason);
        let whole = is_whole(source.as_ref()).map_err(failed)?;
        let source = AsyncPmTilesReader::try_from_cached_source(Source(source), HashMapCache::default());
        let tiles = Arc::new(pollster::block_on(source).map_err(unreadable)?);
        if !whole {
            return Err(ArchiveError::Unreadable(path.into(), "it is cut short".to_owned()));
        }
        check_kind(tiles.get_header()).map_err(foreign)?;
        let json = pollster::block_on(tiles.get_metadata()).map_err(unreadable)?;
        let metadata = parse_metadata(&json).map_err(foreign)?;
        let entries = pollster::block_on(Arc::clone(&tiles).entries().try_collect()).map_err(unreadable)?;
        let addresses = entry_addresses(entries).map_err(foreign)?;
        let ids: Vec<u64> = addresses.iter().map(|&address| tile_id(address)).collect();
        if !ids.is_sorted_by(|one, next| one < next) {
            return Err(foreign("its directory is in disorder".to_owned()));
        }
        Ok(Self {
            path: path.into(),
            metadata,
            version: XxHash3_128::oneshot(json.as_bytes()),
            checksums: parse_checksums(&json, addresses.len()).map_err(foreign)?,
            addresses,
            ids,
            tiles,
        })
    }

    /// What the archive says of itself.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// A hash of the metadata and of all checksums: archives of one version hold the same.
    #[must_use]
    pub fn version(&self) -> u128 {
        self.version
    }

    /// What the bytes of the tile at `address` hash to, if the archive has it. Reads nothing.
    #[must_use]
    pub fn checksum(&self, address: TileAddress) -> Option<u64> {
        let index = self.ids.binary_search(&tile_id(address)).ok()?;
        Some(self.checksums[index])
    }

    /// The bytes of the tile at `address`, if the archive has it. Blocks for one read of the file.
    ///
    /// # Errors
    /// [`ArchiveError::Unreadable`] when the file is cut short or its directory is broken, [`ArchiveError::Damaged`] when
    /// the bytes are not those that were written.
    pub fn tile(&self, address: TileAddress) -> Result<Option<Vec<u8>>, ArchiveError> {
        let Some(expected) = self.checksum(address) else {
            return Ok(None);
        };
        let bytes = pollster::block_on(self.tiles.get_tile(coordinate(address)))
            .map_err(|error| ArchiveError::Unreadable(self.path.clone(), format!("tile {address}: {error}")))?;
        match bytes.filter(|bytes| checksum(bytes) == expected) {
            Some(bytes) => Ok(Some(Vec::from(bytes))),
            None => Err(ArchiveError::Damaged(self.path.clone(), address)),
        }
    }

    /// The tile that stands for a square: the one at `address`, or the leaf that is above it. Reads nothing.
    #[must_use]
    pub fn standing_for(&self, address: TileAddress) -> Option<TileAddress> {
        address::standing_for(address, |address| self.checksum(address).is_some())
    }

    /// All tiles, coarse zooms first, neighbours mostly one after the other.
    pub fn addresses(&self) -> impl ExactSizeIterator<Item = TileAddress> + '_ {
        self.addresses.iter().copied()
    }
}

/// Whether the file reaches to the end of its tiles, by bytes 56 to 71 of the header: where they begin, and their length.
fn is_whole(source: &dyn ByteSource) -> io::Result<bool> {
    let fields = source.read(56, 16)?;
    let (fields, _) = fields.as_chunks();
    let &[offset, length] = fields else { return Ok(false) };
    let [offset, length] = [offset, length].map(u64::from_le_bytes);
    let size = source.size()?;
    Ok(offset.checked_add(length).is_some_and(|end| end <= size))
}

fn check_kind(header: &Header) -> Result<(), String> {
    match (header.tile_type, header.tile_compression) {
        (TileType::Unknown, Compression::None) => Ok(()),
        (kind, compression) => Err(format!("its tiles are {kind:?}, compression {compression:?}")),
    }
}

fn parse_metadata(json: &str) -> Result<Metadata, String> {
    let metadata: Metadata = serde_json::from_str(json).map_err(|error| format!("its metadata: {error}"))?;
    if metadata.format != FORMAT || metadata.version != VERSION {
        return Err(format!(
            "its metadata say {} version {}",
            metadata.format, metadata.version
        ));
    }
    if metadata.max_zoom > MAX_ZOOM {
        return Err(format!(
            "its metadata say zoom {}, the largest is {MAX_ZOOM}",
            metadata.max_zoom
        ));
    }
    Ok(metadata)
}

/// Where a tile is in a PMTiles file; see the drawing at the top.
#[must_use]
pub fn square_tile(address: TileAddress) -> SquareTile {
    SquareTile {
        zoom: address.zoom + 1,
        x: address.x,
        y: (1_u32 << address.zoom) - 1 - address.y,
    }
}

fn coordinate(address: TileAddress) -> TileCoord {
    let SquareTile { zoom, x, y } = square_tile(address);
    TileCoord::new(zoom, x, y).expect("zoom + 1 is at most 27, and column and row fit in it")
}

/// Its number along the curve of PMTiles, zoom by zoom: tiles with numbers near each other are near each other.
#[must_use]
pub fn tile_id(address: TileAddress) -> u64 {
    TileId::from(coordinate(address)).value()
}

/// The other way round; `None` for what the drawing at the top calls never used.
fn address(coordinate: TileCoord) -> Option<TileAddress> {
    let zoom = coordinate.z().checked_sub(1)?;
    let row = (1_u32 << zoom).checked_sub(1 + coordinate.y())?;
    TileAddress::new(zoom, coordinate.x(), row)
}

/// The tiles of the directory. Tiles hold their own address, so no two are the same and every entry stands for one.
fn entry_addresses(entries: Vec<DirEntry>) -> Result<Vec<TileAddress>, String> {
    let tile = |entry: &DirEntry| {
        let mut ids = entry.iter_coords();
        let first = ids.next()?;
        ids.next().is_none().then(|| address(first.into()))?
    };
    let addresses: Option<Vec<TileAddress>> = entries.iter().map(tile).collect();
    addresses.ok_or_else(|| "its directory has tiles outside the geographic scheme".to_owned())
}

fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Where the bytes of an archive are. Any number of threads read at a time; they block while they do.
pub trait ByteSource: Send + Sync {
    /// How many bytes there are.
    ///
    /// # Errors
    /// When that cannot be found out.
    fn size(&self) -> io::Result<u64>;

    /// Bytes from `offset` on: `length`, or as many as there are.
    ///
    /// # Errors
    /// When they cannot be read.
    fn read(&self, offset: u64, length: usize) -> io::Result<Vec<u8>>;
}

/// Reads at a position, without a cursor to share. Unlike a memory map it gives an error, not a signal, when the file is cut short
/// under it.
struct PlainFile(File);

impl ByteSource for PlainFile {
    fn size(&self) -> io::Result<u64> {
        Ok(self.0.metadata()?.len())
    }

    fn read(&self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
        let available = usize::try_from(self.size()?.saturating_sub(offset)).unwrap_or(usize::MAX);
        let mut bytes = vec![0; length.min(available)];
        self.0.read_exact_at(&mut bytes, offset)?;
        Ok(bytes)
    }
}

/// Its futures are ready at once, since sources block, which is why [`Reader`] may wait for them anywhere.
struct Source(Box<dyn ByteSource>);

impl AsyncBackend for Source {
    async fn read(&self, offset: u64, length: usize) -> PmtResult<BackendResponse> {
        Ok(BackendResponse::new(self.0.read(offset, length)?.into()))
    }
}

#[cfg(test)]
#[path = "archive_tests.rs"]
pub(crate) mod tests;
