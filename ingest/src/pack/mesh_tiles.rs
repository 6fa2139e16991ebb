//! A folder of quantized-mesh as one PMTiles file: where tiles are is told in `docs/formats/archive.md`. Tiles are compressed by gzip.

use std::fs::{self, File};
use std::path::Path;

use terrain_codec::address::TileAddress;
use terrain_tiles::archive::square_tile;
use terrain_tiles::metadata::Metadata;
use terrain_tiles::tile_file::{Header, Kind, TileFile};

use super::stored::gzipped;

/// Writes the tiles of `folder` at `addresses`, and its `layer.json`, as `output`.
pub(super) fn write(
    folder: &Path,
    addresses: impl Iterator<Item = TileAddress>,
    metadata: &Metadata,
    output: &Path,
) -> anyhow::Result<()> {
    let mut file = TileFile::create_in(folder)?;
    for address in addresses {
        file.add(square_tile(address), &gzipped(folder, address)?)?;
    }
    let header = Header {
        kind: Kind::Unknown,
        is_gzipped: true,
        are_equal_tiles_one: true,
        zooms: [metadata.min_zoom + 1, metadata.max_zoom + 1],
        bounds: metadata.bounds,
        json: fs::read_to_string(folder.join("layer.json"))?,
    };
    Ok(file.write(header, &mut File::create_new(output)?)?)
}
