//! glTF 2.0 and its binary form GLB (Khronos, *glTF 2.0 Specification*): triangles of the default scene, whose description the
//! `gltf-json` crate reads; a mesh with normals, written as GLB.

mod buffers;

use std::io::{self, Write};

use glam::{DMat4, DQuat, DVec3, Mat4, Quat, Vec3};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::scene::Node;
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};
use serde_json::json;

use self::buffers::{Buffers, malformed};
use super::polygons::{Column, PolygonError, PolygonLimits, Polygons, Storage};

/// What may be required of who draws the file without changing its triangles.
const HARMLESS: [&str; 4] = ["KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_"];

/// Reads what is drawn of a `.gltf` or a `.glb` file: all triangles, where the nodes put them. `open` finds the files that it
/// names, by their relative paths. Normals become columns where all primitives have them.
///
/// # Errors
/// Where the bytes are of another format, name a file that is not there, or are more than `limits` allow.
pub fn read(
    bytes: &[u8],
    open: &dyn Fn(&str) -> io::Result<Vec<u8>>,
    limits: PolygonLimits,
) -> Result<Polygons, PolygonError> {
    let (json, binary) = chunks(bytes)?;
    let root: Root = serde_json::from_slice(json).map_err(|error| malformed(&error))?;
    let is_harmless = |name: &&String| HARMLESS.iter().any(|harmless| name.starts_with(harmless));
    if let Some(name) = root.extensions_required.iter().find(|name| !is_harmless(name)) {
        return Err(malformed(&format!("it needs `{name}`, which is not read")));
    }
    let mut scene = Scene {
        root: &root,
        buffers: Buffers::read(&root, binary, open)?,
        is_seen: vec![false; root.nodes.len()],
        polygons: Polygons::default(),
        normals: Some([(); 3].map(|()| Vec::new())),
        limits,
    };
    match root.scenes.get(root.scene.map_or(0, |scene| scene.value())) {
        Some(drawn) => drawn.nodes.iter().try_for_each(|&node| scene.add_tree(node))?,
        None => {
            let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
            primitives.try_for_each(|primitive| scene.add(primitive, DMat4::IDENTITY))?;
        }
    }
    Ok(scene.finished())
}

/// The description and the binary part of a file, which is the description alone where it is text.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), PolygonError> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let rest = bytes.get(12..).unwrap_or_default();
    let (json, rest) = chunk(rest, JSON).ok_or_else(|| malformed(&"its description is cut"))?;
    Ok((json, chunk(rest, BINARY).map(|(binary, _)| binary)))
}

const MAGIC: &[u8; 4] = b"glTF";
const JSON: &[u8; 4] = b"JSON";
const BINARY: &[u8; 4] = b"BIN\0";

/// The bytes of the next chunk, if it is of a kind, and what follows it.
fn chunk<'a>(bytes: &'a [u8], kind: &[u8; 4]) -> Option<(&'a [u8], &'a [u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    let content = rest.strip_prefix(kind)?;
    content.split_at_checked(u32::from_le_bytes(*length) as usize)
}

/// A scene while its triangles are collected.
struct Scene<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    /// Nodes that were added: each has one place in the tree.
    is_seen: Vec<bool>,
    polygons: Polygons,
    /// None from the first primitive on that has none.
    normals: Option<[Vec<f64>; 3]>,
    limits: PolygonLimits,
}

