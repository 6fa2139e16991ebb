//! Files of triangles with normals.

use std::collections::HashMap;
use std::io::{self, Write};

use terrain_core::curved::tessellation::Tessellation;
use terrain_tiles::formats::gltf::DrawnMesh;
use terrain_tiles::formats::polygons::{Column, Storage};
use terrain_tiles::formats::{gltf, obj, ply};

/// Which file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Obj,
    Ply,
    Glb,
}

/// Writes a whole file. Where a vertex has several normals, `.ply` and `.glb` files have it several times.
pub(super) fn write(out: &mut impl Write, form: Form, made: &Tessellation, note: &str) -> io::Result<()> {
    match form {
        Form::Obj => obj::write_with_normals(out, &made.mesh, &made.normals, &made.triangle_normals, note),
        Form::Glb => gltf::write(out, &one_normal_a_vertex(made), note),
        Form::Ply => {
            let drawn = one_normal_a_vertex(made);
            let column = |(axis, name): (usize, &str)| Column {
                name: name.to_owned(),
                storage: Storage::Float,
                values: drawn.normals.iter().map(|normal| normal[axis]).collect(),
            };
            let columns: Vec<Column> = ["nx", "ny", "nz"].into_iter().enumerate().map(column).collect();
            ply::write(out, &drawn.positions, &columns, &drawn.triangles, Some(note))
        }
    }
}

/// A vertex for each pair of a vertex and a normal, in the order in which triangles use them.
fn one_normal_a_vertex(made: &Tessellation) -> DrawnMesh {
    let mut drawn = DrawnMesh::default();
    let mut numbers: HashMap<[u32; 2], u32> = HashMap::new();
    for (corners, normals) in made.mesh.triangles.iter().zip(&made.triangle_normals) {
        drawn.triangles.push([0, 1, 2].map(|corner| {
            let (vertex, normal) = (corners[corner], normals[corner]);
            *numbers.entry([vertex, normal]).or_insert_with(|| {
                drawn.positions.push(made.mesh.positions[vertex as usize]);
                drawn.normals.push(made.normals[normal as usize]);
                drawn.positions.len() as u32 - 1
            })
        }));
    }
    drawn
}
