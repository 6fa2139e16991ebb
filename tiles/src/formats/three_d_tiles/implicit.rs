//! The implicit tileset: two roots, each a quadtree over half of the Earth, whose availability and bounds are in subtrees. So does
//! `Cesium3DTilesTerrainProvider` of CesiumJS want it.
//!
//! Of a root, column x of the geographic scheme is x mod 2^zoom; rows count from the south in both.

use serde_json::{Value, json};
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::SEMI_MAJOR;

use super::region::Region;
use crate::metadata::Metadata;
use crate::outside::Outside;

/// Zooms of a subtree.
pub const SUBTREE_LEVELS: u8 = 7;

/// What the subtrees ask of an archive.
pub struct Squares<'a, F> {
    /// What is where nothing was measured.
    pub outside: &'a Outside,
    /// Lowest and highest height of the vertices of a tile in metres, and its certified error; none where there is no tile.
    pub describe: F,
}

/// `tileset.json`; `query` ends every address.
#[must_use]
pub fn tileset(query: &str, metadata: &Metadata) -> Value {
    // Zooms 0 to the last; at least one subtree's root must be there.
    let levels = u32::from(metadata.max_zoom) + 1;
    let pi = std::f64::consts::PI;
    let root = |number: u32| {
        let west = f64::from(number) * pi - pi;
        json!({
            "boundingVolume": { "region": region(west, west + pi, metadata) },
            "geometricError": error_of_zoom(0),
            "content": { "uri": format!("{number}/{{level}}/{{x}}/{{y}}.glb{query}") },
            "implicitTiling": {
                "subdivisionScheme": "QUADTREE",
                "subtreeLevels": SUBTREE_LEVELS,
                "availableLevels": levels,
                "subtrees": { "uri": format!("{number}/{{level}}/{{x}}/{{y}}.subtree{query}") },
            },
        })
    };
    json!({
        "asset": { "version": "1.1" },
        "schema": schema(),
        "geometricError": 2.0 * error_of_zoom(0),
        "root": {
            "boundingVolume": { "region": region(-pi, pi, metadata) },
            "refine": "REPLACE",
            "geometricError": 2.0 * error_of_zoom(0),
            "children": [root(0), root(1)],
        },
    })
}

fn region(west: f64, east: f64, metadata: &Metadata) -> [f64; 6] {
    let quarter = std::f64::consts::FRAC_PI_2;
    let [low, high] = metadata.heights;
    let outside = metadata.outside.everywhere();
    [west, -quarter, east, quarter, low.min(outside[0]), high.max(outside[1])]
}

/// The error that CesiumJS takes for tiles of 65 vertices a side of a zoom: 77,067 m at zoom 0. It reads none of those written here.
fn error_of_zoom(zoom: u8) -> f64 {
    SEMI_MAJOR * std::f64::consts::TAU * 0.25 / (65.0 * 2.0) / f64::from(1_u32 << zoom)
}

fn schema() -> Value {
    let number = |semantic: &str| json!({ "type": "SCALAR", "componentType": "FLOAT64", "semantic": semantic });
    let sphere = json!({
        "type": "SCALAR", "componentType": "FLOAT64", "array": true, "count": 4, "semantic": "TILE_BOUNDING_SPHERE",
    });
    json!({
        "id": "terrain",
        "classes": { "tile": { "properties": {
            "minimumHeight": number("TILE_MINIMUM_HEIGHT"),
            "maximumHeight": number("TILE_MAXIMUM_HEIGHT"),
            "boundingSphere": sphere,
            "horizonOcclusionPoint": {
                "type": "VEC3", "componentType": "FLOAT64", "semantic": "TILE_HORIZON_OCCLUSION_POINT",
            },
            "geometricError": number("TILE_GEOMETRIC_ERROR"),
        } } },
    })
}

