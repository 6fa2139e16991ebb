//! Finished tiles: how the store keeps them, and how they become an archive.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use terrain_tiles::address::TileAddress;
use terrain_tiles::archive;
use terrain_tiles::formats::{LevelLimits, spt};
use terrain_tiles::metadata::{Metadata, Zoom};

use super::jobs::Child;
use crate::lattice::Square;
use crate::node::{Claims, Node};
use crate::store::{Name, Store};

/// What a finished tile claims, without its bytes.
#[derive(Clone, Debug)]
pub(crate) struct TileRecord {
    pub(crate) square: Square,
    pub(crate) name: Name,
    pub(crate) claims: Claims,
    /// What it took to make it.
    pub(crate) seconds: f64,
}

/// What stands in the store before a tile's bytes.
#[derive(Serialize, Deserialize)]
struct Head {
    #[serde(flatten)]
    claims: Claims,
    seconds: f64,
}

impl TileRecord {
    fn key(square: Square, name: Name) -> String {
        format!("tiles/{}-{}-{}-{name}", square.zoom, square.x, square.y)
    }

    /// The tile of such a name, if the store has it.
    pub(crate) fn find(store: &Store, square: Square, name: Name) -> Result<Option<Self>> {
        let Some(bytes) = store.get(&Self::key(square, name))? else {
            return Ok(None);
        };
        let (Head { claims, seconds }, _) = parted(&bytes).with_context(|| Self::key(square, name))?;
        Ok(Some(Self {
            square,
            name,
            claims,
            seconds,
        }))
    }

    /// Puts a tile into the store.
    pub(crate) fn keep(store: &Store, name: Name, node: Node, seconds: f64) -> Result<Self> {
        let Node { square, bytes, claims } = node;
        let head = Head { claims, seconds };
        let told = serde_json::to_vec(&head)?;
        let mut stored = (told.len() as u32).to_le_bytes().to_vec();
        stored.extend(told);
        stored.extend(bytes);
        store.put(&Self::key(square, name), stored)?;
        Ok(Self {
            square,
            name,
            claims: head.claims,
            seconds,
        })
    }

    /// The bytes of the tile.
    pub(crate) fn tile(&self, store: &Store) -> Result<Vec<u8>> {
        let key = Self::key(self.square, self.name);
        let mut bytes = store.expect(&key)?;
        let head = bytes.len() - parted(&bytes).with_context(|| key)?.1.len();
        Ok(bytes.split_off(head))
    }

    /// What the parent takes of the tile.
    pub(crate) fn coarsest(&self, store: &Store) -> Result<Child> {
        let bytes = self.tile(store)?;
        let tile = spt::decode(&bytes, &LevelLimits::default()).with_context(|| Self::key(self.square, self.name))?;
        Ok(Child {
            square: self.square,
            coarsest: tile.surface(tile.coarsest()),
            outline_strayed: self.claims.outline_strayed,
            coarsest_measured: self.claims.coarsest_measured,
        })
    }
}

/// Head and tile.
fn parted(bytes: &[u8]) -> Result<(Head, &[u8])> {
    let (length, rest) = bytes.split_first_chunk().context("is cut short")?;
    let length = u32::from_le_bytes(*length) as usize;
    ensure!(length <= rest.len(), "is cut short");
    let (head, tile) = rest.split_at(length);
    Ok((serde_json::from_slice(head)?, tile))
}

/// Writes the archive: all tiles in order, copied from the store one by one.
pub(crate) fn write_archive(
    store: &Store,
    records: &[TileRecord],
    metadata: &Metadata,
    output: &Path,
) -> Result<usize> {
    let mut total = 0;
    let tiles = records.iter().map(|record| (record.square.address(), record));
    archive::write(output, metadata, tiles, |record| {
        let bytes = record.tile(store)?;
        total += bytes.len();
        anyhow::Ok(bytes)
    })?;
    Ok(total)
}

/// What is said of each zoom.
pub(crate) fn zooms(records: &[TileRecord]) -> Vec<Zoom> {
    let mut by_zoom: BTreeMap<u8, Vec<&TileRecord>> = BTreeMap::new();
    for record in records {
        by_zoom.entry(record.square.zoom).or_default().push(record);
    }
    let zoom = |(zoom, records): (u8, Vec<&TileRecord>)| {
        let largest =
            |value: fn(&Claims) -> f64| records.iter().map(|record| value(&record.claims)).fold(0.0, f64::max);
        Zoom {
            zoom,
            tiles: records.len(),
            triangles: records.iter().map(|record| record.claims.triangles).sum(),
            finest_error: largest(|claims| claims.finest_error),
            coarsest_error: largest(|claims| claims.coarsest_error),
            outline_error: largest(|claims| claims.outline_error),
            available: rectangles(records.iter().map(|record| record.square.address())),
        }
    };
    by_zoom.into_iter().map(zoom).collect()
}

/// Lowest and highest vertex of all tiles, metres.
pub(crate) fn heights(records: &[TileRecord]) -> [f64; 2] {
    let all = records.iter().map(|record| record.claims.heights);
    all.reduce(|[low, high], [lowest, highest]| [low.min(lowest), high.max(highest)])
        .unwrap_or_default()
}

/// Rectangles (first x, first y, last x, last y) that the addresses of one zoom fill exactly.
fn rectangles(addresses: impl Iterator<Item = TileAddress>) -> Vec<[u32; 4]> {
    let mut rows: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for address in addresses {
        rows.entry(address.y).or_default().insert(address.x);
    }
    let mut found: Vec<[u32; 4]> = Vec::new();
    for (y, columns) in rows {
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for x in columns {
            match runs.last_mut() {
                Some(run) if run[1] + 1 == x => run[1] = x,
                _ => runs.push([x, x]),
            }
        }
        for [first, last] in runs {
            let above = found
                .iter_mut()
                .find(|r| r[0] == first && r[2] == last && r[3] + 1 == y);
            match above {
                Some(rectangle) => rectangle[3] = y,
                None => found.push([first, y, last, y]),
            }
        }
    }
    found
}
