//! Packs: an archive's tiles as files that other programs read without a server.
//!
//! ```text
//! archive ─▶ choose tiles: by place, zoom and error; and both roots
//!         ─▶ each tile, with those around it for its normals ─▶ its file, as the server would send it
//!         ─▶ a document that names exactly these
//! ```

mod ardupilot;
mod area;
mod choice;
mod coverage;
mod difference;
pub mod flightgear;
mod folder;
mod mbtiles;
mod mesh_tiles;
mod rasters;
mod sea_level;
pub mod simulator;
mod stored;
mod three_tz;
mod unusable;
mod whole;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;
use terrain_codec::address::{TileAddress, is_leaf, rows_of, standing_for};
use terrain_tiles::archive::{Reader, tile_id};
use terrain_tiles::formats::quantized_mesh::{self, Extensions, QuantizedMesh};
use terrain_tiles::formats::three_d_tiles::{self, DOCUMENT_ZOOMS, Described, Packing, TileSurface};
use terrain_tiles::layer_json::{LayerForm, LayerJson};
use terrain_tiles::metadata::{Metadata, Zoom};
use terrain_tiles::raster_dem::RasterForm;

pub use self::area::Area;
pub use self::choice::Choice;
pub use self::difference::{Difference, apply};
use self::folder::{Folder, sizes};
use self::sea_level::AboveSea;
use self::stored::Surfaces;
pub use self::unusable::Unusable;
use self::whole::write_whole;
use crate::archive_tiles;

/// What files a pack is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Format {
    /// `layer.json` and `z/x/y.terrain`: quantized-mesh with normals.
    QuantizedMesh,
    /// `tileset.json`, `z/x/y.json` and `z/x/y.glb`: the explicit tileset of 3D Tiles.
    ThreeDTiles(Packing),
    /// The files of `QuantizedMesh` in one database, MBTiles.
    QuantizedMeshDatabase,
    /// The files of `QuantizedMesh` in one, PMTiles.
    QuantizedMeshFile,
    /// The files of `ThreeDTiles` in one, a 3D Tiles archive.
    ThreeDTilesArchive(Packing),
    /// Raster tiles of heights in one file, PMTiles.
    Rasters(RasterForm),
    /// Meshes, heightmaps and worlds in a local frame, of the finest zoom alone.
    Simulator(simulator::Options),
    /// Files of heights above the sea for ArduPilot's card.
    ArduPilot {
        /// Metres from post to post.
        spacing: Option<f64>,
        /// Grid of the geoid that heights above the ellipsoid become heights above; EGM96 if not given.
        geoid: Option<String>,
    },
    /// Triangles above the sea in FlightGear's buckets.
    FlightGear {
        /// What ground is made of, by FlightGear's names; where there is water it is a lake.
        material: String,
        /// As for `ArduPilot`.
        geoid: Option<String>,
    },
    /// A raster of longitudes and latitudes in one file, GeoPackage.
    GeoPackage {
        /// Metres from pixel to pixel.
        spacing: Option<f64>,
    },
}

