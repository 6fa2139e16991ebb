//! A [`QuantizedMesh`] as bytes.
//!
//! ```text
//! ┌─────────┬───────┬───────────┬─────────┬─────────┬───────┬─────────┬──────────────────────────┐
//! │ header  │ u32   │ u,v,height│ 0 or 2  │ u32     │ 3 idx │ 4 × u32 │ extensions 1, 2 and 200, │
//! │ 88 B    │ count │ 6 B each  │ padding │ count   │ each  │ + idx   │ if asked for             │
//! └─────────┴───────┴───────────┴─────────┴─────────┴───────┴─────────┴──────────────────────────┘
//! ```

use super::{QuantizedMesh, Vertex};

/// Up to this many vertices, indices take two bytes.
pub(super) const SHORT_INDEX_VERTICES: usize = 65_536;
/// Extension: oct-encoded normals, two bytes a vertex.
pub(super) const NORMALS_EXTENSION: u8 = 1;
/// Extension: the water mask, one byte or 256 × 256.
pub(super) const WATER_MASK_EXTENSION: u8 = 2;
/// Extension of ours: the number of measured triangles, u32.
pub(super) const MEASURED_EXTENSION: u8 = 200;

/// Which extensions a client asks for: none that it did not ask for may be sent, since some clients fail on ids that they do not know.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Extensions {
    /// `octvertexnormals`.
    pub normals: bool,
    /// `watermask`.
    pub water_mask: bool,
    /// `measuredtriangles`, ours.
    pub measured_triangles: bool,
}

impl Extensions {
    /// All that there are.
    pub const ALL: Self = Self {
        normals: true,
        water_mask: true,
        measured_triangles: true,
    };

    /// Those that have these names. Other names, of extensions that are not made here, are passed over.
    #[must_use]
    pub fn named<'a>(names: impl Iterator<Item = &'a str>) -> Self {
        names.fold(Self::default(), |asked, name| match name {
            "octvertexnormals" => Self { normals: true, ..asked },
            "watermask" => Self {
                water_mask: true,
                ..asked
            },
            "measuredtriangles" => Self {
                measured_triangles: true,
                ..asked
            },
            _ => asked,
        })
    }
}

/// The bytes of `mesh` with the `extensions` that were asked for.
#[must_use]
pub fn encode(mesh: &QuantizedMesh, extensions: Extensions) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(128 + mesh.vertices.len() * 8 + mesh.triangles.len() * 6);
    write_header(&mut bytes, mesh);
    write_vertices(&mut bytes, &mesh.vertices);
    let short = mesh.vertices.len() <= SHORT_INDEX_VERTICES;
    if !short {
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    write_indices(&mut bytes, high_water_marks(&mesh.triangles), short);
    for edge in &mesh.edges {
        bytes.extend((edge.len() as u32).to_le_bytes());
        write_indices(&mut bytes, edge.iter().copied(), short);
    }
    if let Some(normals) = mesh.normals.as_ref().filter(|_| extensions.normals) {
        write_extension(&mut bytes, NORMALS_EXTENSION, normals.as_flattened());
    }
    if let Some(mask) = mesh.water_mask.as_ref().filter(|_| extensions.water_mask) {
        write_extension(&mut bytes, WATER_MASK_EXTENSION, mask);
    }
    if let Some(measured) = mesh.measured_triangles.filter(|_| extensions.measured_triangles) {
        write_extension(&mut bytes, MEASURED_EXTENSION, &measured.to_le_bytes());
    }
    bytes
}

fn write_header(bytes: &mut Vec<u8>, mesh: &QuantizedMesh) {
    let doubles =
        |bytes: &mut Vec<u8>, values: &[f64]| bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    doubles(bytes, &mesh.center.to_array());
    bytes.extend(mesh.heights.iter().flat_map(|height| height.to_le_bytes()));
    doubles(bytes, &mesh.sphere_center.to_array());
    doubles(bytes, &[mesh.sphere_radius]);
    doubles(bytes, &mesh.horizon_occlusion_point.to_array());
}

/// Three arrays, each value as the zigzag-coded difference from the one before.
fn write_vertices(bytes: &mut Vec<u8>, vertices: &[Vertex]) {
    bytes.extend((vertices.len() as u32).to_le_bytes());
    let coordinates: [fn(&Vertex) -> u16; 3] = [|vertex| vertex.u, |vertex| vertex.v, |vertex| vertex.height];
    for coordinate in coordinates {
        let mut previous = 0;
        for vertex in vertices {
            let difference = i32::from(coordinate(vertex)) - previous;
            previous += difference;
            let zigzag = (difference << 1) ^ (difference >> 31);
            bytes.extend((zigzag as u16).to_le_bytes());
        }
    }
}

/// Indices as distances below the next one never used, which a first use takes and moves up.
fn high_water_marks(triangles: &[[u32; 3]]) -> impl Iterator<Item = u32> {
    let mut next = 0;
    triangles.as_flattened().iter().map(move |&index| {
        let code = next - index;
        next += u32::from(code == 0);
        code
    })
}

fn write_indices(bytes: &mut Vec<u8>, indices: impl Iterator<Item = u32>, short: bool) {
    for index in indices {
        if short {
            bytes.extend((index as u16).to_le_bytes());
        } else {
            bytes.extend(index.to_le_bytes());
        }
    }
}

fn write_extension(bytes: &mut Vec<u8>, id: u8, content: &[u8]) {
    bytes.push(id);
    bytes.extend((content.len() as u32).to_le_bytes());
    bytes.extend(content);
}
