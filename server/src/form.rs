//! The forms of tiles that clients ask for.

use axum::body::Bytes;
use axum::http::{HeaderMap, header};
use terrain_codec::address::TileAddress;
use terrain_tiles::formats::quantized_mesh::{self, Extensions};
use terrain_tiles::layer_json::{Rows, SLIPPY_MAP};
use terrain_tiles::tile_file::SquareTile;

use crate::coding::Coding;
use crate::failure::Failure;
use crate::three_d_tiles::Part;
use crate::tileset::{TileError, Tileset};

/// Finest zoom of Web Mercator: columns and rows of finer ones do not fit their numbers.
const FINEST_SQUARE: u8 = 26;

/// In which form a tile is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Form {
    /// As it is in the archive.
    Progressive,
    /// For CesiumJS and others.
    QuantizedMesh { extensions: Extensions, coding: Coding },
    /// For clients of 3D Tiles.
    ThreeDTiles { part: Part, coding: Coding },
}

/// Which tile is wanted, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TileRequest {
    pub(crate) address: TileAddress,
    pub(crate) form: Form,
}

impl TileRequest {
    /// From the path's last three segments, the query and the headers.
    pub(crate) fn parse([z, x, file]: [&str; 3], query: &str, headers: &HeaderMap) -> Result<Self, Failure> {
        let (_, ending) = file.split_once('.').unwrap_or((file, ""));
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
        let mut address = tile_address([z, x, file])?;
        if asked_rows(query) == Rows::FromNorth {
            address.y = (1 << address.zoom) - 1 - address.y;
        }
        Ok(Self { address, form })
    }

    /// Changes whenever the tile's bytes in this form do, but for their content coding; none where there is no tile. Normals are made of
    /// tiles far around: with them it changes with the archive, without them only with what is beside.
    pub(crate) fn tag(&self, tileset: &Tileset) -> Option<String> {
        match self.form {
            Form::Progressive => tileset.checksum(self.address).map(hexadecimal),
            Form::ThreeDTiles { part, .. } => part.tag(tileset, self.address),
            Form::QuantizedMesh { extensions, .. } => {
                let content = if extensions.normals {
                    tileset.is_drawn(self.address).then(|| tileset.version.clone())
                } else {
                    tileset.checksum_with_surroundings(self.address).map(hexadecimal)
                };
                Some(quantized_mesh_tag(&content?, extensions))
            }
        }
    }

    /// The tile's bytes. Blocks while it reads and encodes.
    pub(crate) fn body(&self, tileset: &Tileset) -> Result<Bytes, TileError> {
        match self.form {
            Form::Progressive => Ok(tileset.stored(self.address)?.ok_or(TileError::Missing)?.into()),
            Form::QuantizedMesh { extensions, coding } => {
                let bytes = quantized_mesh::encode(&tileset.quantized_mesh(self.address, extensions)?, extensions);
                coding.encode(bytes.into()).map_err(TileError::failure)
            }
            Form::ThreeDTiles { part, coding } => {
                let bytes = part.bytes(tileset, self.address)?;
                coding.encode(bytes.into()).map_err(TileError::failure)
            }
        }
    }

    pub(crate) fn coding(&self) -> Coding {
        match self.form {
            Form::Progressive => Coding::Identity,
            Form::QuantizedMesh { coding, .. } | Form::ThreeDTiles { coding, .. } => coding,
        }
    }
}

/// Which tile of Web Mercator is wanted, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MercatorRequest {
    pub(crate) tile: SquareTile,
    extensions: Extensions,
    pub(crate) coding: Coding,
}

impl MercatorRequest {
    /// From the path's last three segments, the query and the headers.
    pub(crate) fn parse([z, x, file]: [&str; 3], query: &str, headers: &HeaderMap) -> Result<Self, Failure> {
        if !file.ends_with(".terrain") {
            return Err(Failure::BadRequest(format!("tiles end in .terrain, not in “{file}”")));
        }
        let mut tile = square_tile([z, x, file])?;
        if asked_rows(query) == Rows::FromSouth {
            tile.y = (1 << tile.zoom) - 1 - tile.y;
        }
        Ok(Self {
            tile,
            extensions: asked_extensions(query, headers),
            coding: Coding::accepted(headers),
        })
    }

    /// As [`TileRequest::tag`].
    pub(crate) fn tag(&self, tileset: &Tileset) -> Option<String> {
        let content = if self.extensions.normals {
            tileset.is_drawn_in_mercator(self.tile).then(|| tileset.version.clone())
        } else {
            tileset.checksum_in_mercator(self.tile).map(hexadecimal)
        };
        Some(quantized_mesh_tag(&content?, self.extensions))
    }

    /// The tile's bytes. Blocks while it reads and encodes.
    pub(crate) fn body(&self, tileset: &Tileset) -> Result<Bytes, TileError> {
        let mesh = tileset.quantized_mesh_in_mercator(self.tile, self.extensions)?;
        let bytes = quantized_mesh::encode(&mesh, self.extensions);
        self.coding.encode(bytes.into()).map_err(TileError::failure)
    }
}

fn hexadecimal(checksum: u64) -> String {
    format!("{checksum:016x}")
}

/// Of a quantized-mesh that is made of what `content` tells.
fn quantized_mesh_tag(content: &str, extensions: Extensions) -> String {
    let Extensions {
        normals,
        water_mask,
        measured_triangles,
    } = extensions;
    let flags = u8::from(normals) + 2 * u8::from(measured_triangles) + 4 * u8::from(water_mask);
    // Another program may encode it otherwise.
    format!("{content}-{flags}-{}", env!("CARGO_PKG_VERSION").replace('.', "-"))
}

/// From which end rows are counted.
pub(crate) fn asked_rows(query: &str) -> Rows {
    let asked = query.split('&').find_map(|part| part.strip_prefix("scheme="));
    if asked == Some(SLIPPY_MAP) {
        Rows::FromNorth
    } else {
        Rows::FromSouth
    }
}

/// From zoom, column, and row with an ending.
pub(crate) fn tile_address([z, x, file]: [&str; 3]) -> Result<TileAddress, Failure> {
    let y = file.split('.').next().unwrap_or_default();
    let numbers = whole_number(z)
        .and_then(|zoom| u8::try_from(zoom).ok())
        .zip(whole_number(x))
        .zip(whole_number(y));
    numbers
        .and_then(|((zoom, x), y)| TileAddress::new(zoom, x, y))
        .ok_or_else(|| {
            Failure::BadRequest(format!(
                "{z}/{x}/{file} is no tile: zooms are 0 to 26, zoom z has columns 0 to 2^(z+1) − 1 and rows 0 to 2^z − 1"
            ))
        })
}

/// A tile of Web Mercator, from zoom, column, and row with an ending.
pub(crate) fn square_tile([z, x, file]: [&str; 3]) -> Result<SquareTile, Failure> {
    let y = file.split('.').next().unwrap_or_default();
    match (whole_number(z), whole_number(x), whole_number(y)) {
        (Some(zoom), Some(x), Some(y)) if zoom <= u32::from(FINEST_SQUARE) && x >> zoom == 0 && y >> zoom == 0 => {
            Ok(SquareTile { zoom: zoom as u8, x, y })
        }
        _ => Err(Failure::BadRequest(format!(
            "{z}/{x}/{file} is no tile of Web Mercator: zoom z, of 0 to {FINEST_SQUARE}, has columns and rows 0 to 2^z − 1"
        ))),
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
