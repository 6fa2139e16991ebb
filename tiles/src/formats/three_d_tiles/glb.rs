//! A surface in space as GLB (Khronos, *glTF 2.0*): one mesh of one primitive, and one node, whose matrix puts it on the Earth.
//!
//! Positions are in single precision, from the middle of the tile, along Earth-centred axes. They and the middle are multiples of one
//! step, so that nothing is lost. glTF has y upwards; who draws 3D Tiles turns that to z upwards again, and the matrix has the turn
//! that is undone then:
//!
//! ```text
//!  x   ⎡ 1  0  0 ⎤     middle x
//!  y = ⎢ 0  0  1 ⎥ p + middle z
//!  z   ⎣ 0 −1  0 ⎦    −middle y
//! ```

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use super::TileSurface;
use crate::formats::gltf::write_chunks;
use crate::formats::quantized_mesh::bounds;
use crate::metadata::Metadata;

/// How the numbers are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Packing {
    /// As they are, for any reader of glTF 2.0.
    #[default]
    Plain,
}

/// Component types of accessors.
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
/// Targets of buffer views.
const VERTICES: u32 = 34962;
const TRIANGLES: u32 = 34963;

/// The file of `surface`, a tile of the archive that `metadata` describe. None of a surface without triangles, which glTF has no room
/// for.
#[must_use]
pub fn file(surface: &TileSurface, packing: Packing, metadata: &Metadata) -> Option<Vec<u8>> {
    if surface.triangles.is_empty() {
        return None;
    }
    let Packing::Plain = packing;
    let (middle, offsets) = about_middle(surface);
    let mut file = File::default();
    let position = file.vectors(&offsets, true);
    let normals: Vec<Vec3> = surface.normals.iter().map(|normal| normal.as_vec3()).collect();
    let normal = file.vectors(&normals, false);
    let is_short = surface.positions.len() < usize::from(u16::MAX);
    let indices = file.indices(surface.triangles.as_flattened(), is_short, Some(TRIANGLES));
    let sides = surface.sides.as_ref().map(|sides| {
        let [left, bottom, right, top] = [0, 1, 2, 3].map(|side| file.indices(&sides[side], is_short, None));
        json!({ "left": left, "bottom": bottom, "right": right, "top": top })
    });
    let mut primitive = json!({ "attributes": { "POSITION": position, "NORMAL": normal }, "indices": indices });
    if let Some(sides) = &sides {
        primitive["extensions"] = json!({ "CESIUM_tile_edges": sides });
    }
    let extras = json!({
        "certifiedError": surface.error,
        "heightsAbove": metadata.source.tiles_above(),
        "source": metadata.source.files,
    });
    let mut description = json!({
        "asset": { "version": "2.0", "generator": "terrain-tiles", "extras": extras },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "matrix": matrix(middle) }],
        "meshes": [{ "primitives": [primitive] }],
        "buffers": [{ "byteLength": file.binary.len() }],
        "bufferViews": file.views,
        "accessors": file.accessors,
    });
    if sides.is_some() {
        description["extensionsUsed"] = json!(["CESIUM_tile_edges"]);
    }
    let mut bytes = Vec::new();
    write_chunks(&mut bytes, description.to_string().into_bytes(), file.binary)
        .expect("a tile is far smaller than 4 GiB, and memory takes all bytes");
    Some(bytes)
}

/// A middle that is on the lattice of the positions, and the positions from there: exact in single precision.
fn about_middle(surface: &TileSurface) -> (DVec3, Vec<Vec3>) {
    let (center, _) = bounds::sphere(&surface.positions);
    let middle = (center / surface.step).round() * surface.step;
    let offsets = surface.positions.iter().map(|&at| (at - middle).as_vec3());
    (middle, offsets.collect())
}

/// The node's, column by column.
fn matrix(middle: DVec3) -> [f64; 16] {
    let mut matrix = [0.0; 16];
    (matrix[0], matrix[6], matrix[9], matrix[15]) = (1.0, -1.0, 1.0, 1.0);
    (matrix[12], matrix[13], matrix[14]) = (middle.x, middle.z, -middle.y);
    matrix
}

/// A file while its parts are collected.
#[derive(Default)]
struct File {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    /// Adds vectors of vertices, with their bounds where they must be told; returns the accessor's number.
    fn vectors(&mut self, vectors: &[Vec3], with_bounds: bool) -> usize {
        let numbers = vectors.iter().flat_map(|vector| vector.to_array());
        let bytes: Vec<u8> = numbers.flat_map(f32::to_le_bytes).collect();
        let mut accessor = json!({ "componentType": FLOAT, "count": vectors.len(), "type": "VEC3" });
        if with_bounds {
            let least = vectors.iter().copied().fold(Vec3::INFINITY, Vec3::min);
            let most = vectors.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
            accessor["min"] = json!(least.to_array());
            accessor["max"] = json!(most.to_array());
        }
        self.add(&bytes, Some(VERTICES), accessor)
    }

    /// Adds numbers of vertices.
    fn indices(&mut self, indices: &[u32], is_short: bool, target: Option<u32>) -> usize {
        let bytes: Vec<u8> = if is_short {
            indices.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect()
        } else {
            indices.iter().flat_map(|index| index.to_le_bytes()).collect()
        };
        let component = if is_short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        let accessor = json!({ "componentType": component, "count": indices.len(), "type": "SCALAR" });
        self.add(&bytes, target, accessor)
    }

    /// Adds a view of its own, of whole words, for each accessor: readers of terrain expect no others.
    fn add(&mut self, bytes: &[u8], target: Option<u32>, mut accessor: Value) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        accessor["bufferView"] = json!(self.views.len());
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}
