//! `layer.json`: how CesiumJS and its kin learn what quantized-mesh tiles a server has. TileJSON 2.1 with the keys that
//! the format's readers look for.

use std::collections::HashSet;

use serde::Serialize;
use terrain_codec::address::{MAX_ZOOM, TileAddress, rows_of, standing_for};

use crate::mercator;
use crate::metadata::Metadata;

/// How a client wants tiles to be told to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerForm {
    /// Where tiles are.
    pub projection: Projection,
    /// From which end rows are counted in addresses of tiles.
    pub rows: Rows,
    /// Where the client finds another layer, for what is beside this one's tiles; there are no tiles without data then.
    pub parent: Option<String>,
}

/// Where tiles are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Projection {
    /// Those of the archive: EPSG:4326, two roots.
    #[default]
    Geographic,
    /// EPSG:3857, one root. Zoom z + 1 has the columns of zoom z of the archive.
    WebMercator,
}

/// From which end rows of tiles are counted. `available` always counts from the south: that is what clients make of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Rows {
    /// As in the Tile Map Service.
    #[default]
    FromSouth,
    /// As maps in a browser do.
    FromNorth,
}

/// The name in documents, and in the query of a tile's address, of rows that are counted from the north.
pub const SLIPPY_MAP: &str = "slippyMap";

/// The document, ready for JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerJson {
    tilejson: &'static str,
    name: String,
    version: String,
    format: &'static str,
    scheme: &'static str,
    projection: &'static str,
    tiles: [String; 1],
    #[serde(rename = "parentUrl", skip_serializing_if = "Option::is_none")]
    parent: Option<String>,
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
    pub fn new(name: &str, version: &str, metadata: &Metadata, form: &LayerForm) -> Self {
        let uneven = tiles_of_uneven_depth(metadata);
        let of_zoom = |zoom| available(metadata, uneven.as_ref(), zoom, form.parent.is_some());
        let of_archive: Vec<Vec<Range>> = (0..=metadata.max_zoom).map(of_zoom).collect();
        let [west, south, east, north] = metadata.bounds_within_180();
        let in_projection = |latitude: f64| latitude.clamp(-mercator::LATITUDES, mercator::LATITUDES);
        let (projection, bounds, available) = match form.projection {
            Projection::Geographic => ("EPSG:4326", [west, south, east, north], of_archive),
            Projection::WebMercator => {
                let bounds = [west, in_projection(south), east, in_projection(north)];
                ("EPSG:3857", bounds, in_mercator(&of_archive))
            }
        };
        let (scheme, rows) = match form.rows {
            Rows::FromSouth => ("tms", String::new()),
            Rows::FromNorth => (SLIPPY_MAP, format!("&scheme={SLIPPY_MAP}")),
        };
        Self {
            tilejson: "2.1.0",
            name: name.to_owned(),
            version: version.to_owned(),
            format: "quantized-mesh-1.0",
            scheme,
            projection,
            tiles: [format!("{{z}}/{{x}}/{{y}}.terrain?v={{version}}{rows}")],
            parent: form.parent.clone(),
            minzoom: 0,
            maxzoom: available.len() as u8 - 1,
            bounds,
            extensions: extensions(metadata),
            attribution: metadata.source.attribution(),
            vertical: vertical(metadata),
            available,
        }
    }
}

/// Clients ask for all that they know of these.
fn extensions(metadata: &Metadata) -> Vec<&'static str> {
    let water = (!metadata.water.is_empty()).then_some("watermask");
    ["octvertexnormals"].into_iter().chain(water).collect()
}

/// Both roots always exist, since every client starts from both: the one without data is the bare ellipsoid. A client that has another layer
/// for what is beside the data is told of the data alone.
fn available(metadata: &Metadata, uneven: Option<&HashSet<TileAddress>>, zoom: u8, has_parent: bool) -> Vec<Range> {
    if has_parent {
        return rectangles(metadata, zoom).copied().map(Range::from).collect();
    }
    if zoom == 0 {
        return vec![Range::from([0, 0, 1, 0])];
    }
    let rectangles = rectangles(metadata, zoom).flat_map(|&rectangle| with_tiles_beside(zoom, rectangle));
    match uneven {
        Some(there) => without_those_below_leaves(there, zoom, rectangles),
        None => rectangles.map(Range::from).collect(),
    }
}

/// Tiles of Web Mercator over those of an archive: the root, then those of each zoom a zoom further down.
fn in_mercator(of_archive: &[Vec<Range>]) -> Vec<Vec<Range>> {
    let root = of_archive[0].first().map(|_| Range::from([0; 4]));
    let below = of_archive.iter().zip(0..MAX_ZOOM);
    let below = below.map(|(rectangles, zoom)| over_rectangles(rectangles, zoom));
    std::iter::once(root.into_iter().collect()).chain(below).collect()
}

/// Tiles of Web Mercator over rectangles of tiles of a zoom, which is one less than theirs.
fn over_rectangles(rectangles: &[Range], zoom: u8) -> Vec<Range> {
    let last = (2_u32 << zoom) - 1;
    let over = |x: u32, y: u32| {
        let address = TileAddress::new(zoom, x, y)?;
        let is_inside =
            address.south() < mercator::LATITUDES && address.south() + address.degrees() > -mercator::LATITUDES;
        is_inside.then(|| mercator::tiles_over(address, zoom + 1).map(|tile| last - tile.y))
    };
    let rows = |rectangle: &Range| {
        let rows = rectangle.start_y..=rectangle.end_y;
        let start_y = rows.clone().find_map(|y| over(rectangle.start_x, y))?.min()?;
        let end_y = rows.rev().find_map(|y| over(rectangle.start_x, y))?.max()?;
        Some(Range {
            start_y,
            end_y,
            ..*rectangle
        })
    };
    rectangles.iter().filter_map(rows).collect()
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
