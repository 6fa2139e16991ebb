//! Wavefront OBJ, read by the `tobj` crate, written as text.

use std::io::{self, BufRead, Read, Write};
use std::path::Path;

use glam::DVec3;
use terrain_core::Mesh;

use super::polygons::{Column, PolygonError, PolygonLimits, Polygons, Storage};

/// Colours are shares of one in this format and bytes everywhere else.
const LARGEST_BYTE: f64 = 255.0;

/// Reads all objects and groups of a file as one set of polygons. What it says of materials is not read.
///
/// # Errors
/// Where the bytes are of another format, or more than `limits` allow.
pub fn read(file: impl BufRead, limits: PolygonLimits) -> Result<Polygons, PolygonError> {
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
    let (objects, _) =
        tobj::load_obj_buf(&mut WithoutMaterials::new(file), &options, no_materials).map_err(malformed)?;
    let meshes: Vec<tobj::Mesh> = objects.into_iter().map(|object| object.mesh).collect();
    let mut polygons = Polygons {
        columns: columns(&meshes),
        ..Polygons::default()
    };
    meshes.iter().try_for_each(|mesh| add(mesh, &mut polygons, limits))?;
    Ok(polygons)
}

/// A file without its lines on materials, at which the crate stops where they are odd or name a file that is not there.
struct WithoutMaterials<R> {
    file: R,
    line: Vec<u8>,
    /// Bytes of the line that were read.
    read: usize,
}

impl<R: BufRead> WithoutMaterials<R> {
    fn new(file: R) -> Self {
        Self {
            file,
            line: Vec::new(),
            read: 0,
        }
    }

    fn is_on_materials(&self) -> bool {
        let line = self.line.trim_ascii_start();
        ["mtllib", "usemtl"]
            .iter()
            .any(|word| line.starts_with(word.as_bytes()))
    }
}

impl<R: BufRead> BufRead for WithoutMaterials<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        while self.read == self.line.len() || self.is_on_materials() {
            self.line.clear();
            self.read = 0;
            if self.file.read_until(b'\n', &mut self.line)? == 0 {
                break;
            }
        }
        Ok(&self.line[self.read..])
    }

    fn consume(&mut self, count: usize) {
        self.read += count;
    }
}

impl<R: BufRead> Read for WithoutMaterials<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(bytes)?;
        self.consume(count);
        Ok(count)
    }
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

/// Writes a mesh whose triangles have a normal at each corner, after a comment.
///
/// # Errors
/// What `out` says.
pub fn write_with_normals(
    out: &mut impl Write,
    mesh: &Mesh,
    normals: &[DVec3],
    triangle_normals: &[[u32; 3]],
    note: &str,
) -> io::Result<()> {
    writeln!(out, "# {note}")?;
    for DVec3 { x, y, z } in &mesh.positions {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for DVec3 { x, y, z } in normals {
        writeln!(out, "vn {x} {y} {z}")?;
    }
    for (corners, normals) in mesh.triangles.iter().zip(triangle_normals) {
        write!(out, "f")?;
        for (corner, normal) in corners.iter().zip(normals) {
            write!(out, " {}//{}", corner + 1, normal + 1)?;
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "obj_tests.rs"]
mod tests;
