//! A folder of quantized-mesh as a database (MapBox, *MBTiles* 1.3). Rows count from the south there, as in the folder. Tiles are
//! compressed by gzip.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use rusqlite::{Connection, params};
use terrain_tiles::address::TileAddress;
use terrain_tiles::metadata::Metadata;

use super::stored::gzipped;

/// `MPBX`: what tells such a file from other databases.
const APPLICATION: i32 = 0x4d50_4258;
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
    let mut database = Connection::open(output)?;
    database.pragma_update(None, "application_id", APPLICATION)?;
    let all = database.transaction()?;
    all.execute_batch(TABLES)?;
    for (name, value) in description(folder, metadata)? {
        all.execute("INSERT INTO metadata VALUES (?, ?)", params![name, value])?;
    }
    {
        let mut insert = all.prepare("INSERT INTO tiles VALUES (?, ?, ?, ?)")?;
        for address in addresses {
            insert.execute(params![address.zoom, address.x, address.y, gzipped(folder, address)?])?;
        }
    }
    all.commit()?;
    database.close().map_err(|(_, error)| error.into())
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
