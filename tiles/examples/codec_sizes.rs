//! What the progressive codec makes of meshes, for `tests/peers/codec.py` to set beside other programs.
//!
//! ```text
//! codec_sizes tiles ARCHIVE.pmtiles FOLDER    the finest mesh of every tile into FOLDER; bytes of each tile as JSON lines
//! codec_sizes mesh MESH.raw STEP              one mesh as .spm, its samples STEP lattice units apart; bytes and speed as JSON
//! ```
//! A `.raw` mesh is: u32 vertices, u32 triangles, i32 × 3 a vertex, u32 × 3 a triangle, little-endian.

use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use serde_json::json;
use terrain_codec::LevelLimits;
use terrain_codec::progressive::Sampling;
use terrain_codec::spm::{self, ProgressiveMesh};
use terrain_codec::spt;
use terrain_core::levels::partition::Level;
use terrain_core::{Mesh, SurfacePartition};
use terrain_tiles::archive::Reader;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["tiles", archive, folder] => tiles(Path::new(archive), Path::new(folder)),
        ["mesh", mesh, step] => one_mesh(Path::new(mesh), step.parse()?),
        _ => Err("usage: codec_sizes tiles ARCHIVE.pmtiles FOLDER | codec_sizes mesh MESH.raw STEP".into()),
    }
}

fn tiles(archive: &Path, folder: &Path) -> Result<(), Failure> {
    let reader = Reader::open(archive)?;
    for address in reader.addresses() {
        let bytes = reader.tile(address)?.ok_or("a tile of the directory is missing")?;
        let tile = spt::decode(&bytes, &LevelLimits::default())?;
        let steps = (-f64::from(tile.height_exponent)).exp2();
        let mut mesh = tile.surface(tile.finest());
        mesh.positions.iter_mut().for_each(|position| position.z *= steps);
        let name = format!("{}_{}_{}.raw", address.zoom, address.x, address.y);
        std::fs::write(folder.join(&name), raw(&mesh))?;
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        println!(
            "{}",
            json!({"mesh": name, "zoom": address.zoom, "bytes": bytes.len(), "vertices": vertices, "triangles": triangles})
        );
    }
    Ok(())
}

fn one_mesh(path: &Path, step: f64) -> Result<(), Failure> {
    let mesh = from_raw(&std::fs::read(path)?).ok_or("the mesh is cut off")?;
    let low = mesh.positions.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let positions: Vec<DVec3> = mesh.positions.iter().map(|&position| position - low).collect();
    let level = Level {
        vertex_end: positions.len() as u32,
        triangle_end: mesh.triangles.len() as u32,
        error: 0.0,
    };
    let model = ProgressiveMesh {
        origin: low,
        step: DVec3::ONE,
        is_height_field: true,
        sampling: Some(Sampling {
            origin: [0.0; 2],
            step: [step; 2],
        }),
        partition: SurfacePartition {
            representatives: (0..level.vertex_end).collect(),
            blue_positions: positions.clone(),
            positions,
            triangles: mesh.triangles,
            levels: vec![level],
        },
    };
    let bytes = spm::encode(&model)?;
    let mut seconds = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        spm::decode(&bytes, &LevelLimits::default())?;
        seconds = seconds.min(start.elapsed().as_secs_f64());
    }
    let triangles = level.triangle_end;
    println!(
        "{}",
        json!({"bytes": bytes.len(), "triangles": triangles, "triangles_a_second": f64::from(triangles) / seconds})
    );
    Ok(())
}

fn raw(mesh: &Mesh) -> Vec<u8> {
    let counts = [mesh.positions.len() as u32, mesh.triangles.len() as u32];
    let mut bytes: Vec<u8> = counts.iter().flat_map(|count| count.to_le_bytes()).collect();
    for position in &mesh.positions {
        bytes.extend(
            position
                .to_array()
                .iter()
                .flat_map(|&number| (number as i32).to_le_bytes()),
        );
    }
    bytes.extend(
        mesh.triangles
            .as_flattened()
            .iter()
            .flat_map(|corner| corner.to_le_bytes()),
    );
    bytes
}

fn from_raw(bytes: &[u8]) -> Option<Mesh> {
    let words: Vec<u32> = bytes
        .as_chunks()
        .0
        .iter()
        .map(|&word| u32::from_le_bytes(word))
        .collect();
    let (counts, words) = words.split_at_checked(2)?;
    let (positions, triangles) = words.split_at_checked(3 * counts[0] as usize)?;
    let position = |p: &[u32; 3]| DVec3::from_array(p.map(|number| f64::from(number.cast_signed())));
    Some(Mesh {
        positions: positions.as_chunks().0.iter().map(position).collect(),
        triangles: triangles.get(..3 * counts[1] as usize)?.as_chunks().0.to_vec(),
    })
}
