//! Packs: an archive's tiles as files that other programs read without a server.
//!
//! ```text
//! archive ─▶ choose tiles: those above max_zoom that meet bbox, and both roots
//!         ─▶ each tile, with those around it for its normals ─▶ its file, as the server would send it
//!         ─▶ a document that names exactly these
//! ```

mod folder;
mod mbtiles;
pub mod simulator;
mod stored;
mod three_tz;
mod unusable;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;
use terrain_tiles::address::TileAddress;
use terrain_tiles::archive::Reader;
use terrain_tiles::formats::quantized_mesh::{self, Extensions, QuantizedMesh};
use terrain_tiles::formats::three_d_tiles::{self, DOCUMENT_ZOOMS, Described, Packing, TileSurface};
use terrain_tiles::layer_json::LayerJson;
use terrain_tiles::metadata::{Metadata, Zoom};

use self::folder::Folder;
pub use self::unusable::Unusable;

/// What files a pack is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    /// `layer.json` and `z/x/y.terrain`: quantized-mesh with normals.
    QuantizedMesh,
    /// `tileset.json`, `z/x/y.json` and `z/x/y.glb`: the explicit tileset of 3D Tiles.
    ThreeDTiles,
    /// The files of `QuantizedMesh` in one database, MBTiles.
    QuantizedMeshDatabase,
    /// The files of `ThreeDTiles` in one, a 3D Tiles archive.
    ThreeDTilesArchive,
    /// Meshes, heightmaps and worlds in a local frame, of the finest zoom alone.
    Simulator(simulator::Options),
}

/// Which tiles go into a pack.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Choice {
    /// West, south, east, north in degrees that they must meet; east may exceed 180.
    pub bbox: Option<[f64; 4]>,
    /// The finest zoom.
    pub max_zoom: Option<u8>,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Report {
    /// Tiles of the pack.
    pub tiles: usize,
    /// Files, documents included.
    pub files: usize,
    /// Bytes of all files.
    pub bytes: u64,
}

/// Writes the `chosen` tiles of `archive` as the folder or file `output`, which must not be there yet, and is there when it is whole.
///
/// # Errors
/// Where the archive cannot be read, or the output not be written; [`Unusable`] where the archive does not have what is asked for.
pub fn write(
    archive: &Reader,
    format: Format,
    chosen: &BTreeSet<TileAddress>,
    output: &Path,
) -> anyhow::Result<Report> {
    let parent = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    let parent = parent.unwrap_or(Path::new("."));
    let part = tempfile::Builder::new().prefix(".pack-").tempdir_in(parent);
    let part = part.with_context(|| parent.display().to_string())?;
    let pack = Pack {
        archive,
        chosen,
        folder: Folder::new(part.path().join("whole")),
    };
    let tiles = match format {
        Format::QuantizedMesh | Format::QuantizedMeshDatabase => pack.quantized_mesh(),
        Format::ThreeDTiles | Format::ThreeDTilesArchive => pack.three_d_tiles(),
        Format::Simulator(options) => simulator::write(archive, chosen, options, &pack.folder),
    }?;
    let written = pack.folder.written();
    let (folder, file) = (pack.folder.path(), part.path().join("file"));
    let (whole, files, bytes) = match format {
        Format::QuantizedMeshDatabase => {
            mbtiles::write(folder, pack.with_roots().into_iter(), &pack.metadata(), &file)?;
            (&*file, 1, fs::metadata(&file)?.len())
        }
        Format::ThreeDTilesArchive => {
            three_tz::write(folder, written.keys().map(String::as_str), &file)?;
            (&*file, 1, fs::metadata(&file)?.len())
        }
        _ => (folder, written.len(), written.values().map(|file| file.bytes).sum()),
    };
    fs::rename(whole, output).with_context(|| output.display().to_string())?;
    Ok(Report { tiles, files, bytes })
}

impl Choice {
    /// The tiles of `archive` that it means.
    #[must_use]
    pub fn tiles(&self, archive: &Reader) -> BTreeSet<TileAddress> {
        let is_chosen = |address: &TileAddress| {
            self.max_zoom.is_none_or(|zoom| address.zoom <= zoom) && self.bbox.is_none_or(|bbox| meets(*address, bbox))
        };
        archive.addresses().filter(is_chosen).collect()
    }
}

/// Whether a tile's square meets a box by more than its side.
fn meets(address: TileAddress, [west, south, east, north]: [f64; 4]) -> bool {
    let (near, low, side) = (address.west(), address.south(), address.degrees());
    let is_across = [-360.0, 0.0, 360.0]
        .iter()
        .any(|turn| near + turn < east && near + turn + side > west);
    is_across && low < north && low + side > south
}

