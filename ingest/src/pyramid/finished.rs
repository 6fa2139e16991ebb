//! Finished tiles: where they are, and how they become an archive.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use terrain_codec::LevelLimits;
use terrain_codec::address::{TileAddress, rows_of};
use terrain_codec::spt::{self, Head};
use terrain_codec::tile::Tile;
use terrain_tiles::archive::{Reader, Writer};
use terrain_tiles::metadata::{Metadata, Zoom};

use super::family::Child;
use crate::lattice::Square;
use crate::outside::outline_of;
use crate::store::{Name, Store};

/// Tiles of a zoom that are looked at to know where the surface ends.
const FEW: usize = 64;

/// A finished tile.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TileRecord {
    pub(crate) square: Square,
    pub(crate) name: Name,
    pub(crate) origin: Origin,
}

/// Where a finished tile comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Origin {
    /// It was made just now, in so many seconds.
    Made(f64),
    /// The store had it.
    Store,
    /// The archive that is updated had it.
    Archive,
}

/// A subtree in the store.
#[derive(Serialize, Deserialize)]
struct Subtree {
    /// Zoom, column, row and name of each tile.
    tiles: Vec<(u8, i64, i64, String)>,
}

/// All finished tiles.
pub(crate) struct FinishedTiles<'a> {
    pub(crate) store: &'a Store,
    /// An archive with tiles that may be good still.
    pub(crate) archive: Option<&'a Reader>,
}

impl FinishedTiles<'_> {
    /// The tile of such a name, if there is one.
    pub(crate) fn find(&self, square: Square, name: Name) -> Result<Option<TileRecord>> {
        let origin = if self.is_in_archive(square, name)? {
            Origin::Archive
        } else if self.store.has(&tile_key(square, name))? {
            Origin::Store
        } else {
            return Ok(None);
        };
        Ok(Some(TileRecord { square, name, origin }))
    }

    fn is_in_archive(&self, square: Square, name: Name) -> Result<bool> {
        let Some(archive) = self.archive else { return Ok(false) };
        let Some(bytes) = archive.tile(square.address())? else {
            return Ok(false);
        };
        let head = head(square.address(), &bytes)?;
        Ok(head.lineage.name == name.0)
    }

    /// Gives a tile its name and puts it into the store.
    pub(crate) fn keep(&self, square: Square, name: Name, mut tile: Tile, seconds: f64) -> Result<TileRecord> {
        tile.lineage.name = name.0;
        let bytes = spt::encode(&tile).with_context(|| format!("tile {}", square.address()))?;
        self.store.put(&tile_key(square, name), bytes)?;
        let origin = Origin::Made(seconds);
        Ok(TileRecord { square, name, origin })
    }

    /// The bytes of a tile.
    pub(crate) fn bytes(&self, record: &TileRecord) -> Result<Vec<u8>> {
        let address = record.square.address();
        match (record.origin, self.archive) {
            (Origin::Archive, Some(archive)) => archive
                .tile(address)?
                .with_context(|| format!("tile {address} is no longer in the archive")),
            _ => self.store.expect(&tile_key(record.square, record.name)),
        }
    }

    fn decoded(&self, record: &TileRecord) -> Result<Tile> {
        let decoded = spt::decode(&self.bytes(record)?, &LevelLimits::default());
        decoded.with_context(|| format!("tile {}", record.square.address()))
    }

    /// What the parent takes of a tile.
    pub(crate) fn coarsest(&self, record: &TileRecord) -> Result<Child> {
        let tile = self.decoded(record)?;
        Ok(Child::of(record.square, &tile))
    }

    /// The tiles of a subtree of such a name, if it was finished. Where an archive is updated, each tile is asked for.
    pub(crate) fn subtree(&self, square: Square, name: Name) -> Result<Option<Vec<TileRecord>>> {
        if self.archive.is_some() {
            return Ok(None);
        }
        let key = subtree_key(square, name);
        let Some(bytes) = self.store.get(&key)? else {
            return Ok(None);
        };
        let damaged = || format!("{key} is damaged");
        let subtree: Subtree = serde_json::from_slice(&bytes).with_context(damaged)?;
        let record = |(zoom, x, y, name): (u8, i64, i64, String)| {
            let name = Name::parse(&name).with_context(damaged)?;
            let square = Square { zoom, x, y };
            let origin = Origin::Store;
            Ok(TileRecord { square, name, origin })
        };
        subtree.tiles.into_iter().map(record).collect::<Result<_>>().map(Some)
    }

    /// Whether a subtree of such a name was finished.
    pub(crate) fn has_subtree(&self, square: Square, name: Name) -> Result<bool> {
        self.store.has(&subtree_key(square, name))
    }

    /// Notes that a subtree is finished. Where tiles are elsewhere than in the store, it is not noted.
    pub(crate) fn keep_subtree(&self, square: Square, name: Name, records: &[TileRecord]) -> Result<()> {
        if records.iter().any(|record| record.origin == Origin::Archive) {
            return Ok(());
        }
        let tile = |record: &TileRecord| {
            let Square { zoom, x, y } = record.square;
            (zoom, x, y, record.name.to_string())
        };
        let subtree = Subtree {
            tiles: records.iter().map(tile).collect(),
        };
        self.store
            .put(&subtree_key(square, name), serde_json::to_vec(&subtree)?)
    }

    /// Longitudes, latitudes and heights at which the surface ends, from the finest zoom that has few tiles.
    pub(crate) fn outline(&self, records: &[TileRecord]) -> Result<Vec<DVec3>> {
        let mut of_zoom: BTreeMap<u8, Vec<&TileRecord>> = BTreeMap::new();
        for record in records {
            of_zoom.entry(record.square.zoom).or_default().push(record);
        }
        let few = of_zoom.into_values().take_while(|tiles| tiles.len() <= FEW);
        let mut tiles = few.last().unwrap_or_default();
        tiles.sort_by_key(|record| record.square);
        let outlines = tiles.into_iter().map(|record| Ok(outline_of(&self.decoded(record)?)));
        let outlines = outlines.collect::<Result<Vec<_>>>()?;
        Ok(outlines.concat())
    }

    /// Writes the archive: all tiles in order, one by one. What is said of them all is made of what they say.
    pub(crate) fn write_archive(
        &self,
        records: &mut [TileRecord],
        output: &Path,
        metadata: impl FnOnce(&Summary) -> Metadata,
    ) -> Result<(Metadata, Summary)> {
        records.sort_by_key(|record| record.square);
        let mut writer = Writer::create(output)?;
        let mut summary = Summary::default();
        for record in records.iter() {
            let bytes = self.bytes(record)?;
            let address = record.square.address();
            let head = head(address, &bytes)?;
            ensure!(
                head.lineage.name == record.name.0,
                "tile {address} in {} is another than was finished",
                self.store.location()
            );
            summary.add(&head, bytes.len());
            writer.add(address, &bytes)?;
        }
        let metadata = metadata(&summary);
        writer.finish(&metadata)?;
        Ok((metadata, summary))
    }
}

