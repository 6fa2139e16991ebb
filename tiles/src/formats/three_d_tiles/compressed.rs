//! Numbers in few bits, and bytes that say the same in fewer: `EXT_meshopt_compression` and `KHR_mesh_quantization`.
//!
//! Bytes get fewer where a triangle is near the one before it, and its vertices are new or were just used. So triangles are put in such
//! an order, and vertices in that of their first use.

use glam::DVec3;
use meshopt::{
    encode_filter_oct, encode_index_buffer, encode_index_sequence, encode_vertex_buffer_level,
    optimize_vertex_cache_strip, optimize_vertex_fetch_remap,
};

use super::TileSurface;

/// Most that there is in a component of a position.
const MOST: f64 = 65_535.0;
/// Of the format of vertices; the extension knows no newer one. Levels are of newer ones.
const VERTEX_VERSION: (i32, Option<i32>) = (0, Some(0));
/// Bits of a component of a normal.
const NORMAL_BITS: i32 = 8;

/// The same surface with triangles and vertices in another order, without vertices that have no triangle.
pub(super) fn in_order(surface: &TileSurface) -> TileSurface {
    let count = surface.positions.len();
    let indices = optimize_vertex_cache_strip(surface.triangles.as_flattened(), count);
    let places = optimize_vertex_fetch_remap(&indices, count);
    let used = places.iter().filter(|&&place| place != u32::MAX).count();
    let moved = |old: &[DVec3]| {
        let mut new = vec![DVec3::ZERO; used];
        for (&place, &value) in places.iter().zip(old) {
            if let Some(new) = new.get_mut(place as usize) {
                *new = value;
            }
        }
        new
    };
    let renumbered = |list: &[u32]| list.iter().map(|&old| places[old as usize]).collect();
    let corners: Vec<u32> = renumbered(&indices);
    TileSurface {
        positions: moved(&surface.positions),
        normals: moved(&surface.normals),
        triangles: corners.as_chunks::<3>().0.to_vec(),
        sides: surface
            .sides
            .as_ref()
            .map(|sides| sides.each_ref().map(|side| renumbered(side))),
        ..*surface
    }
}

/// What a view of a file is when it is decompressed, and its bytes before that.
pub(super) struct Compressed {
    pub(super) bytes: Vec<u8>,
    pub(super) count: usize,
    pub(super) stride: usize,
    pub(super) mode: &'static str,
    pub(super) filter: Option<&'static str>,
}

/// Positions as whole numbers of a step from the corner with the least coordinates; none where 16 bits do not hold them.
pub(super) fn whole_numbers(surface: &TileSurface) -> Option<(DVec3, Vec<[u16; 3]>)> {
    let corner = surface.positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let steps = surface.positions.iter().map(|&at| (at - corner) / surface.step);
    let fits = |steps: DVec3| steps.max_element() <= MOST;
    let numbers = steps.map(|steps| fits(steps).then(|| steps.to_array().map(|number| number as u16)));
    Some((corner, numbers.collect::<Option<_>>()?))
}

pub(super) fn positions(numbers: &[[u16; 3]]) -> Compressed {
    let padded: Vec<[u16; 4]> = numbers.iter().map(|&[x, y, z]| [x, y, z, 0]).collect();
    of_vertices(&padded, None)
}

/// Each as a place on an octahedron, in two bytes.
pub(super) fn normals(normals: &[DVec3]) -> Compressed {
    let padded: Vec<[f32; 4]> = normals
        .iter()
        .map(|normal| normal.as_vec3().extend(0.0).to_array())
        .collect();
    let places: Vec<[i8; 4]> = encode_filter_oct(&padded, NORMAL_BITS);
    of_vertices(&places, Some("OCTAHEDRAL"))
}

fn of_vertices<T>(vertices: &[T], filter: Option<&'static str>) -> Compressed {
    let (level, version) = VERTEX_VERSION;
    Compressed {
        bytes: encode_vertex_buffer_level(vertices, level, version).expect(ENOUGH),
        count: vertices.len(),
        stride: size_of::<T>(),
        mode: "ATTRIBUTES",
        filter,
    }
}

/// Corners of triangles, or vertices of a line, of `vertices` that there are.
pub(super) fn indices(indices: &[u32], vertices: usize, stride: usize, are_triangles: bool) -> Compressed {
    let (bytes, mode) = if are_triangles {
        (encode_index_buffer(indices, vertices), "TRIANGLES")
    } else {
        (encode_index_sequence(indices, vertices), "INDICES")
    };
    Compressed {
        bytes: bytes.expect(ENOUGH),
        count: indices.len(),
        stride,
        mode,
        filter: None,
    }
}

/// Why no encoder fails.
const ENOUGH: &str = "there is room for what the bound of the encoder says";