/// A pack while it is written.
struct Pack<'a> {
    archive: &'a Reader,
    chosen: &'a BTreeSet<TileAddress>,
    folder: Folder,
}

impl Pack<'_> {
    /// The chosen tiles and both roots, from which clients start.
    fn with_roots(&self) -> BTreeSet<TileAddress> {
        let roots = [0, 1].map(|x| TileAddress { zoom: 0, x, y: 0 });
        self.chosen.iter().copied().chain(roots).collect()
    }

    /// Gives how many tiles there are.
    fn quantized_mesh(&self) -> anyhow::Result<usize> {
        let Metadata { outside, water, .. } = self.archive.metadata();
        let extensions = Extensions {
            normals: true,
            water_mask: true,
            measured_triangles: false,
        };
        self.with_roots().into_par_iter().try_for_each(|address| {
            let mut mesh = if self.chosen.contains(&address) {
                QuantizedMesh::from_tile(
                    &stored::tile(self.archive, address)?,
                    &stored::tiles_around(self.archive, address)?,
                    outside,
                )
            } else {
                QuantizedMesh::unmeasured(address, &[], outside)
            };
            mesh.water_mask = (!water.is_empty()).then(|| water.mask(address));
            self.folder.write(
                &format!("{address}.terrain"),
                &quantized_mesh::encode(&mesh, extensions),
            )
        })?;
        let name = self.archive.metadata().source.files.join(", ");
        let layer = LayerJson::new(&name, &format!("{:032x}", self.archive.version()), &self.metadata());
        self.folder.write("layer.json", &serde_json::to_vec(&layer)?)?;
        Ok(self.chosen.len())
    }

    /// Gives how many tiles there are.
    fn three_d_tiles(&self) -> anyhow::Result<usize> {
        self.chosen.par_iter().try_for_each(|&address| {
            let surface = TileSurface::measured(
                &stored::tile(self.archive, address)?,
                &stored::tiles_around(self.archive, address)?,
            );
            let file = three_d_tiles::file(&surface, Packing::Plain, self.archive.metadata());
            self.folder.write(
                &format!("{address}.glb"),
                &file.with_context(|| format!("tile {address} is empty"))?,
            )
        })?;
        self.write_document("tileset.json", None)?;
        let is_root = |address: &&TileAddress| address.zoom > 0 && address.zoom.is_multiple_of(DOCUMENT_ZOOMS);
        let roots = self.chosen.iter().filter(is_root);
        roots
            .copied()
            .try_for_each(|address| self.write_document(&format!("{address}.json"), Some(address)))?;
        Ok(self.chosen.len())
    }

    fn write_document(&self, path: &str, root: Option<TileAddress>) -> anyhow::Result<()> {
        let describe = |address| self.describe(address);
        let document = three_d_tiles::document(root, None, self.archive.metadata(), &describe)?;
        let document = document.with_context(|| format!("{path} has no tile"))?;
        self.folder.write(path, document.to_string().as_bytes())
    }

    fn describe(&self, address: TileAddress) -> anyhow::Result<Option<Described>> {
        if !self.chosen.contains(&address) {
            return Ok(None);
        }
        Ok(Some(Described::of_stored(&stored::bytes(self.archive, address)?)?))
    }

    /// What the archive says of itself, of the chosen tiles alone.
    fn metadata(&self) -> Metadata {
        let whole = self.archive.metadata();
        let max_zoom = self.chosen.iter().map(|address| address.zoom).max().unwrap_or(0);
        let of_zoom = |zoom: &Zoom| Zoom {
            available: rectangles(self.chosen, zoom.zoom),
            ..zoom.clone()
        };
        let zooms = whole.zooms.iter().filter(|zoom| zoom.zoom <= max_zoom);
        Metadata {
            max_zoom,
            zooms: zooms.map(of_zoom).collect(),
            ..whole.clone()
        }
    }
}

/// The tiles of a zoom as rectangles of one row each.
fn rectangles(chosen: &BTreeSet<TileAddress>, zoom: u8) -> Vec<[u32; 4]> {
    let mut rows: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for address in chosen.iter().filter(|address| address.zoom == zoom) {
        rows.entry(address.y).or_default().push(address.x);
    }
    let runs = |(y, columns): (u32, Vec<u32>)| {
        let runs = columns.chunk_by(|one, next| one + 1 == *next);
        runs.map(|run| [run[0], y, run[run.len() - 1], y]).collect::<Vec<_>>()
    };
    rows.into_iter().flat_map(runs).collect()
}