fn tile_key(square: Square, name: Name) -> String {
    format!("tiles/{}-{}-{}-{name}", square.zoom, square.x, square.y)
}

fn subtree_key(square: Square, name: Name) -> String {
    format!("subtrees/{}-{}-{}-{name}.json", square.zoom, square.x, square.y)
}

fn head(address: TileAddress, bytes: &[u8]) -> Result<Head> {
    spt::decode_head(bytes, &LevelLimits::default()).with_context(|| format!("tile {address}"))
}

/// What is said of all tiles.
pub(crate) struct Summary {
    zooms: BTreeMap<u8, OfZoom>,
    /// Lowest and highest vertex, metres.
    pub(crate) heights: [f64; 2],
    pub(crate) tile_bytes: usize,
}

/// What is said of the tiles of one zoom.
#[derive(Default)]
struct OfZoom {
    triangles: usize,
    /// Largest error of finest and coarsest surfaces, metres.
    errors: [f64; 2],
    outline_error: f64,
    /// Each tile and the error of its finest surface, metres.
    tiles: Vec<(TileAddress, f64)>,
}

impl Default for Summary {
    fn default() -> Self {
        Self {
            zooms: BTreeMap::new(),
            heights: [f64::INFINITY, f64::NEG_INFINITY],
            tile_bytes: 0,
        }
    }
}

impl Summary {
    fn add(&mut self, head: &Head, bytes: usize) {
        self.tile_bytes += bytes;
        let ([low, high], [lowest, highest]) = (self.heights, head.heights);
        self.heights = [low.min(lowest), high.max(highest)];
        let zoom = self.zooms.entry(head.address.zoom).or_default();
        zoom.triangles += head.triangles;
        zoom.errors = [0, 1].map(|of| zoom.errors[of].max(head.errors[of]));
        zoom.outline_error = zoom.outline_error.max(head.outline_error);
        zoom.tiles.push((head.address, head.errors[0]));
    }

    /// Tiles without children, and the error of their finest surfaces, metres.
    pub(crate) fn leaves(&self) -> Vec<(TileAddress, f64)> {
        let tiles = || self.zooms.values().flat_map(|zoom| &zoom.tiles);
        let parents: HashSet<TileAddress> = tiles().filter_map(|(address, _)| address.parent()).collect();
        let is_leaf = |(address, _): &&(TileAddress, f64)| !parents.contains(address);
        tiles().filter(is_leaf).copied().collect()
    }

    /// What is said of each zoom.
    pub(crate) fn zooms(&self) -> Vec<Zoom> {
        let mut leaves: BTreeMap<u8, Vec<f64>> = BTreeMap::new();
        for (address, error) in self.leaves() {
            leaves.entry(address.zoom).or_default().push(error);
        }
        let leaves = |zoom: u8| leaves.get(&zoom).map_or(&[][..], Vec::as_slice);
        let said = |(&zoom, of_zoom): (&u8, &OfZoom)| Zoom {
            zoom,
            tiles: of_zoom.tiles.len(),
            triangles: of_zoom.triangles,
            finest_error: of_zoom.errors[0],
            coarsest_error: of_zoom.errors[1],
            outline_error: of_zoom.outline_error,
            leaves: leaves(zoom).len(),
            leaf_error: leaves(zoom).iter().copied().fold(0.0, f64::max),
            available: rectangles(of_zoom.tiles.iter().map(|&(address, _)| address)),
        };
        self.zooms.iter().map(said).collect()
    }
}

/// Rectangles (first x, first y, last x, last y) that the addresses of one zoom fill exactly.
fn rectangles(addresses: impl Iterator<Item = TileAddress>) -> Vec<[u32; 4]> {
    let mut found: Vec<[u32; 4]> = Vec::new();
    for [first, y, last, _] in rows_of(addresses) {
        let above = found
            .iter_mut()
            .find(|r| r[0] == first && r[2] == last && r[3] + 1 == y);
        match above {
            Some(rectangle) => rectangle[3] = y,
            None => found.push([first, y, last, y]),
        }
    }
    found
}
