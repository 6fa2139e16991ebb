//! The explicit tileset: every tile with its own certified error, in documents of a few zooms each.
//!
//! ```text
//!  document(none)   zooms 0…3 ── stubs at zoom 4 ─▶ document(4/x/y)   zooms 4…7 ── stubs at zoom 8 ─▶ …
//! ```

use serde_json::{Value, json};
use terrain_codec::address::TileAddress;
use terrain_codec::{DecodeError, LevelLimits, spt};

use super::Packing;
use super::region::Region;
use crate::metadata::Metadata;

/// Zooms of a document; at the next one are the documents that it names.
pub const DOCUMENT_ZOOMS: u8 = 4;

/// What an explicit tileset tells of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Described {
    /// Lowest and highest height of its vertices, metres.
    pub heights: [f64; 2],
    /// Certified vertical error of its finest surface, metres.
    pub error: f64,
}

impl Described {
    /// What stands before the levels of a stored tile.
    ///
    /// # Errors
    /// When `bytes` are no tile.
    pub fn of_stored(bytes: &[u8]) -> Result<Self, DecodeError> {
        let head = spt::decode_head(bytes, &LevelLimits::default())?;
        Ok(Self {
            heights: head.heights,
            error: head.errors[0],
        })
    }
}

/// The document whose root is the tile at `root`, or both roots of the Earth; none where there is no tile. Its tiles' files are in
/// `packing`; `query` ends every address. `describe` tells of a tile, if there is one.
///
/// # Errors
/// What `describe` says.
pub fn document<E>(
    root: Option<TileAddress>,
    packing: Packing,
    query: &str,
    metadata: &Metadata,
    describe: &impl Fn(TileAddress) -> Result<Option<Described>, E>,
) -> Result<Option<Value>, E> {
    let writer = Writer {
        packing,
        query,
        metadata,
        first_zoom: root.map_or(0, |root| root.zoom),
        describe,
    };
    let top = match root {
        Some(root) => writer.tile(root)?,
        None => writer.earth()?,
    };
    Ok(top.map(|mut top| {
        top.value["refine"] = json!("REPLACE");
        json!({
            "asset": { "version": "1.1", "extras": extras(metadata) },
            "schema": schema(),
            "geometricError": 2.0 * top.error,
            "root": top.value,
        })
    }))
}

/// What is told of the source.
fn extras(metadata: &Metadata) -> Value {
    json!({
        "source": metadata.source.files,
        "sourceVerticalDatum": metadata.source.vertical_datum,
        "heightsAbove": metadata.source.tiles_above(),
        "errorBoundedAt": metadata.bound,
        "generator": metadata.generator,
    })
}

fn schema() -> Value {
    json!({
        "id": "terrain",
        "classes": { "tile": { "properties": {
            "certifiedError": {
                "type": "SCALAR", "componentType": "FLOAT64", "required": true,
                "description": "Largest distance in metres along the vertical between this tile's surface and the source",
            },
            "rounding": {
                "type": "SCALAR", "componentType": "FLOAT64", "required": true,
                "description": "Largest distance in metres by which rounding in the file moves a place of this surface",
            },
        } } },
    })
}

struct Writer<'a, F> {
    packing: Packing,
    query: &'a str,
    metadata: &'a Metadata,
    first_zoom: u8,
    describe: &'a F,
}

/// A tile of a document, and what its parent must not fall short of.
struct Written {
    value: Value,
    error: f64,
    region: [f64; 6],
}

impl<F, E> Writer<'_, F>
where
    F: Fn(TileAddress) -> Result<Option<Described>, E>,
{
    /// Both roots below a tile without content.
    fn earth(&self) -> Result<Option<Written>, E> {
        let roots = [0, 1].map(|x| TileAddress { zoom: 0, x, y: 0 });
        let children = self.tiles(&roots)?;
        let Some(region) = union(children.iter().map(|child| child.region)) else {
            return Ok(None);
        };
        let error = 2.0 * children.iter().map(|child| child.error).fold(0.0, f64::max);
        let children: Vec<Value> = children.into_iter().map(|child| child.value).collect();
        let value = json!({ "boundingVolume": { "region": region }, "geometricError": error, "children": children });
        Ok(Some(Written { value, error, region }))
    }

    fn tiles(&self, addresses: &[TileAddress]) -> Result<Vec<Written>, E> {
        addresses
            .iter()
            .filter_map(|&address| self.tile(address).transpose())
            .collect()
    }

    /// The tile at `address` and all below it in this document. No error and no region is less than those below.
    fn tile(&self, address: TileAddress) -> Result<Option<Written>, E> {
        let Some(described) = (self.describe)(address)? else {
            return Ok(None);
        };
        let is_stub = address.zoom >= self.first_zoom + DOCUMENT_ZOOMS;
        let children = if is_stub {
            Vec::new()
        } else {
            self.tiles(&address.children())?
        };
        let rounding = self.packing.rounding(address);
        let own = described.error + rounding;
        let error = children.iter().map(|child| child.error).fold(own, f64::max);
        let region = self.region(address, described).radians();
        let region = union(children.iter().map(|child| child.region).chain([region])).unwrap_or(region);
        let ending = if is_stub { "json" } else { "glb" };
        let mut value = json!({
            "boundingVolume": { "region": region },
            "geometricError": error,
            "content": { "uri": self.uri(address, ending) },
            "metadata": { "class": "tile", "properties": { "certifiedError": described.error, "rounding": rounding } },
        });
        if !children.is_empty() {
            value["children"] = children.into_iter().map(|child| child.value).collect();
        }
        Ok(Some(Written { value, error, region }))
    }

    /// From this document, which is at `tileset.json` or at `z/x/y.json`.
    fn uri(&self, address: TileAddress, ending: &str) -> String {
        let up = if self.first_zoom == 0 { "" } else { "../../" };
        format!("{up}{address}.{ending}{}", self.query)
    }

    /// The surface is nowhere lower than the source by more than its error, nor than its vertices by more than triangles dip; rounding
    /// moves it.
    fn region(&self, address: TileAddress, described: Described) -> Region {
        let [low, high] = described.heights;
        let lowest = self.metadata.heights[0] - described.error;
        let lowest = (low - Region::dip(address)).max(lowest.min(low));
        let rounding = self.packing.rounding(address);
        Region {
            address,
            heights: [lowest - rounding, high + rounding],
        }
    }
}

/// The least region around all.
fn union(regions: impl Iterator<Item = [f64; 6]>) -> Option<[f64; 6]> {
    regions.reduce(|a, b| {
        let least = |place: usize| a[place].min(b[place]);
        let most = |place: usize| a[place].max(b[place]);
        [least(0), least(1), most(2), most(3), least(4), most(5)]
    })
}
