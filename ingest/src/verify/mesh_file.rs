//! Plain meshes from PLY and OBJ files, and what such a file claims of itself in a comment.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use anyhow::{Context, bail, ensure};
use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::drawing::Drawing;

/// The words before the figures, after the comment sign.
const SIGNATURE: &str = "terrain-ingest certified error ";

/// The error that a mesh claims.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Metres.
    pub error: f64,
    /// `surface` where it holds at every point of the source's bilinear surface, `samples` where at samples only.
    pub bound: String,
}

/// Reads a triangle mesh: a `.ply` or an `.obj` file, by its name.
pub(super) fn read(path: &Path) -> anyhow::Result<Drawing> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let mesh = match extension.to_str() {
        Some("ply") => read_ply(path),
        Some("obj") => read_obj(path),
        _ => bail!("{}: not a .ply or .obj file", path.display()),
    };
    let mesh = mesh.with_context(|| format!("{}: not a readable mesh", path.display()))?;
    ensure!(!mesh.triangles.is_empty(), "{}: has no triangles", path.display());
    Ok(mesh)
}

/// The claim in the first comments of a mesh file, such as
/// `comment terrain-ingest certified error 9.98 bound surface`.
pub(super) fn read_claim(path: &Path) -> anyhow::Result<Option<Claim>> {
    const LINES: usize = 64;
    let file = File::open(path).with_context(|| path.display().to_string())?;
    let lines = BufReader::new(file).split(b'\n').take(LINES).map_while(Result::ok);
    let mut comments = lines
        .filter_map(|line| String::from_utf8(line).ok())
        .take_while(|line| line != "end_header");
    Ok(comments.find_map(|line| parse_claim(&line)))
}

fn parse_claim(line: &str) -> Option<Claim> {
    let text = line.strip_prefix("comment ").or(line.strip_prefix("# "))?;
    let (error, bound) = text.trim().strip_prefix(SIGNATURE)?.split_once(" bound ")?;
    Some(Claim {
        error: error.parse().ok()?,
        bound: bound.to_owned(),
    })
}

fn read_obj(path: &Path) -> anyhow::Result<Drawing> {
    let options = tobj::LoadOptions {
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let mut file = BufReader::new(File::open(path)?);
    let (models, _) = tobj::load_obj_buf(&mut file, &options, |_| Ok(Default::default()))?;
    let mut mesh = Drawing::default();
    for model in models.into_iter().map(|model| model.mesh) {
        ensure!(
            model.face_arities.iter().all(|&corners| corners == 3),
            "has faces that are no triangles"
        );
        let first = u32::try_from(mesh.positions.len())?;
        mesh.positions
            .extend(model.positions.chunks_exact(3).map(DVec3::from_slice));
        mesh.triangles.extend(
            model
                .indices
                .chunks_exact(3)
                .map(|face| [0, 1, 2].map(|i| first + face[i])),
        );
    }
    Ok(mesh)
}

fn read_ply(path: &Path) -> anyhow::Result<Drawing> {
    let mut file = Reader::new(BufReader::new(File::open(path)?));
    let (vertices, faces) = (Parser::<Vertex>::new(), Parser::<Face>::new());
    let header = vertices.read_header(&mut file)?;
    let mut mesh = Drawing::default();
    for (_, element) in &header.elements {
        if element.name == "face" {
            let read = faces.read_payload_for_element(&mut file, element, &header)?;
            mesh.triangles = read
                .into_iter()
                .map(Face::triangle)
                .collect::<Option<_>>()
                .context("has faces that are no triangles")?;
        } else {
            let read = vertices.read_payload_for_element(&mut file, element, &header)?;
            if element.name == "vertex" {
                mesh.positions = read.into_iter().map(|vertex| vertex.0).collect();
            }
        }
    }
    Ok(mesh)
}

struct Vertex(DVec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(DVec3::NAN)
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Float(value) => f64::from(value),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::Ignored,
        };
        match key {
            "x" => self.0.x = value,
            "y" => self.0.y = value,
            "z" => self.0.z = value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

struct Face(Vec<u32>);

impl Face {
    fn triangle(self) -> Option<[u32; 3]> {
        self.0.try_into().ok()
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        if key != "vertex_index" && key != "vertex_indices" {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListInt(corners) => corners
                .into_iter()
                .map(|corner| u32::try_from(corner).unwrap_or(u32::MAX))
                .collect(),
            Property::ListUInt(corners) => corners,
            _ => return PropertyAccessResult::Ignored,
        };
        PropertyAccessResult::Set
    }
}