impl Format {
    fn is_one_file(&self) -> bool {
        use Format::{ArduPilot, FlightGear, QuantizedMesh, Simulator, ThreeDTiles};
        !matches!(
            self,
            ArduPilot { .. } | FlightGear { .. } | QuantizedMesh | ThreeDTiles(_) | Simulator(_)
        )
    }
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
    /// How it differs from an older pack, where that alone was written.
    #[serde(flatten)]
    pub difference: Option<Difference>,
    /// What the person has to know.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

/// Writes the part of `archive` that `choice` means as the folder or file `output`, which must not be there yet, and is there when it
/// is whole; of `since`, an older pack, the difference alone, a folder from which [`apply`] makes the pack.
///
/// # Errors
/// Where the archive cannot be read, or the output not be written; [`Unusable`] where the archive does not have what is asked for.
pub fn write(
    archive: &Reader,
    format: &Format,
    choice: &Choice,
    since: Option<&Path>,
    output: &Path,
) -> anyhow::Result<Report> {
    if let Some(old) = since {
        let is_usable = if format.is_one_file() {
            old.is_file()
        } else {
            old.is_dir()
        };
        let kind = if format.is_one_file() { "file" } else { "folder" };
        if !is_usable {
            return Err(Unusable(format!("--since {}: the older pack is no {kind}", old.display())).into());
        }
    }
    write_whole(output, |part| {
        let (whole, report) = write_in(part, archive, format, choice)?;
        match since {
            Some(old) => only_difference(old, &whole, &part.join("difference"), report),
            None => Ok((whole, report)),
        }
    })
}

fn only_difference(old: &Path, whole: &Path, output: &Path, report: Report) -> anyhow::Result<(PathBuf, Report)> {
    let write = if whole.is_dir() {
        difference::write
    } else {
        difference::write_of_file
    };
    let difference = write(old, whole, output)?;
    let written = sizes(output)?;
    let report = Report {
        files: written.len(),
        bytes: written.values().sum(),
        difference: Some(difference),
        ..report
    };
    Ok((output.to_owned(), report))
}

/// Writes it in a folder of its own. Gives where it is.
fn write_in(part: &Path, archive: &Reader, format: &Format, choice: &Choice) -> anyhow::Result<(PathBuf, Report)> {
    let pack = || Pack::new(archive, choice, part.join("whole"));
    let file = part.join("file");
    match format {
        Format::Rasters(form) => {
            let tiles = rasters::write(archive, *form, choice, &file)?;
            one_file(file, tiles)
        }
        Format::QuantizedMesh => pack()?.quantized_mesh()?.as_folder(),
        Format::QuantizedMeshDatabase | Format::QuantizedMeshFile => {
            let pack = pack()?.quantized_mesh()?;
            let (folder, addresses) = (pack.folder.path(), pack.with_ground().into_iter());
            if *format == Format::QuantizedMeshDatabase {
                mbtiles::write(folder, addresses, &pack.metadata(), &file)?;
            } else {
                mesh_tiles::write(folder, addresses, &pack.metadata(), &file)?;
            }
            one_file(file, pack.chosen.len())
        }
        Format::ThreeDTiles(packing) => pack()?.three_d_tiles(*packing)?.as_folder(),
        Format::ThreeDTilesArchive(packing) => {
            let pack = pack()?.three_d_tiles(*packing)?;
            let written = sizes(pack.folder.path())?;
            three_tz::write(pack.folder.path(), written.keys().map(String::as_str), &file)?;
            one_file(file, pack.chosen.len())
        }
        Format::Simulator(options) => {
            let mut pack = pack()?;
            pack.chosen = finest(&pack.chosen);
            simulator::write(archive, &pack.chosen, choice, *options, &pack.folder)?;
            pack.as_folder()
        }
        Format::ArduPilot { spacing, geoid } => {
            let folder = Folder::new(part.join("whole"));
            let sea = AboveSea::of(archive.metadata(), "--format ardupilot", geoid.as_deref())?;
            let blocks = ardupilot::write(archive, choice, *spacing, &sea, &folder)?;
            many_files(&folder, blocks, sea.remark())
        }
        Format::FlightGear { material, geoid } => {
            let pack = pack()?;
            let sea = AboveSea::of(archive.metadata(), "--format btg", geoid.as_deref())?;
            let buckets = flightgear::write(archive, &finest(&pack.chosen), choice, material, &sea, &pack.folder)?;
            many_files(&pack.folder, buckets, sea.remark())
        }
        Format::GeoPackage { spacing } => {
            let tiles = coverage::write(archive, choice, *spacing, &file)?;
            one_file(file, tiles)
        }
    }
}

/// Those that none of the others is below.
fn finest(tiles: &BTreeSet<TileAddress>) -> BTreeSet<TileAddress> {
    let has_none_below = |&address: &TileAddress| is_leaf(address, |child| tiles.contains(&child));
    tiles.iter().copied().filter(has_none_below).collect()
}

fn one_file(file: PathBuf, tiles: usize) -> anyhow::Result<(PathBuf, Report)> {
    let bytes = fs::metadata(&file)?.len();
    let report = Report {
        tiles,
        files: 1,
        bytes,
        difference: None,
        remark: None,
    };
    Ok((file, report))
}

fn many_files(folder: &Folder, tiles: usize, remark: Option<String>) -> anyhow::Result<(PathBuf, Report)> {
    let written = sizes(folder.path())?;
    let report = Report {
        tiles,
        files: written.len(),
        bytes: written.values().sum(),
        difference: None,
        remark,
    };
    Ok((folder.path().to_owned(), report))
}

/// The tiles of the archive that are meant.
fn chosen(archive: &Reader, choice: &Choice) -> Result<BTreeSet<TileAddress>, Unusable> {
    let metadata = archive.metadata();
    // Coarse tiles reach far beyond what they have.
    choice.bounds(metadata.bounds)?;
    let finest = choice.finest_zoom(metadata.max_zoom, |zoom| metadata.finest_error(zoom))?;
    let mut chosen = choice.tiles(archive);
    chosen.retain(|address| address.zoom <= finest);
    if chosen.is_empty() {
        return Err(Unusable("the archive has no tile there".to_owned()));
    }
    Ok(chosen)
}

/// A pack while it is written.
struct Pack<'a> {
    archive: &'a Reader,
    chosen: BTreeSet<TileAddress>,
    folder: Folder,
}

impl<'a> Pack<'a> {
    fn new(archive: &'a Reader, choice: &Choice, folder: PathBuf) -> Result<Self, Unusable> {
        Ok(Self {
            archive,
            chosen: chosen(archive, choice)?,
            folder: Folder::new(folder),
        })
    }