impl Scene<'_> {
    /// Adds a node and all below it.
    fn add_tree(&mut self, node: Index<Node>) -> Result<(), PolygonError> {
        let mut open = vec![(node, DMat4::IDENTITY)];
        while let Some((index, above)) = open.pop() {
            let node = self.root.get(index).ok_or_else(|| malformed(&"a node is not there"))?;
            if std::mem::replace(&mut self.is_seen[index.value()], true) {
                return Err(malformed(&format!("node {} has two parents", index.value())));
            }
            let transform = above * transform(node);
            if let Some(mesh) = node.mesh {
                let mesh = self.root.get(mesh).ok_or_else(|| malformed(&"a mesh is not there"))?;
                mesh.primitives
                    .iter()
                    .try_for_each(|primitive| self.add(primitive, transform))?;
            }
            open.extend(node.children.iter().flatten().map(|&child| (child, transform)));
        }
        Ok(())
    }

    fn add(&mut self, primitive: &Primitive, transform: DMat4) -> Result<(), PolygonError> {
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            _ => return Ok(()),
        };
        let first = self.polygons.positions.len() as u64;
        let positions = self.vectors(primitive, Semantic::Positions)?;
        let positions = positions.ok_or_else(|| malformed(&"a primitive has no positions"))?;
        if first + positions.len() as u64 > u64::from(self.limits.vertices) {
            return Err(PolygonError::TooLarge(self.limits.vertices, "vertices"));
        }
        let count = positions.len();
        let placed = positions.iter().map(|at| transform.transform_point3(*at));
        self.polygons.positions.extend(placed);
        let normals = self.vectors(primitive, Semantic::Normals)?;
        self.add_normals(normals.filter(|normals| normals.len() == count), transform);
        let indices = match primitive.indices {
            Some(accessor) => self.buffers.indices(accessor)?,
            None => (0..count as u32).collect(),
        };
        let is_turned = transform.determinant() < 0.0;
        for [a, b, c] in triangles(mode, &indices) {
            let corners = if is_turned { [a, c, b] } else { [a, b, c] };
            let corners = corners.map(|corner| {
                if (corner as usize) < count {
                    first + u64::from(corner)
                } else {
                    u64::MAX
                }
            });
            self.polygons.add_face(&corners, self.limits)?;
        }
        Ok(())
    }

    fn vectors(&self, primitive: &Primitive, semantic: Semantic) -> Result<Option<Vec<DVec3>>, PolygonError> {
        let accessor = primitive.attributes.get(&Checked::Valid(semantic));
        accessor.map(|&accessor| self.buffers.vectors(accessor)).transpose()
    }

    /// Normals go as cofactors do: with the inverse transposed, but for its length.
    fn add_normals(&mut self, normals: Option<Vec<DVec3>>, transform: DMat4) {
        let [x, y, z] = [transform.x_axis, transform.y_axis, transform.z_axis].map(|axis| axis.truncate());
        let sign = transform.determinant().signum();
        let turned = |normal: DVec3| sign * (normal.x * y.cross(z) + normal.y * z.cross(x) + normal.z * x.cross(y));
        let known = self.normals.take();
        self.normals = known.zip(normals).map(|(mut columns, normals)| {
            for normal in normals {
                let normal = turned(normal).to_array();
                columns
                    .iter_mut()
                    .zip(normal)
                    .for_each(|(column, value)| column.push(value));
            }
            columns
        });
    }

    fn finished(mut self) -> Polygons {
        if let Some(columns) = self.normals.filter(|columns| !columns[0].is_empty()) {
            let named = ["nx", "ny", "nz"].into_iter().zip(columns);
            self.polygons.columns.extend(named.map(|(name, values)| Column {
                name: name.to_owned(),
                storage: Storage::Float,
                values,
            }));
        }
        self.polygons
    }
}

/// From a node's coordinates to those of the one above.
fn transform(node: &Node) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return Mat4::from_cols_array(matrix).as_dmat4();
    }
    let vector = |given: Option<[f32; 3]>, otherwise: Vec3| given.map_or(otherwise, Vec3::from_array).as_dvec3();
    let turn = node
        .rotation
        .map_or(DQuat::IDENTITY, |turn| Quat::from_array(turn.0).as_dquat());
    DMat4::from_scale_rotation_translation(
        vector(node.scale, Vec3::ONE),
        turn,
        vector(node.translation, Vec3::ZERO),
    )
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(place, three): (usize, &[u32])| match place % 2 {
                0 => [three[0], three[1], three[2]],
                _ => [three[1], three[0], three[2]],
            };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let rest = indices.get(1..).unwrap_or_default();
            rest.windows(2).map(|two| [indices[0], two[0], two[1]]).collect()
        }
        _ => indices.as_chunks::<3>().0.to_vec(),
    }
}

/// A mesh for drawing: each vertex has one normal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnMesh {
    /// Positions, in the model's units.
    pub positions: Vec<DVec3>,
    /// As many unit normals.
    pub normals: Vec<DVec3>,
    /// Three vertices a triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Writes a GLB file of one mesh. Positions are in single precision about the middle of the mesh, where a node puts it.