/// The bytes of the subtree below the tile at `top`; none where there is none. Both roots of the Earth always have one.
///
/// # Errors
/// What `squares` say.
pub fn subtree<E>(
    top: TileAddress,
    max_zoom: u8,
    squares: &Squares<impl Fn(TileAddress) -> Result<Option<([f64; 2], f64)>, E>>,
) -> Result<Option<Vec<u8>>, E> {
    let last = (top.zoom + SUBTREE_LEVELS).min(max_zoom + 1);
    let mut tiles = Availability::default();
    let mut properties = Properties::default();
    for zoom in top.zoom..top.zoom + SUBTREE_LEVELS {
        for address in in_morton_order(top, zoom) {
            let described = if zoom < last {
                (squares.describe)(address)?
            } else {
                None
            };
            let described = described.or_else(|| (zoom == 0).then_some(([f64::INFINITY, f64::NEG_INFINITY], 0.0)));
            tiles.push(described.is_some());
            if let Some((heights, error)) = described {
                properties.push(address, around(heights, squares.outside.heights_over(address)), error);
            }
        }
    }
    if tiles.count == 0 {
        return Ok(None);
    }
    let mut children = Availability::default();
    let below = top.zoom + SUBTREE_LEVELS;
    for address in in_morton_order(top, below) {
        children.push(below <= max_zoom && (squares.describe)(address)?.is_some());
    }
    Ok(Some(bytes(&tiles, &children, &properties)))
}

fn around([low, high]: [f64; 2], [other_low, other_high]: [f64; 2]) -> [f64; 2] {
    [low.min(other_low), high.max(other_high)]
}

/// The tiles of `zoom` below `top`: bits of the column and of the row in turn, the column's first.
fn in_morton_order(top: TileAddress, zoom: u8) -> impl Iterator<Item = TileAddress> {
    let depth = zoom - top.zoom;
    (0..1_u32 << (2 * depth)).map(move |index| {
        let every_second = |first: u8| {
            (0..depth)
                .map(|bit| (index >> (2 * bit + first) & 1) << bit)
                .sum::<u32>()
        };
        TileAddress {
            zoom,
            x: (top.x << depth) + every_second(0),
            y: (top.y << depth) + every_second(1),
        }
    })
}

/// A bit for each tile, least significant first.
#[derive(Default)]
struct Availability {
    bytes: Vec<u8>,
    length: usize,
    count: usize,
}

impl Availability {
    fn push(&mut self, is_available: bool) {
        if self.length.is_multiple_of(8) {
            self.bytes.push(0);
        }
        if is_available {
            self.bytes[self.length / 8] |= 1 << (self.length % 8);
            self.count += 1;
        }
        self.length += 1;
    }
}

/// Columns of the table of available tiles, in the order of the schema.
#[derive(Default)]
struct Properties {
    columns: [Vec<f64>; 5],
}

const NAMES: [&str; 5] = [
    "minimumHeight",
    "maximumHeight",
    "boundingSphere",
    "horizonOcclusionPoint",
    "geometricError",
];

impl Properties {
    fn push(&mut self, address: TileAddress, heights: [f64; 2], error: f64) {
        let region = Region { address, heights };
        let (center, radius) = region.sphere();
        let point = region.horizon_occlusion_point(center);
        self.columns[0].push(heights[0]);
        self.columns[1].push(heights[1]);
        self.columns[2].extend(center.to_array().into_iter().chain([radius]));
        self.columns[3].extend(point.to_array());
        self.columns[4].push(error);
    }
}

/// Header, description, binary part. Every view begins at a multiple of eight bytes.
fn bytes(tiles: &Availability, children: &Availability, properties: &Properties) -> Vec<u8> {
    let mut binary: Vec<u8> = Vec::new();
    let mut views: Vec<Value> = Vec::new();
    let mut add = |bytes: &[u8]| {
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() }));
        binary.extend(bytes);
        binary.resize(binary.len().next_multiple_of(8), 0);
        views.len() - 1
    };
    let tile_availability = json!({ "bitstream": add(&tiles.bytes), "availableCount": tiles.count });
    let child_availability = match children.count {
        0 => json!({ "constant": 0 }),
        count => json!({ "bitstream": add(&children.bytes), "availableCount": count }),
    };
    let columns = NAMES.into_iter().zip(&properties.columns);
    let columns: serde_json::Map<String, Value> = columns
        .map(|(name, values)| {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            (name.to_owned(), json!({ "values": add(&bytes) }))
        })
        .collect();
    let description = json!({
        "buffers": [{ "byteLength": binary.len() }],
        "bufferViews": views,
        "tileAvailability": tile_availability,
        "contentAvailability": [tile_availability],
        "childSubtreeAvailability": child_availability,
        "propertyTables": [{ "class": "tile", "count": tiles.count, "properties": columns }],
        "tileMetadata": 0,
    });
    let mut text = description.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(8), b' ');
    let lengths = [text.len() as u64, binary.len() as u64].map(u64::to_le_bytes);
    let head = [*b"subt", 1_u32.to_le_bytes()].concat();
    [head, lengths.concat(), text, binary].concat()
}
