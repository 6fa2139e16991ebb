//! A surface in space as GLB (Khronos, *glTF 2.0*): one mesh of one primitive, and one node, whose matrix puts it on the Earth.
//!
//! Positions are along Earth-centred axes: in single precision, metres from the middle of the tile; in 16 bits, steps from its corner
//! with the least coordinates. They, the middle and the corner are multiples of one step, so that nothing is lost. glTF has y upwards; who
//! draws 3D Tiles turns that to z upwards again, and the matrix has the turn that is undone then:
//!
//! ```text
//!  x   ⎡ 1  0  0 ⎤         origin x
//!  y = ⎢ 0  0  1 ⎥ p unit + origin z
//!  z   ⎣ 0 −1  0 ⎦        −origin y
//! ```
//!
//! CesiumJS's terrain takes positions of 16 bits as parts of 65,535, whatever is said of them: so there the unit is that many steps.

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use super::compressed::{self, Compressed};
use super::{Packing, TileSurface};
use crate::formats::gltf::write_chunks;
use crate::formats::quantized_mesh::bounds;
use crate::metadata::Metadata;

const COMPRESSION: &str = "EXT_meshopt_compression";
/// Component types of accessors.
const BYTE: u32 = 5120;
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
    let ordered = (packing == Packing::Meshopt).then(|| compressed::in_order(surface));
    let surface = ordered.as_ref().unwrap_or(surface);
    let mut file = File::of(packing);
    let (position, matrix) = file.positions(surface);
    let normal = file.normals(&surface.normals);
    let vertices = surface.positions.len();
    let indices = file.indices(surface.triangles.as_flattened(), vertices, Some(TRIANGLES));
    let sides = surface.sides.as_ref().map(|sides| {
        let [left, bottom, right, top] = [0, 1, 2, 3].map(|side| file.indices(&sides[side], vertices, None));
        json!({ "left": left, "bottom": bottom, "right": right, "top": top })
    });
    let mut primitive = json!({ "attributes": { "POSITION": position, "NORMAL": normal }, "indices": indices });
    if let Some(sides) = &sides {
        primitive["extensions"] = json!({ "CESIUM_tile_edges": sides });
    }
    let extras = json!({
        "certifiedError": surface.error,
        "rounding": surface.rounding(),
        "heightsAbove": metadata.source.tiles_above(),
        "source": metadata.source.files,
    });
    let mut description = json!({
        "asset": { "version": "2.0", "generator": "terrain-tiles", "extras": extras },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "matrix": matrix }],
        "meshes": [{ "primitives": [primitive] }],
        "buffers": file.buffers(),
        "bufferViews": file.views,
        "accessors": file.accessors,
    });
    let required: &[&str] = match packing {
        Packing::Plain => &[],
        Packing::Meshopt => &[COMPRESSION, "KHR_mesh_quantization"],
    };
    let used: Vec<&str> = required
        .iter()
        .copied()
        .chain(sides.map(|_| "CESIUM_tile_edges"))
        .collect();
    for (name, extensions) in [("extensionsUsed", used.as_slice()), ("extensionsRequired", required)] {
        if !extensions.is_empty() {
            description[name] = json!(extensions);
        }
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
fn matrix(unit: f64, origin: DVec3) -> [f64; 16] {
    let mut matrix = [0.0; 16];
    (matrix[0], matrix[6], matrix[9], matrix[15]) = (unit, -unit, unit, 1.0);
    (matrix[12], matrix[13], matrix[14]) = (origin.x, origin.z, -origin.y);
    matrix
}

/// A file while its parts are collected.
struct File {
    packing: Packing,
    binary: Vec<u8>,
    /// Of what is compressed, when it is not.
    decompressed_bytes: usize,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    fn of(packing: Packing) -> Self {
        Self {
            packing,
            binary: Vec::new(),
            decompressed_bytes: 0,
            views: Vec::new(),
            accessors: Vec::new(),
        }
    }

    /// Adds positions; returns the accessor's number and the node's matrix.
    fn positions(&mut self, surface: &TileSurface) -> (usize, [f64; 16]) {
        let numbers = match self.packing {
            Packing::Plain => None,
            Packing::Meshopt => compressed::whole_numbers(surface),
        };
        let Some((corner, numbers)) = numbers else {
            let (middle, offsets) = about_middle(surface);
            return (self.vectors(&offsets, true), matrix(1.0, middle));
        };
        let is_terrain = surface.sides.is_some();
        let unit = if is_terrain { f64::from(u16::MAX) } else { 1.0 };
        let bound = |choose: fn(u16, u16) -> u16| {
            let both = |a: [u16; 3], b: [u16; 3]| [0, 1, 2].map(|axis| choose(a[axis], b[axis]));
            numbers.iter().copied().reduce(both)
        };
        let accessor = json!({
            "componentType": UNSIGNED_SHORT, "normalized": is_terrain, "count": numbers.len(), "type": "VEC3",
            "min": bound(u16::min), "max": bound(u16::max),
        });
        let accessor = self.add_compressed(&compressed::positions(&numbers), Some(VERTICES), accessor);
        (accessor, matrix(unit * surface.step, corner))
    }

    /// Adds unit vectors; returns the accessor's number.
    fn normals(&mut self, normals: &[DVec3]) -> usize {
        match self.packing {
            Packing::Plain => {
                let normals: Vec<Vec3> = normals.iter().map(|normal| normal.as_vec3()).collect();
                self.vectors(&normals, false)
            }
            Packing::Meshopt => {
                let accessor =
                    json!({ "componentType": BYTE, "normalized": true, "count": normals.len(), "type": "VEC3" });
                self.add_compressed(&compressed::normals(normals), Some(VERTICES), accessor)
            }
        }
    }

    /// Adds vectors of vertices in single precision, with their bounds where they must be told; returns the accessor's number.
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

    /// Adds numbers of vertices, of which there are `vertices`.
    fn indices(&mut self, indices: &[u32], vertices: usize, target: Option<u32>) -> usize {
        let is_short = vertices < usize::from(u16::MAX);
        let component = if is_short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        let accessor = json!({ "componentType": component, "count": indices.len(), "type": "SCALAR" });
        if self.packing == Packing::Meshopt {
            let stride = if is_short { size_of::<u16>() } else { size_of::<u32>() };
            let compressed = compressed::indices(indices, vertices, stride, target == Some(TRIANGLES));
            return self.add_compressed(&compressed, target, accessor);
        }
        let bytes: Vec<u8> = if is_short {
            indices.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect()
        } else {
            indices.iter().flat_map(|index| index.to_le_bytes()).collect()
        };
        self.add(&bytes, target, accessor)
    }

    /// Adds a view of its own, of whole words, for each accessor: readers of terrain expect no others.
    fn add(&mut self, bytes: &[u8], target: Option<u32>, accessor: Value) -> usize {
        let view = json!({ "buffer": 0, "byteOffset": self.append(bytes), "byteLength": bytes.len() });
        self.add_view(view, target, accessor)
    }

    /// Adds a view of its own of the second buffer, which nobody sends: bytes of the first one become it.
    fn add_compressed(&mut self, compressed: &Compressed, target: Option<u32>, accessor: Value) -> usize {
        let Compressed {
            bytes,
            count,
            stride,
            mode,
            filter,
        } = compressed;
        let mut extension = json!({
            "buffer": 0, "byteOffset": self.append(bytes), "byteLength": bytes.len(),
            "byteStride": stride, "count": count, "mode": mode,
        });
        if let Some(filter) = filter {
            extension["filter"] = json!(filter);
        }
        let length = count * stride;
        let mut view = json!({
            "buffer": 1, "byteOffset": self.decompressed_bytes, "byteLength": length, "extensions": { COMPRESSION: extension },
        });
        if target == Some(VERTICES) {
            view["byteStride"] = json!(stride);
        }
        self.decompressed_bytes += length.next_multiple_of(4);
        self.add_view(view, target, accessor)
    }

    /// Returns where the bytes are.
    fn append(&mut self, bytes: &[u8]) -> usize {
        let start = self.binary.len();
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        start
    }

    fn add_view(&mut self, mut view: Value, target: Option<u32>, mut accessor: Value) -> usize {
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn buffers(&self) -> Vec<Value> {
        let sent = json!({ "byteLength": self.binary.len() });
        let made =
            json!({ "byteLength": self.decompressed_bytes, "extensions": { COMPRESSION: { "fallback": true } } });
        match self.packing {
            Packing::Plain => vec![sent],
            Packing::Meshopt => vec![sent, made],
        }
    }
}
