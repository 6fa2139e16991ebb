//! Wavefront OBJ, read by the `tobj` crate, written as text.

use std::io::{self, BufRead, Write};
use std::path::Path;

use glam::DVec3;

use super::polygons::{Column, PolygonError, PolygonLimits, Polygons, Storage};

/// Colours are shares of one in this format and bytes everywhere else.
const LARGEST_BYTE: f64 = 255.0;

/// Reads all objects and groups of a file as one set of polygons. Its materials are not looked for.
///
/// # Errors
/// Where the bytes are of another format, or more than `limits` allow.
pub fn read(mut file: impl BufRead, limits: PolygonLimits) -> Result<Polygons, PolygonError> {
    let options = tobj::LoadOptions {
        single_index: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let malformed = |error: tobj::LoadError| PolygonError::Malformed {
        format: "OBJ",
        reason: error.to_string(),
    };
    let no_materials = |_: &Path| Ok(Default::default());
    let (objects, _) = tobj::load_obj_buf(&mut file, &options, no_materials).map_err(malformed)?;
    let meshes: Vec<tobj::Mesh> = objects.into_iter().map(|object| object.mesh).collect();
    let mut polygons = Polygons {
        columns: columns(&meshes),
        ..Polygons::default()
    };
    meshes.iter().try_for_each(|mesh| add(mesh, &mut polygons, limits))?;
    Ok(polygons)
}

fn add(mesh: &tobj::Mesh, polygons: &mut Polygons, limits: PolygonLimits) -> Result<(), PolygonError> {
    let first = polygons.positions.len() as u64;
    polygons
        .positions
        .extend(mesh.positions.chunks_exact(3).map(DVec3::from_slice));
    if polygons.positions.len() > limits.vertices as usize {
        return Err(PolygonError::TooLarge(limits.vertices, "vertices"));
    }
    let mut corners = mesh.indices.iter().map(|&corner| first + u64::from(corner));
    // No arities: all faces are triangles.
    let arities = match mesh.face_arities.as_slice() {
        [] => vec![3; mesh.indices.len() / 3],
        arities => arities.to_vec(),
    };
    for arity in arities {
        let face: Vec<u64> = corners.by_ref().take(arity as usize).collect();
        polygons.add_face(&face, limits)?;
    }
    Ok(())
}

/// What a mesh says of its vertices, all numbers of the first vertex, then of the second …
type Numbers<'a> = &'a dyn Fn(&tobj::Mesh) -> Vec<f64>;

/// Normals, texture coordinates and colours, each where every vertex has it.
fn columns(meshes: &[tobj::Mesh]) -> Vec<Column> {
    let normals = |mesh: &'_ tobj::Mesh| mesh.normals.clone();
    let texture = |mesh: &'_ tobj::Mesh| mesh.texcoords.clone();
    let colours = |mesh: &'_ tobj::Mesh| mesh.vertex_color.iter().map(|share| share * LARGEST_BYTE).collect();
    let kinds: [(&[&str], Storage, Numbers); 3] = [
        (&["nx", "ny", "nz"], Storage::Float, &normals),
        (&["s", "t"], Storage::Float, &texture),
        (&["red", "green", "blue"], Storage::Byte, &colours),
    ];
    let vertices: usize = meshes.iter().map(|mesh| mesh.positions.len() / 3).sum();
    let mut columns = Vec::new();
    for (names, storage, numbers_of) in kinds {
        let numbers: Vec<f64> = meshes.iter().flat_map(numbers_of).collect();
        if vertices > 0 && numbers.len() == vertices * names.len() {
            columns.extend(names.iter().enumerate().map(|(place, name)| Column {
                name: (*name).to_owned(),
                storage,
                values: numbers.iter().skip(place).step_by(names.len()).copied().collect(),
            }));
        }
    }
    columns
}

/// Writes a mesh after a comment. Numbers read back as the same doubles.
///
/// # Errors
/// What `out` says.
pub fn write(out: &mut impl Write, positions: &[DVec3], triangles: &[[u32; 3]], note: &str) -> io::Result<()> {
    writeln!(out, "# {note}")?;
    for DVec3 { x, y, z } in positions {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [a, b, c] in triangles {
        writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1)?;
    }
    Ok(())
}
