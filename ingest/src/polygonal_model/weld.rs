//! The polygons of a file become a model: one vertex for each position.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use terrain_core::Mesh;
use terrain_tiles::formats::polygons::{Column, Polygons};

use super::{Model, ModelError};

/// The largest coordinate: fifth powers of lengths, which measuring needs, are numbers still.
const FARTHEST: f64 = 1e60;

/// Names of the columns that are a normal.
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// A welded model, and the normals of its triangles' corners where the file has some.
pub(super) struct Welded {
    pub(super) model: Model,
    pub(super) normals: Option<Vec<[DVec3; 3]>>,
}

/// One vertex for each position that a triangle uses, in the order of the file. Triangles that lose a corner, or that were
/// there before, are dropped; so are columns whose values at one position differ.
pub(super) fn welded(polygons: Polygons) -> Result<Welded, ModelError> {
    if let Some(vertex) = polygons.positions.iter().position(|position| !position.is_finite()) {
        return Err(ModelError::NotFinite(vertex));
    }
    if let Some(vertex) = polygons
        .positions
        .iter()
        .position(|position| position.abs().max_element() > FARTHEST)
    {
        return Err(ModelError::TooFar(vertex));
    }
    let first = first_at_each_position(&polygons.positions);
    let corners = polygons
        .triangles
        .iter()
        .map(|corners| corners.map(|corner| first[corner as usize]));
    let mut known = HashSet::new();
    let mut is_proper = |[a, b, c]: [u32; 3]| a != b && b != c && c != a && known.insert(from_least([a, b, c]));
    let (origins, proper): (Vec<usize>, Vec<[u32; 3]>) =
        corners.enumerate().filter(|&(_, corners)| is_proper(corners)).unzip();
    if proper.is_empty() {
        return Err(ModelError::NoTriangles);
    }
    let (kept, numbers) = numbered(&proper, polygons.positions.len());
    let normals = normals(&polygons, &origins);
    let (columns, seamed): (Vec<Column>, Vec<Column>) = polygons
        .columns
        .into_iter()
        .partition(|column| agrees(column, &first, &polygons.triangles));
    let gather = |column: Column| Column {
        values: kept.iter().map(|&vertex| column.values[vertex as usize]).collect(),
        ..column
    };
    let model = Model {
        mesh: Mesh {
            positions: kept.iter().map(|&vertex| polygons.positions[vertex as usize]).collect(),
            triangles: proper
                .iter()
                .map(|corners| corners.map(|corner| numbers[corner as usize]))
                .collect(),
        },
        columns: columns.into_iter().map(gather).collect(),
        seams: seamed.into_iter().map(|column| column.name).collect(),
    };
    Ok(Welded { model, normals })
}

/// The normals at the corners of triangles, by the file's vertices.
fn normals(polygons: &Polygons, triangles: &[usize]) -> Option<Vec<[DVec3; 3]>> {
    let column = |name: &str| polygons.columns.iter().find(|column| column.name == name);
    let [x, y, z] = NORMAL.map(column);
    let [x, y, z] = [x?, y?, z?].map(|column| &column.values);
    let normal = |vertex: u32| DVec3::new(x[vertex as usize], y[vertex as usize], z[vertex as usize]);
    Some(
        triangles
            .iter()
            .map(|&triangle| polygons.triangles[triangle].map(normal))
            .collect(),
    )
}

/// For each vertex the first one with its position.
fn first_at_each_position(positions: &[DVec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    // Adding zero makes −0 and 0 the same bits.
    let key = |position: &DVec3| position.to_array().map(|coordinate| (coordinate + 0.0).to_bits());
    let vertices = (0_u32..).zip(positions);
    vertices
        .map(|(vertex, position)| *first.entry(key(position)).or_insert(vertex))
        .collect()
}

/// The same triangle, beginning with its least corner.
fn from_least([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// The vertices that triangles use, growing, and each one's place among them.
fn numbered(triangles: &[[u32; 3]], vertex_count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut is_used = vec![false; vertex_count];
    triangles
        .as_flattened()
        .iter()
        .for_each(|&corner| is_used[corner as usize] = true);
    let kept: Vec<u32> = (0..vertex_count as u32)
        .filter(|&vertex| is_used[vertex as usize])
        .collect();
    let mut numbers = vec![0; vertex_count];
    for (number, &vertex) in (0..).zip(&kept) {
        numbers[vertex as usize] = number;
    }
    (kept, numbers)
}

/// Whether every corner has the column's value of the vertex that it becomes.
fn agrees(column: &Column, first: &[u32], triangles: &[[u32; 3]]) -> bool {
    let mut corners = triangles.as_flattened().iter().map(|&corner| corner as usize);
    corners.all(|corner| column.values[corner].to_bits() == column.values[first[corner] as usize].to_bits())
}
