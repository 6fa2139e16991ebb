//! What a pack for simulators says of itself.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3, UVec2};
use serde::Serialize;
use terrain_tiles::metadata::Metadata;

use super::super::folder::Sum;
use super::frame::Frame;
use super::heightmaps::{Heightmap, Heightmaps};
use super::pieces::{Pieces, Record};

/// `manifest.json`.
#[derive(Serialize)]
pub(super) struct Manifest {
    generator: String,
    source: SourceFiles,
    frame: FrameInWords,
    surface: Surface,
    meshes: Meshes,
    heightmaps: HeightmapsInWords,
    /// By their paths.
    files: BTreeMap<String, Sum>,
}

#[derive(Serialize)]
struct SourceFiles {
    files: Vec<String>,
    crs: String,
    /// Hash of the archive.
    archive: String,
}

#[derive(Serialize)]
struct FrameInWords {
    kind: &'static str,
    units: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    ellipsoid: Option<&'static str>,
    origin: Origin,
    /// What the source calls heights; the frame takes them as above the ellipsoid.
    heights_above: String,
    vertical_transformation: String,
    largest_tilt_degrees: f64,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Origin {
    /// Degrees, and metres.
    OnEarth { longitude: f64, latitude: f64, height: f64 },
    /// Metres.
    OnPlane { x: f64, y: f64, height: f64 },
}

/// Metres, all of them.
#[derive(Serialize)]
struct Surface {
    zoom: u8,
    /// Along the ellipsoid's normal, from the source to the tiles.
    certified_error: f64,
    /// Where that is bounded.
    bound: String,
    /// Up for a metre across.
    steepest: f64,
}

#[derive(Serialize)]
struct Meshes {
    /// Coordinates are whole numbers of these.
    step: f64,
    rounding_error: f64,
    /// From the source, all in all.
    error: f64,
    tiles: Vec<MeshInWords>,
}

#[derive(Serialize)]
struct MeshInWords {
    path: String,
    offset: [f64; 3],
    low: [f64; 3],
    high: [f64; 3],
    error: f64,
    vertices: usize,
    triangles: usize,
}

#[derive(Serialize)]
struct HeightmapsInWords {
    size: u32,
    tiles: [u32; 2],
    /// From post to post, east and north.
    spacing: [f64; 2],
    low: [f64; 2],
    high: [f64; 2],
    /// Of 16 bits: metres = `zero` + `quantum` × number; the number 0 is no ground, and in files of metres so is the height `zero`.
    zero: f64,
    quantum: f64,
    sampling_error: f64,
    /// From the source, all in all.
    error_of_numbers: f64,
    error_of_metres: f64,
    posts_without_ground: usize,
    tile: Vec<HeightmapInWords>,
}

#[derive(Serialize)]
struct HeightmapInWords {
    path: String,
    column: u32,
    row: u32,
    low: [f64; 2],
    high: [f64; 2],
    heights: Option<[f64; 2]>,
    posts_without_ground: usize,
}

impl Manifest {
    pub(super) fn new(
        metadata: &Metadata,
        version: u128,
        frame: &Frame,
        pieces: &Pieces,
        heightmaps: &Heightmaps,
        files: BTreeMap<String, Sum>,
    ) -> Self {
        let certified = pieces.greatest(|record| record.error);
        let steepest = pieces.greatest(|record| record.steepest);
        let rounding = frame.rounding(steepest);
        let half_quantum = heightmaps.scale.quantum / 2.0;
        let steepest_between = heightmaps.steepest + heightmaps.scale.quantum / heightmaps.grid.spacing().min_element();
        let all = |along_up: f64| certified + rounding + along_up * frame.leaning(steepest_between);
        let source = &metadata.source;
        let on_plane = frame.origin_on_plane();
        Self {
            generator: format!("terrain-ingest {}", env!("CARGO_PKG_VERSION")),
            source: SourceFiles {
                files: source.files.clone(),
                crs: source.crs.clone(),
                archive: format!("{version:032x}"),
            },
            frame: FrameInWords {
                kind: if on_plane.is_some() {
                    "the source's plane: x and y are its coordinates from the origin, z its heights"
                } else {
                    "east-north-up, flat in space: z is along the ellipsoid's normal at the origin"
                },
                units: "metre",
                ellipsoid: on_plane.is_none().then_some("WGS 84"),
                origin: match on_plane {
                    Some(DVec2 { x, y }) => Origin::OnPlane { x, y, height: 0.0 },
                    None => Origin::OnEarth {
                        longitude: frame.origin.x,
                        latitude: frame.origin.y,
                        height: 0.0,
                    },
                },
                heights_above: source.tiles_above().to_owned(),
                vertical_transformation: source.vertical_transformation(),
                largest_tilt_degrees: frame.tilt.to_degrees(),
            },
            surface: Surface {
                zoom: pieces.records.last().map_or(0, |record| record.address.zoom),
                certified_error: certified,
                bound: metadata.bound.clone(),
                steepest,
            },
            meshes: Meshes {
                step: frame.step,
                rounding_error: rounding,
                error: certified + rounding,
                tiles: pieces.records.iter().map(MeshInWords::of).collect(),
            },
            heightmaps: HeightmapsInWords {
                size: heightmaps.grid.size,
                tiles: heightmaps.grid.tiles.to_array(),
                spacing: heightmaps.grid.spacing().to_array(),
                low: heightmaps.grid.low.to_array(),
                high: heightmaps.grid.high.to_array(),
                zero: heightmaps.scale.zero,
                quantum: heightmaps.scale.quantum,
                sampling_error: heightmaps.sampling_error,
                error_of_numbers: all(heightmaps.sampling_error + half_quantum),
                error_of_metres: all(heightmaps.sampling_error),
                posts_without_ground: heightmaps.maps.iter().map(|map| map.posts_without_ground).sum(),
                tile: heightmaps
                    .maps
                    .iter()
                    .map(|map| HeightmapInWords::of(heightmaps, map))
                    .collect(),
            },
            files,
        }
    }
}

impl MeshInWords {
    fn of(record: &Record) -> Self {
        let [offset, low, high] = [record.offset, record.bounds.low, record.bounds.high].map(|at: DVec3| at.to_array());
        Self {
            path: record.path.clone(),
            offset,
            low,
            high,
            error: record.error,
            vertices: record.vertices,
            triangles: record.triangles,
        }
    }
}

impl HeightmapInWords {
    fn of(heightmaps: &Heightmaps, map: &Heightmap) -> Self {
        let [low, high] = heightmaps.grid.rectangle(map.tile).map(|at: DVec2| at.to_array());
        let UVec2 { x: column, y: row } = map.tile;
        Self {
            path: map.path.clone(),
            column,
            row,
            low,
            high,
            heights: map.heights.map(|heights| heights.map(f64::from)),
            posts_without_ground: map.posts_without_ground,
        }
    }
}