    fn as_folder(&self) -> anyhow::Result<(PathBuf, Report)> {
        many_files(&self.folder, self.chosen.len(), None)
    }

    /// The chosen tiles, both roots, from which clients start, and what is beside them, where the data may end at a tile's side.
    fn with_ground(&self) -> BTreeSet<TileAddress> {
        let roots = [0, 1].map(|x| TileAddress { zoom: 0, x, y: 0 });
        let around = self.chosen.iter().flat_map(|address| address.around());
        let is_below_leaf = |address: TileAddress| {
            let standing = standing_for(address, |address| self.chosen.contains(&address));
            standing.is_some_and(|standing| standing != address)
        };
        let around = around.filter(|&address| !is_below_leaf(address));
        self.chosen.iter().copied().chain(roots).chain(around).collect()
    }

    fn quantized_mesh(self) -> anyhow::Result<Self> {
        let Metadata { outside, water, .. } = self.archive.metadata();
        let extensions = Extensions {
            normals: true,
            water_mask: true,
            measured_triangles: false,
        };
        let surfaces = Surfaces::of(self.archive);
        along_curve(&self.with_ground())
            .into_par_iter()
            .try_for_each(|address| {
                let surface = |address| surfaces.at(address);
                let mut mesh = match surface(address)? {
                    Some(own) => QuantizedMesh::from_tile(&own, surface, outside)?,
                    None => QuantizedMesh::unmeasured(address, surface, outside)?,
                };
                mesh.water_mask = (!water.is_empty()).then(|| water.mask(address));
                self.folder.write(
                    &format!("{address}.terrain"),
                    &quantized_mesh::encode(&mesh, extensions),
                )
            })?;
        let name = self.archive.metadata().source.files.join(", ");
        let layer = LayerJson::new(
            &name,
            &format!("{:032x}", self.archive.version()),
            &self.metadata(),
            &LayerForm::default(),
        );
        self.folder.write("layer.json", &serde_json::to_vec(&layer)?)?;
        Ok(self)
    }

    fn three_d_tiles(self, packing: Packing) -> anyhow::Result<Self> {
        let surfaces = Surfaces::of(self.archive);
        along_curve(&self.chosen).into_par_iter().try_for_each(|address| {
            let surface = surfaces
                .at(address)?
                .with_context(|| format!("tile {address} is not there"))?;
            let surface = TileSurface::measured(&surface, packing);
            let file = three_d_tiles::file(&surface, packing, self.archive.metadata());
            self.folder.write(
                &format!("{address}.glb"),
                &file.with_context(|| format!("tile {address} is empty"))?,
            )
        })?;
        self.write_document("tileset.json", None, packing)?;
        let is_root = |address: &&TileAddress| address.zoom > 0 && address.zoom.is_multiple_of(DOCUMENT_ZOOMS);
        let roots = self.chosen.iter().filter(is_root);
        roots
            .copied()
            .try_for_each(|address| self.write_document(&format!("{address}.json"), Some(address), packing))?;
        Ok(self)
    }

    fn write_document(&self, path: &str, root: Option<TileAddress>, packing: Packing) -> anyhow::Result<()> {
        let describe = |address| self.describe(address);
        let document = three_d_tiles::document(root, packing, "", self.archive.metadata(), &describe)?;
        let document = document.with_context(|| format!("{path} has no tile"))?;
        self.folder.write(path, document.to_string().as_bytes())
    }

    fn describe(&self, address: TileAddress) -> anyhow::Result<Option<Described>> {
        if !self.chosen.contains(&address) {
            return Ok(None);
        }
        Ok(Some(Described::of_stored(&archive_tiles::bytes(
            self.archive,
            address,
        )?)?))
    }

    /// What the archive says of itself, of the chosen tiles alone.
    fn metadata(&self) -> Metadata {
        let whole = self.archive.metadata();
        let max_zoom = self.chosen.iter().map(|address| address.zoom).max().unwrap_or(0);
        let leaves = finest(&self.chosen);
        let of_zoom = |zoom: &Zoom| Zoom {
            leaves: tiles_of(&leaves, zoom.zoom).count(),
            leaf_error: if zoom.zoom == max_zoom {
                zoom.finest_error
            } else {
                zoom.leaf_error
            },
            available: rows_of(tiles_of(&self.chosen, zoom.zoom)),
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

/// In an order in which tiles that share much of their surroundings mostly follow each other.
fn along_curve(tiles: &BTreeSet<TileAddress>) -> Vec<TileAddress> {
    let mut tiles: Vec<TileAddress> = tiles.iter().copied().collect();
    tiles.sort_by_cached_key(|&address| tile_id(address));
    tiles
}

fn tiles_of(tiles: &BTreeSet<TileAddress>, zoom: u8) -> impl Iterator<Item = TileAddress> {
    tiles.iter().copied().filter(move |tile| tile.zoom == zoom)
}
