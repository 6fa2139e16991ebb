//! A PMTiles file of tiles of any kind (Protomaps, *PMTiles* version 3, 2022). Directories and metadata are gzipped.
//!
//! ```text
//! tiles, in any order ─▶ a file without a name ─▶ header, directory, metadata, tiles in the order of their ids
//! ```

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use pmtiles::{CallerKey, Compression, PmTilesWriter, PmtError, TileCoord, TileId, TileType};
use twox_hash::XxHash3_128;

/// A tile of one square that is cut in four at each zoom; rows from the north.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SquareTile {
    /// How often it was cut.
    pub zoom: u8,
    /// Column from the west.
    pub x: u32,
    /// Row from the north.
    pub y: u32,
}

/// What tiles are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Something that PMTiles has no name for.
    Unknown,
    /// Images.
    Png,
    /// Images.
    WebP,
}

/// What the file says of itself.
pub struct Header {
    /// What tiles are.
    pub kind: Kind,
    /// Whether the tiles that were added are compressed.
    pub is_gzipped: bool,
    /// Whether tiles of the same bytes are written once: where a reader takes an entry of the directory for one tile, they are not.
    pub are_equal_tiles_one: bool,
    /// The coarsest and the finest.
    pub zooms: [u8; 2],
    /// West, south, east, north of the data in degrees; east may exceed 180.
    pub bounds: [f64; 4],
    /// A JSON object with everything else.
    pub json: String,
}

/// A file while its tiles are collected: they wait in a file without a name, so that the bytes that are written depend on the tiles
/// alone.
pub struct TileFile {
    spool: File,
    spooled: u64,
    tiles: Vec<Spooled>,
}

/// A tile in the unnamed file.
struct Spooled {
    id: u64,
    coordinate: TileCoord,
    offset: u64,
    length: usize,
}

impl TileFile {
    /// With no tile yet. `folder` has room for all of them.
    ///
    /// # Errors
    /// When no file can be made in the folder.
    pub fn create_in(folder: &Path) -> io::Result<Self> {
        Ok(Self {
            spool: tempfile::tempfile_in(folder)?,
            spooled: 0,
            tiles: Vec::new(),
        })
    }

    /// Adds a tile, which was not added before.
    ///
    /// # Errors
    /// When the disk is full, or the square has no such tile.
    pub fn add(&mut self, tile: SquareTile, bytes: &[u8]) -> io::Result<()> {
        let coordinate = TileCoord::new(tile.zoom, tile.x, tile.y).map_err(into_io)?;
        self.spool.write_all(bytes)?;
        self.tiles.push(Spooled {
            id: TileId::from(coordinate).value(),
            coordinate,
            offset: self.spooled,
            length: bytes.len(),
        });
        self.spooled += bytes.len() as u64;
        Ok(())
    }

    /// Writes all of it.
    ///
    /// # Errors
    /// When the disk is full.
    pub fn write(mut self, header: Header, target: &mut File) -> io::Result<()> {
        self.tiles.sort_unstable_by_key(|tile| tile.id);
        let are_equal_tiles_one = header.are_equal_tiles_one;
        let mut writer = builder(header).create(target).map_err(into_io)?;
        let mut bytes = Vec::new();
        for tile in &self.tiles {
            bytes.resize(tile.length, 0);
            self.spool.seek(SeekFrom::Start(tile.offset))?;
            self.spool.read_exact(&mut bytes)?;
            let key = are_equal_tiles_one.then(|| XxHash3_128::oneshot(&bytes));
            writer.add_tile(tile.coordinate, &bytes, key).map_err(into_io)?;
        }
        writer.finalize().map_err(into_io)
    }
}

/// PMTiles longitudes end at ±180: data across the antimeridian are given the whole circle there.
fn builder(header: Header) -> PmTilesWriter<CallerKey<u128>> {
    let [west, south, east, north] = header.bounds;
    let (first, last) = if east > 180.0 { (-180.0, 180.0) } else { (west, east) };
    let middle = west.midpoint(east);
    let kind = match header.kind {
        Kind::Unknown => TileType::Unknown,
        Kind::Png => TileType::Png,
        Kind::WebP => TileType::Webp,
    };
    let compression = if header.is_gzipped {
        Compression::Gzip
    } else {
        Compression::None
    };
    PmTilesWriter::new(kind)
        .dedup_by_key()
        .precompressed(compression)
        .min_zoom(header.zooms[0])
        .max_zoom(header.zooms[1])
        .bounds(first, south, last, north)
        .center(
            if middle > 180.0 { middle - 360.0 } else { middle },
            south.midpoint(north),
        )
        .center_zoom(header.zooms[1])
        .metadata(header.json)
}

fn into_io(error: PmtError) -> io::Error {
    match error {
        PmtError::Reading(error) => error,
        other => io::Error::other(other),
    }
}
