//! A folder of quantized-mesh as a database (MapBox, *MBTiles* 1.3). Rows count from the south there, as in the folder. Tiles are
//! compressed by gzip.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;

use anyhow::{Context, anyhow};
use rusqlite::{Connection, OpenFlags, params};
use terrain_codec::address::TileAddress;
use terrain_tiles::metadata::Metadata;

use super::stored::gzipped;

/// `MPBX`: what tells such a file from other databases.
const APPLICATION: i32 = 0x4d50_4258;
/// What every database of SQLite begins with.
const HEAD: &[u8; 16] = b"SQLite format 3\0";
/// Kinds of rows where they stand one after the other.
const METADATA: u8 = 0;
const TILE: u8 = 1;
const TABLES: &str = "
    CREATE TABLE metadata (name TEXT NOT NULL, value TEXT NOT NULL);
    CREATE TABLE tiles (zoom_level INTEGER NOT NULL, tile_column INTEGER NOT NULL, tile_row INTEGER NOT NULL, tile_data BLOB NOT NULL);
    CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row);";

/// Writes the tiles of `folder` at `addresses`, and its `layer.json`, as `output`.
pub(super) fn write(
    folder: &Path,
    addresses: impl Iterator<Item = TileAddress>,
    metadata: &Metadata,
    output: &Path,
) -> anyhow::Result<()> {
    let description = description(folder, metadata)?.into_iter();
    let description = description.map(|(name, value)| Row::Metadata(name.to_owned(), value));
    let tiles = addresses.map(|address| {
        let place = [u32::from(address.zoom), address.x, address.y];
        Ok(Row::Tile(place, gzipped(folder, address)?))
    });
    write_rows(description.map(Ok).chain(tiles), output)
}

/// A row of one of the two tables.
enum Row {
    /// Name and value.
    Metadata(String, String),
    /// Zoom, column and row, and what is there.
    Tile([u32; 3], Vec<u8>),
}

/// Writes a database of these rows, in their order.
fn write_rows(rows: impl Iterator<Item = anyhow::Result<Row>>, output: &Path) -> anyhow::Result<()> {
    let mut database = Connection::open(output)?;
    database.pragma_update(None, "application_id", APPLICATION)?;
    let all = database.transaction()?;
    all.execute_batch(TABLES)?;
    {
        let mut describe = all.prepare("INSERT INTO metadata VALUES (?, ?)")?;
        let mut insert = all.prepare("INSERT INTO tiles VALUES (?, ?, ?, ?)")?;
        for row in rows {
            match row? {
                Row::Metadata(name, value) => describe.execute(params![name, value])?,
                Row::Tile([zoom, column, row], data) => insert.execute(params![zoom, column, row, data])?,
            };
        }
    }
    all.commit()?;
    database.close().map_err(|(_, error)| error.into())
}

/// Whether a file is a database of tiles.
pub(super) fn is_database(path: &Path) -> anyhow::Result<bool> {
    let mut head = [0; HEAD.len()];
    let mut file = File::open(path).with_context(|| path.display().to_string())?;
    // Shorter files are none.
    Ok(file.read_exact(&mut head).is_ok() && &head == HEAD && is_of_tiles(path).unwrap_or(false))
}

fn is_of_tiles(path: &Path) -> rusqlite::Result<bool> {
    let database = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)?;
    let application: i32 = database.pragma_query_value(None, "application_id", |row| row.get(0))?;
    Ok(application == APPLICATION)
}

/// Writes the rows of a database one after the other as `output`: what stays stands there as it was, whatever is before it.
pub(super) fn flatten(path: &Path, output: &Path) -> anyhow::Result<()> {
    let database = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)?;
    let mut out = BufWriter::new(File::create_new(output)?);
    let mut put = |kind: u8, fields: &[&[u8]]| -> anyhow::Result<()> {
        out.write_all(&[kind])?;
        for field in fields {
            out.write_all(&u32::try_from(field.len())?.to_le_bytes())?;
            out.write_all(field)?;
        }
        Ok(())
    };
    let mut describe = database.prepare("SELECT name, value FROM metadata ORDER BY rowid")?;
    let mut rows = describe.query([])?;
    while let Some(row) = rows.next()? {
        let (name, value): (String, String) = (row.get(0)?, row.get(1)?);
        put(METADATA, &[name.as_bytes(), value.as_bytes()])?;
    }
    let columns = "SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles ORDER BY rowid";
    let mut tiles = database.prepare(columns)?;
    let mut rows = tiles.query([])?;
    while let Some(row) = rows.next()? {
        let place: [u32; 3] = [row.get(0)?, row.get(1)?, row.get(2)?];
        let place: Vec<u8> = place.into_iter().flat_map(u32::to_le_bytes).collect();
        put(TILE, &[&place, row.get_ref(3)?.as_blob()?])?;
    }
    Ok(out.flush()?)
}

/// The database that was flattened.
pub(super) fn unflatten(path: &Path, output: &Path) -> anyhow::Result<()> {
    let mut input = BufReader::new(File::open(path)?);
    let mut next = || -> anyhow::Result<Option<Row>> {
        let mut kind = [0];
        if input.read(&mut kind)? == 0 {
            return Ok(None);
        }
        let mut field = || -> anyhow::Result<Vec<u8>> {
            let mut length = [0; 4];
            input.read_exact(&mut length)?;
            let mut bytes = Vec::new();
            input
                .by_ref()
                .take(u32::from_le_bytes(length).into())
                .read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        let (first, second) = (field()?, field()?);
        if kind[0] == METADATA {
            return Ok(Some(Row::Metadata(
                String::from_utf8(first)?,
                String::from_utf8(second)?,
            )));
        }
        let numbers = first.as_chunks().0.iter().map(|&bytes| u32::from_le_bytes(bytes));
        let numbers: Vec<u32> = numbers.collect();
        let place = <[u32; 3]>::try_from(numbers).map_err(|_| anyhow!("a tile without its place"))?;
        Ok(Some(Row::Tile(place, second)))
    };
    write_rows(std::iter::from_fn(|| next().transpose()), output)
}

/// What the format asks for, and what readers of quantized-mesh ask for.
fn description(folder: &Path, metadata: &Metadata) -> anyhow::Result<BTreeMap<&'static str, String>> {
    let [west, south, east, north] = metadata.bounds_within_180();
    let middle = f64::midpoint(west, east);
    let zoom = metadata.max_zoom;
    Ok(BTreeMap::from([
        ("name", metadata.source.files.join(", ")),
        ("format", "application/vnd.quantized-mesh".to_owned()),
        ("bounds", format!("{west},{south},{east},{north}")),
        ("center", format!("{middle},{},{zoom}", f64::midpoint(south, north))),
        ("minzoom", "0".to_owned()),
        ("maxzoom", zoom.to_string()),
        ("type", "baselayer".to_owned()),
        ("crs", "EPSG:4326".to_owned()),
        ("scheme", "tms".to_owned()),
        ("tile_compression", "gzip".to_owned()),
        ("json", fs::read_to_string(folder.join("layer.json"))?),
    ]))
}