///
/// # Errors
/// What `out` says, or where there are no triangles or more than 4 GiB of them.
pub fn write(out: &mut impl Write, mesh: &DrawnMesh, note: &str) -> io::Result<()> {
    let (low, high) = bounds(&mesh.positions).ok_or_else(|| io::Error::other("there is nothing to draw"))?;
    let middle = low.midpoint(high);
    let positions: Vec<[f32; 3]> = mesh
        .positions
        .iter()
        .map(|at| (*at - middle).as_vec3().to_array())
        .collect();
    let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|normal| normal.as_vec3().to_array()).collect();
    let vectors = [positions.as_flattened(), normals.as_flattened()].concat();
    let mut binary: Vec<u8> = vectors.iter().flat_map(|number| number.to_le_bytes()).collect();
    binary.extend(
        mesh.triangles
            .as_flattened()
            .iter()
            .flat_map(|corner| corner.to_le_bytes()),
    );
    let of_vertices = 12 * mesh.positions.len();
    let [least, most] = [low - middle, high - middle].map(|corner| corner.as_vec3().to_array());
    let json = json!({
        "asset": { "version": "2.0", "generator": "terrain-ingest", "extras": { "note": note } },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "translation": middle.to_array() }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2 }] }],
        "buffers": [{ "byteLength": binary.len() }],
        "bufferViews": [
            { "buffer": 0, "byteLength": of_vertices, "target": 34962 },
            { "buffer": 0, "byteOffset": of_vertices, "byteLength": of_vertices, "target": 34962 },
            { "buffer": 0, "byteOffset": 2 * of_vertices, "byteLength": 12 * mesh.triangles.len(), "target": 34963 },
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3",
                "min": least, "max": most,
            },
            { "bufferView": 1, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3" },
            { "bufferView": 2, "componentType": 5125, "count": 3 * mesh.triangles.len(), "type": "SCALAR" },
        ],
    });
    write_chunks(out, json.to_string().into_bytes(), binary)
}

/// Writes a GLB file of triangles to collide with: no normals. `positions` are east, north and up of `offset`; in the file, as the
/// format wants it, y is up and z is south.
///
/// # Errors
/// What `out` says, or where there are no triangles or more than 4 GiB of them.
pub fn write_for_collisions(
    out: &mut impl Write,
    offset: DVec3,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
) -> io::Result<()> {
    let turned: Vec<Vec3> = positions.iter().map(|at| Vec3::new(at.x, at.z, -at.y)).collect();
    let corners = turned.iter().map(|&at| (at, at));
    let (low, high) = corners
        .reduce(|(low, high), (a, b)| (low.min(a), high.max(b)))
        .ok_or_else(|| io::Error::other("there is nothing to collide with"))?;
    let numbers = turned.iter().flat_map(|at| at.to_array()).flat_map(f32::to_le_bytes);
    let corners = triangles.as_flattened().iter().flat_map(|corner| corner.to_le_bytes());
    let binary: Vec<u8> = numbers.chain(corners).collect();
    let of_vertices = 12 * positions.len();
    let json = json!({
        "asset": { "version": "2.0", "generator": "terrain-ingest" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "translation": [offset.x, offset.z, -offset.y] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "buffers": [{ "byteLength": binary.len() }],
        "bufferViews": [
            { "buffer": 0, "byteLength": of_vertices, "target": 34962 },
            { "buffer": 0, "byteOffset": of_vertices, "byteLength": 12 * triangles.len(), "target": 34963 },
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3",
                "min": low.to_array(), "max": high.to_array(),
            },
            { "bufferView": 1, "componentType": 5125, "count": 3 * triangles.len(), "type": "SCALAR" },
        ],
    });
    write_chunks(out, json.to_string().into_bytes(), binary)
}

/// The two chunks of a GLB file, each of whole words.
pub(super) fn write_chunks(out: &mut impl Write, mut json: Vec<u8>, binary: Vec<u8>) -> io::Result<()> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |count: usize| u32::try_from(count).map_err(|_| io::Error::other("a .glb file is smaller than 4 GiB"));
    out.write_all(MAGIC)?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&word(12 + 8 + json.len() + 8 + binary.len())?.to_le_bytes())?;
    for (kind, chunk) in [(JSON, json), (BINARY, binary)] {
        out.write_all(&word(chunk.len())?.to_le_bytes())?;
        out.write_all(kind)?;
        out.write_all(&chunk)?;
    }
    Ok(())
}

fn bounds(positions: &[DVec3]) -> Option<(DVec3, DVec3)> {
    let both = positions.iter().map(|&at| (at, at));
    both.reduce(|(low, high), (a, b)| (low.min(a), high.max(b)))
}

#[cfg(test)]
#[path = "gltf_tests.rs"]
mod tests;
