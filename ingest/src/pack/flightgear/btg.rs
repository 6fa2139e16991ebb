//! A bucket's surface as FlightGear reads it (SimGear, `SGBinObject`), version 10, the least significant byte first:
//!
//! ```text
//! u16 10  u16 'GS'  u32 time  i32 number of objects
//! object: u8 kind  u32 properties  u32 elements  properties  elements
//! property: u8 kind  u32 bytes  bytes      element: u32 bytes  bytes
//!   0 sphere     f64 × 3 centre, Earth-centred metres  f32 radius
//!   1 positions  f32 × 3 each, metres from the centre
//!   2 normals    u8 × 3 each: −1 to 1 as 0 to 255
//!   3 textures   f32 × 2 each
//!  10 triangles  properties: 0 a material's name, 1 which numbers a corner has; then u32 position, normal, texture of each corner
//! ```

use glam::{DVec2, DVec3};

use super::cut::Cut;

const VERSION: u16 = 10;
const MAGIC: u16 = u16::from_be_bytes(*b"SG");
/// Files of the same ground are the same: no time.
const TIME: u32 = 0;
const SPHERE: u8 = 0;
const POSITIONS: u8 = 1;
const NORMALS: u8 = 2;
const TEXTURES: u8 = 3;
const TRIANGLES: u8 = 10;
const MATERIAL: u8 = 0;
const NUMBERS: u8 = 1;
/// Position, normal and texture.
const CORNER: u8 = 1 | 2 | 8;
/// Metres that a texture covers.
const TEXTURE: f64 = 1_000.0;

/// The file of what is in a bucket, and how far single precision moves a point of it, metres. `axes` are east and north at the
/// `centre`.
pub(super) fn encode(cut: &Cut, centre: DVec3, axes: [DVec3; 2], materials: &[&str]) -> (Vec<u8>, f64) {
    let offsets: Vec<DVec3> = cut.corners.iter().map(|corner| corner.position - centre).collect();
    let used: Vec<usize> = (0..materials.len())
        .filter(|material| cut.triangles.iter().any(|(of, _)| of == material))
        .collect();
    let mut file = Vec::new();
    file.extend(VERSION.to_le_bytes());
    file.extend(MAGIC.to_le_bytes());
    file.extend(TIME.to_le_bytes());
    file.extend((4 + used.len() as i32).to_le_bytes());
    let singles = |numbers: &mut dyn Iterator<Item = f64>| -> Vec<u8> {
        numbers.flat_map(|number| (number as f32).to_le_bytes()).collect()
    };
    // From the centre to what is furthest, as it is after rounding.
    let radius = offsets
        .iter()
        .map(|at| at.as_vec3().as_dvec3().length())
        .fold(0.0, f64::max);
    let mut sphere: Vec<u8> = centre.to_array().into_iter().flat_map(f64::to_le_bytes).collect();
    sphere.extend((radius as f32).next_up().to_le_bytes());
    put(&mut file, SPHERE, &[], &sphere);
    put(
        &mut file,
        POSITIONS,
        &[],
        &singles(&mut offsets.iter().flat_map(|at| at.to_array())),
    );
    let normals = cut.corners.iter().flat_map(|corner| corner.normal.to_array());
    let bytes: Vec<u8> = normals.map(|number| ((number + 1.0) * 127.5).round() as u8).collect();
    put(&mut file, NORMALS, &[], &bytes);
    let plan = offsets
        .iter()
        .map(|at| DVec2::new(at.dot(axes[0]), at.dot(axes[1])) / TEXTURE);
    put(
        &mut file,
        TEXTURES,
        &[],
        &singles(&mut plan.flat_map(|at| at.to_array())),
    );
    for material in used {
        let of_material = cut.triangles.iter().filter(|(of, _)| *of == material);
        let corners = of_material.flat_map(|(_, corners)| corners);
        let numbers: Vec<u8> = corners
            .flat_map(|corner| [corner.to_le_bytes(); 3].into_iter().flatten())
            .collect();
        let properties: [(u8, &[u8]); 2] = [(MATERIAL, materials[material].as_bytes()), (NUMBERS, &[CORNER])];
        put(&mut file, TRIANGLES, &properties, &numbers);
    }
    let moved = |at: &DVec3| (at.as_vec3().as_dvec3() - *at).length();
    (file, offsets.iter().map(moved).fold(0.0, f64::max))
}

/// An object of one element.
fn put(file: &mut Vec<u8>, kind: u8, properties: &[(u8, &[u8])], element: &[u8]) {
    file.push(kind);
    file.extend((properties.len() as u32).to_le_bytes());
    file.extend(1_u32.to_le_bytes());
    for (kind, bytes) in properties {
        file.push(*kind);
        file.extend((bytes.len() as u32).to_le_bytes());
        file.extend(*bytes);
    }
    file.extend((element.len() as u32).to_le_bytes());
    file.extend(element);
}
