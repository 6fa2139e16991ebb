//! The parts of both tilesets, each made on request.

use terrain_codec::address::TileAddress;
use terrain_tiles::formats::quantized_mesh::Extensions;
use terrain_tiles::formats::three_d_tiles::{self as format, Described, Packing, Squares, TileSurface};

use crate::failure::Failure;
use crate::tileset::{TileError, Tileset};

/// What of a tileset is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Part {
    /// The first document of the explicit tileset.
    Explicit(Packing),
    /// The document below a tile.
    Document(Packing),
    /// A tile, as far as it is measured.
    Measured(Packing),
    /// The document of the implicit tileset.
    Implicit(Packing),
    /// The subtree below a tile.
    Subtree,
    /// A tile, completed to its whole square.
    Whole(Packing),
}

impl Part {
    pub(crate) fn content_type(self) -> &'static str {
        match self {
            Self::Explicit(_) | Self::Document(_) | Self::Implicit(_) => "application/json",
            Self::Measured(_) | Self::Whole(_) => "model/gltf-binary",
            Self::Subtree => "application/octet-stream",
        }
    }

    /// Changes with the archive, and if another program is asked; none where there is no such part.
    pub(crate) fn tag(self, tileset: &Tileset, address: TileAddress) -> Option<String> {
        let (kind, packing) = match self {
            Self::Explicit(packing) => ("e", packing),
            Self::Implicit(packing) => ("i", packing),
            Self::Document(packing) => ("d", packing),
            Self::Subtree => ("s", Packing::Plain),
            Self::Measured(packing) => ("m", packing),
            Self::Whole(packing) => ("w", packing),
        };
        let is_there = match self {
            Self::Explicit(_) | Self::Implicit(_) => true,
            Self::Document(_) | Self::Measured(_) => tileset.checksum(address).is_some(),
            Self::Subtree | Self::Whole(_) => tileset.is_drawn(address),
        };
        is_there.then(|| {
            format!(
                "{}-{kind}-{}-{}",
                tileset.version,
                packing.name(),
                env!("CARGO_PKG_VERSION").replace('.', "-")
            )
        })
    }

    /// The bytes of a part. Blocks while it reads and encodes.
    pub(crate) fn bytes(self, tileset: &Tileset, address: TileAddress) -> Result<Vec<u8>, TileError> {
        match self {
            Self::Explicit(packing) => document(tileset, None, packing),
            Self::Document(packing) => document(tileset, Some(address), packing),
            Self::Measured(packing) => measured(tileset, address, packing),
            Self::Implicit(packing) => Ok(format::tileset(&query(tileset, packing), tileset.metadata())
                .to_string()
                .into_bytes()),
            Self::Subtree => subtree(tileset, address),
            Self::Whole(packing) => whole(tileset, address, packing),
        }
    }
}

/// What ends the addresses in documents.
fn query(tileset: &Tileset, packing: Packing) -> String {
    let version = &tileset.version;
    match packing {
        Packing::Plain => format!("?v={version}"),
        Packing::Meshopt => format!("?v={version}&packing={}", packing.name()),
    }
}

fn document(tileset: &Tileset, root: Option<TileAddress>, packing: Packing) -> Result<Vec<u8>, TileError> {
    let describe = |address| describe(tileset, address);
    let query = query(tileset, packing);
    let document = format::document(root, packing, &query, tileset.metadata(), &describe)?;
    document
        .map(|document| document.to_string().into_bytes())
        .ok_or(TileError::Missing)
}

/// What stands before a tile's levels.
fn describe(tileset: &Tileset, address: TileAddress) -> Result<Option<Described>, TileError> {
    let Some(bytes) = tileset.stored(address)? else {
        return Ok(None);
    };
    let described =
        Described::of_stored(&bytes).map_err(|error| Failure::internal(format!("tile {address}: {error}")))?;
    Ok(Some(described))
}

/// Heights and error of what is over a square: of the tile, or of ground beside tiles, which is as high as these are where they meet.
fn describe_square(tileset: &Tileset, address: TileAddress) -> Result<Option<([f64; 2], f64)>, TileError> {
    if let Some(described) = describe(tileset, address)? {
        return Ok(Some((described.heights, described.error)));
    }
    if !tileset.has_ground(address) {
        return Ok(None);
    }
    let mut heights = [f64::INFINITY, f64::NEG_INFINITY];
    for beside in address.around() {
        if let Some(Described {
            heights: [low, high], ..
        }) = describe(tileset, beside)?
        {
            heights = [heights[0].min(low), heights[1].max(high)];
        }
    }
    Ok(Some((heights, 0.0)))
}

fn measured(tileset: &Tileset, address: TileAddress, packing: Packing) -> Result<Vec<u8>, TileError> {
    let surface = tileset.surface(address, true)?.ok_or(TileError::Missing)?;
    glb(tileset, &TileSurface::measured(&surface, packing), packing)
}

fn whole(tileset: &Tileset, address: TileAddress, packing: Packing) -> Result<Vec<u8>, TileError> {
    let mesh = tileset.quantized_mesh(
        address,
        Extensions {
            normals: true,
            ..Extensions::default()
        },
    )?;
    glb(tileset, &TileSurface::whole_square(&mesh, address, packing), packing)
}

fn glb(tileset: &Tileset, surface: &TileSurface, packing: Packing) -> Result<Vec<u8>, TileError> {
    format::file(surface, packing, tileset.metadata()).ok_or(TileError::Missing)
}

fn subtree(tileset: &Tileset, address: TileAddress) -> Result<Vec<u8>, TileError> {
    let describe = |address| describe_square(tileset, address);
    let squares = Squares {
        outside: &tileset.metadata().outside,
        describe,
    };
    format::subtree(address, tileset.metadata().max_zoom, &squares)?.ok_or(TileError::Missing)
}
