//! `layer.json`: how CesiumJS and its kin learn what quantized-mesh tiles a server has. TileJSON 2.1 with the keys that
//! the format's readers look for.

use std::collections::HashSet;

use serde::Serialize;

use crate::address::{TileAddress, rows_of, standing_for};
use crate::metadata::Metadata;

/// The document, ready for JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerJson {
    tilejson: &'static str,
    name: String,
    version: String,
    format: &'static str,
    scheme: &'static str,
    projection: &'static str,
    tiles: [&'static str; 1],
    minzoom: u8,
    maxzoom: u8,
    bounds: [f64; 4],
    extensions: Vec<&'static str>,
    attribution: String,
    vertical: Vertical,
    available: Vec<Vec<Range>>,
}

/// What heights are above; no client asks for it yet, so that the names are ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
struct Vertical {
    source_datum: String,
    target_datum: String,
    transformation: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    grid: Option<String>,
}

/// A rectangle of tiles that exist, all four numbers inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
struct Range {
    start_x: u32,
    start_y: u32,
    end_x: u32,
    end_y: u32,
}

impl From<[u32; 4]> for Range {
    fn from([start_x, start_y, end_x, end_y]: [u32; 4]) -> Self {
        Self {
            start_x,
            start_y,
            end_x,
            end_y,
        }
    }
}

impl LayerJson {
    /// For the tiles of the archive that `metadata` describes. `version` changes whenever a tile does: it becomes part
    /// of every tile's address, so that caches may keep tiles as long as they like.
    #[must_use]
    pub fn new(name: &str, version: &str, metadata: &Metadata) -> Self {
        let uneven = tiles_of_uneven_depth(metadata);
        Self {
            tilejson: "2.1.0",
            name: name.to_owned(),
            version: version.to_owned(),
            format: "quantized-mesh-1.0",
            scheme: "tms",
            projection: "EPSG:4326",
            tiles: ["{z}/{x}/{y}.terrain?v={version}"],
            minzoom: 0,
            maxzoom: metadata.max_zoom,
            bounds: metadata.bounds_within_180(),
            extensions: extensions(metadata),
            attribution: metadata.source.attribution(),
            vertical: vertical(metadata),
            available: (0..=metadata.max_zoom)
                .map(|zoom| available(metadata, uneven.as_ref(), zoom))
                .collect(),
        }
    }
}

/// Clients ask for all that they know of these.
fn extensions(metadata: &Metadata) -> Vec<&'static str> {
    let water = (!metadata.water.is_empty()).then_some("watermask");
    ["octvertexnormals"].into_iter().chain(water).collect()
}

/// Both roots always exist, since every client starts from both: the one without data is the bare ellipsoid.
fn available(metadata: &Metadata, uneven: Option<&HashSet<TileAddress>>, zoom: u8) -> Vec<Range> {
    if zoom == 0 {
        return vec![Range::from([0, 0, 1, 0])];
    }
    let rectangles = rectangles(metadata, zoom).flat_map(|&rectangle| with_tiles_beside(zoom, rectangle));
    match uneven {
        Some(there) => without_those_below_leaves(there, zoom, rectangles),
        None => rectangles.map(Range::from).collect(),
    }
}

fn rectangles(metadata: &Metadata, zoom: u8) -> impl Iterator<Item = &[u32; 4]> {
    let here = metadata.zooms.iter().filter(move |entry| entry.zoom == zoom);
    here.flat_map(|entry| &entry.available)
}

fn tiles_in(zoom: u8, [start_x, start_y, end_x, end_y]: [u32; 4]) -> impl Iterator<Item = TileAddress> {
    let row = move |y| (start_x..=end_x).filter_map(move |x| TileAddress::new(zoom, x, y));
    (start_y..=end_y).flat_map(row)
}

/// All tiles of an archive that has leaves above its last zoom.
fn tiles_of_uneven_depth(metadata: &Metadata) -> Option<HashSet<TileAddress>> {
    let of_zoom = |zoom| rectangles(metadata, zoom).flat_map(move |&rectangle| tiles_in(zoom, rectangle));
    let all = || (0..=metadata.max_zoom).flat_map(of_zoom).collect();
    metadata.has_leaves_above().then(all)
}

/// What is beside data of some zoom is no bare ground where a leaf of a zoom above is: clients go on with that.
fn without_those_below_leaves(
    there: &HashSet<TileAddress>,
    zoom: u8,
    wanted: impl Iterator<Item = [u32; 4]>,
) -> Vec<Range> {
    let is_offered = |&address: &TileAddress| {
        let standing = standing_for(address, |address| there.contains(&address));
        standing.is_none_or(|standing| standing == address)
    };
    let offered = wanted
        .flat_map(|rectangle| tiles_in(zoom, rectangle))
        .filter(is_offered);
    rows_of(offered).into_iter().map(Range::from).collect()
}

/// A rectangle of tiles and those around it: what lies beside the data has to meet them where they end at a tile's side. Columns go on
/// past the antimeridian.
fn with_tiles_beside(zoom: u8, [start_x, start_y, end_x, end_y]: [u32; 4]) -> Vec<[u32; 4]> {
    let (columns, rows) = (2_u32 << zoom, 1_u32 << zoom);
    let (start_y, end_y) = (start_y.saturating_sub(1), (end_y + 1).min(rows - 1));
    let mut rectangles = vec![[start_x.saturating_sub(1), start_y, (end_x + 1).min(columns - 1), end_y]];
    let is_whole = start_x <= 1 && end_x + 2 >= columns;
    if start_x == 0 && !is_whole {
        rectangles.push([columns - 1, start_y, columns - 1, end_y]);
    }
    if end_x + 1 == columns && !is_whole {
        rectangles.push([0, start_y, 0, end_y]);
    }
    rectangles
}

fn vertical(Metadata { source, .. }: &Metadata) -> Vertical {
    Vertical {
        source_datum: source.vertical_datum.clone(),
        target_datum: source.tiles_above().to_owned(),
        transformation: source.vertical_transformation(),
        grid: source.geoid.clone(),
    }
}

#[cfg(test)]
#[path = "layer_json_tests.rs"]
mod tests;
