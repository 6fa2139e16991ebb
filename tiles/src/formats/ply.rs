//! PLY: read by the `ply-rs-bw` crate in all three encodings, written as little-endian binary.

use std::io::{self, BufRead, Write};

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};

use super::polygons::{Column, PolygonError, PolygonLimits, Polygons, Storage};

/// Names of the coordinates.
const AXES: [&str; 3] = ["x", "y", "z"];
/// Names that files have for the list of a face's corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Reads the elements `vertex` and `face` and skips all others. Scalar properties of vertices become columns.
///
/// # Errors
/// Where the bytes are of another format, or more than `limits` allow.
pub fn read(file: impl BufRead, limits: PolygonLimits) -> Result<Polygons, PolygonError> {
    let mut file = Reader::new(file);
    let vertices = Parser::<Vertex>::new();
    let header = vertices.read_header(&mut file).map_err(malformed)?;
    let mut polygons = Polygons::default();
    let mut faces = Vec::new();
    for (_, element) in &header.elements {
        check_count(element, limits)?;
        if element.name == "face" {
            faces = read_faces(&mut file, element, &header)?;
        } else {
            let read = vertices.read_payload_for_element(&mut file, element, &header);
            let read = read.map_err(malformed)?;
            if element.name == "vertex" {
                polygons.columns = columns(element, &read)?;
                polygons.positions = read.iter().map(|vertex| vertex.position).collect();
            }
        }
    }
    faces
        .iter()
        .try_for_each(|face: &Face| polygons.add_face(&face.0, limits))?;
    Ok(polygons)
}

fn read_faces(
    file: &mut Reader<impl BufRead>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<Face>, PolygonError> {
    let faces = Parser::<Face>::new().read_payload_for_element(file, element, header);
    faces.map_err(malformed)
}

fn check_count(element: &ElementDef, limits: PolygonLimits) -> Result<(), PolygonError> {
    match element.name.as_str() {
        "vertex" if element.count > limits.vertices as usize => {
            Err(PolygonError::TooLarge(limits.vertices, "vertices"))
        }
        "face" if element.count > limits.triangles as usize => Err(PolygonError::TooLarge(limits.triangles, "faces")),
        _ => Ok(()),
    }
}

/// The parser's message without the lines that it breaks into.
fn malformed(error: ParseError) -> PolygonError {
    PolygonError::Malformed {
        format: "PLY",
        reason: error.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

/// The scalar properties but for the position, in the order of the header, which is that of every vertex's numbers.
fn columns(element: &ElementDef, vertices: &[Vertex]) -> Result<Vec<Column>, PolygonError> {
    let named = element.properties.iter().map(|(_, property)| property);
    let mut columns = Vec::new();
    for property in named.filter(|property| !AXES.contains(&property.name.as_str())) {
        let PropertyType::Scalar(scalar) = &property.data_type else {
            continue;
        };
        let place = columns.len();
        let values: Option<Vec<f64>> = vertices
            .iter()
            .map(|vertex| vertex.numbers.get(place).copied())
            .collect();
        columns.push(Column {
            name: property.name.clone(),
            storage: storage(scalar),
            values: values.ok_or_else(|| PolygonError::Malformed {
                format: "PLY",
                reason: format!("a vertex has no `{}`", property.name),
            })?,
        });
    }
    Ok(columns)
}

fn storage(scalar: &ScalarType) -> Storage {
    match scalar {
        ScalarType::UChar => Storage::Byte,
        ScalarType::Float => Storage::Float,
        _ => Storage::Double,
    }
}

struct Vertex {
    position: DVec3,
    /// Other scalars, in the order of the header.
    numbers: Vec<f64>,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self {
            position: DVec3::NAN,
            numbers: Vec::new(),
        }
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let Some(value) = scalar(&property) else {
            return PropertyAccessResult::Ignored;
        };
        match AXES.iter().position(|axis| *axis == key) {
            Some(axis) => self.position[axis] = value,
            None => self.numbers.push(value),
        }
        PropertyAccessResult::Set
    }
}

fn scalar(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(value) => f64::from(value),
        Property::UChar(value) => f64::from(value),
        Property::Short(value) => f64::from(value),
        Property::UShort(value) => f64::from(value),
        Property::Int(value) => f64::from(value),
        Property::UInt(value) => f64::from(value),
        Property::Float(value) => f64::from(value),
        Property::Double(value) => value,
        _ => return None,
    })
}

struct Face(Vec<u64>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let Some(corners) = CORNERS.contains(&key).then(|| indices(property)).flatten() else {
            return PropertyAccessResult::Ignored;
        };
        self.0 = corners;
        PropertyAccessResult::Set
    }
}

/// A list of whole numbers; one below zero becomes one that no vertex has.
fn indices(property: Property) -> Option<Vec<u64>> {
    fn unsigned<T: TryInto<u64>>(numbers: Vec<T>) -> Option<Vec<u64>> {
        Some(
            numbers
                .into_iter()
                .map(|number| number.try_into().unwrap_or(u64::MAX))
                .collect(),
        )
    }
    match property {
        Property::ListChar(numbers) => unsigned(numbers),
        Property::ListUChar(numbers) => unsigned(numbers),
        Property::ListShort(numbers) => unsigned(numbers),
        Property::ListUShort(numbers) => unsigned(numbers),
        Property::ListInt(numbers) => unsigned(numbers),
        Property::ListUInt(numbers) => unsigned(numbers),
        _ => None,
    }
}

/// Writes a whole file: double coordinates, then the columns, then triangles; `note` becomes a comment.
///
/// # Errors
/// What `out` says.
pub fn write(
    out: &mut impl Write,
    positions: &[DVec3],
    columns: &[Column],
    triangles: &[[u32; 3]],
    note: Option<&str>,
) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    if let Some(note) = note {
        writeln!(out, "comment {note}")?;
    }
    writeln!(out, "element vertex {}", positions.len())?;
    AXES.iter()
        .try_for_each(|axis| writeln!(out, "property double {axis}"))?;
    for Column { name, storage, .. } in columns {
        writeln!(out, "property {} {name}", type_name(*storage))?;
    }
    writeln!(out, "element face {}", triangles.len())?;
    writeln!(out, "property list uchar uint vertex_indices\nend_header")?;
    for (vertex, position) in positions.iter().enumerate() {
        for coordinate in position.to_array() {
            out.write_all(&coordinate.to_le_bytes())?;
        }
        for column in columns {
            write_number(out, column.storage, column.values[vertex])?;
        }
    }
    for corners in triangles {
        out.write_all(&[3])?;
        for corner in corners {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}

fn type_name(storage: Storage) -> &'static str {
    match storage {
        Storage::Byte => "uchar",
        Storage::Float => "float",
        Storage::Double => "double",
    }
}

fn write_number(out: &mut impl Write, storage: Storage, value: f64) -> io::Result<()> {
    match storage {
        // The conversion saturates.
        Storage::Byte => out.write_all(&[value.round() as u8]),
        Storage::Float => out.write_all(&(value as f32).to_le_bytes()),
        Storage::Double => out.write_all(&value.to_le_bytes()),
    }
}
