//! Patches one after the other, with the vertices and curves that none before had.

use std::collections::HashMap;

use glam::I64Vec3;
use integer_encoding::VarInt;
use terrain_core::curved::levels::LevelPatch;
use terrain_core::curved::patch::{CENTRE, CORNERS, CURVES, CubicPatch};

use super::lattice::{Lattice, average, read_offset, third, write_offset};
use crate::DecodeError;
use crate::fields::Fields;
use crate::spt::rounded_up;

/// A curve that is there already: the vertices that it joins, by their numbers in the file, and its inner control points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Curve {
    ends: [u32; 2],
    inner: [I64Vec3; 2],
}

impl Curve {
    fn reversed(self) -> Self {
        let ([from, to], [first, second]) = (self.ends, self.inner);
        Self {
            ends: [to, from],
            inner: [second, first],
        }
    }
}

/// Writes patches.
pub(super) struct PatchWriter {
    lattice: Lattice,
    /// The number in the file of each vertex that was used, by its number in the levels and its place.
    vertices: HashMap<(u32, I64Vec3), u32>,
    last: I64Vec3,
    curves: HashMap<Curve, u32>,
}

impl PatchWriter {
    pub(super) fn new(lattice: Lattice) -> Self {
        Self {
            lattice,
            vertices: HashMap::new(),
            last: I64Vec3::ZERO,
            curves: HashMap::new(),
        }
    }

    pub(super) fn write(&mut self, bytes: &mut Vec<u8>, patch: &LevelPatch) {
        let levels = patch.levels();
        let creases = (0..3)
            .filter(|&curve| patch.creases[curve])
            .map(|curve| 1_u32 << curve)
            .sum::<u32>();
        bytes.extend(levels.start.encode_var_vec());
        bytes.extend((8 * u64::from(levels.end - levels.start) + u64::from(creases)).encode_var_vec());
        bytes.extend(rounded_up(patch.error + self.lattice.rounding()).to_le_bytes());
        let points = patch.patch.points.map(|point| self.lattice.nearest(point));
        let corners = [0, 1, 2].map(|corner| self.write_vertex(bytes, patch.corners[corner], points[CORNERS[corner]]));
        for (side, curve) in CURVES.iter().enumerate() {
            let [from, first, second, to] = curve.map(|point| points[point]);
            let curve = Curve {
                ends: [corners[side], corners[(side + 1) % 3]],
                inner: [first, second],
            };
            self.write_curve(bytes, curve, [from, to]);
        }
        write_offset(bytes, expected_centre(&points), points[CENTRE]);
    }

    /// 0 and where it is, or how many vertices ago it came up.
    fn write_vertex(&mut self, bytes: &mut Vec<u8>, vertex: u32, at: I64Vec3) -> u32 {
        let count = self.vertices.len() as u32;
        let number = *self.vertices.entry((vertex, at)).or_insert(count);
        bytes.extend((count - number).encode_var_vec());
        if number == count {
            write_offset(bytes, self.last, at);
            self.last = at;
        }
        number
    }

    /// 0 and its inner points, or twice how many curves ago it came up, and one more where it runs the other way.
    fn write_curve(&mut self, bytes: &mut Vec<u8>, curve: Curve, [from, to]: [I64Vec3; 2]) {
        let count = self.curves.len() as u32;
        if let Some(&number) = self.curves.get(&curve) {
            return bytes.extend((2 * u64::from(count - number)).encode_var_vec());
        }
        if let Some(&number) = self.curves.get(&curve.reversed()) {
            return bytes.extend((2 * u64::from(count - number) + 1).encode_var_vec());
        }
        bytes.push(0);
        write_offset(bytes, third(from, to, 1), curve.inner[0]);
        write_offset(bytes, third(from, to, 2), curve.inner[1]);
        self.curves.insert(curve, count);
    }
}

/// Reads patches.
pub(super) struct PatchReader {
    lattice: Lattice,
    levels: u32,
    vertices: Vec<I64Vec3>,
    last: I64Vec3,
    curves: Vec<Curve>,
}

impl PatchReader {
    pub(super) fn new(lattice: Lattice, levels: u32) -> Self {
        Self {
            lattice,
            levels,
            vertices: Vec::new(),
            last: I64Vec3::ZERO,
            curves: Vec::new(),
        }
    }

    pub(super) fn read(&mut self, fields: &mut Fields) -> Result<LevelPatch, DecodeError> {
        let first = fields.number()?;
        let lifetime = fields.number()?;
        let end = first.checked_add(lifetime / 8).filter(|&end| end <= self.levels);
        let end = end.ok_or(DecodeError::OutOfRange("the levels of a patch"))?;
        let error = f32::from_le_bytes(fields.bytes()?);
        let mut corners = [0; 3];
        for corner in &mut corners {
            *corner = self.read_vertex(fields)?;
        }
        let mut points = [I64Vec3::ZERO; 10];
        for (side, places) in CURVES.iter().enumerate() {
            let ends = [corners[side], corners[(side + 1) % 3]];
            let inner = self.read_curve(fields, ends)?;
            let [from, to] = ends.map(|vertex| self.vertices[vertex as usize]);
            for (&place, point) in places.iter().zip([from, inner[0], inner[1], to]) {
                points[place] = point;
            }
        }
        points[CENTRE] = read_offset(fields, expected_centre(&points))?;
        let patch = CubicPatch {
            points: points.map(|place| self.lattice.point(place)),
        };
        let creases = [0, 1, 2].map(|curve| lifetime >> curve & 1 == 1);
        Ok(LevelPatch::new(patch, corners, creases, f64::from(error)).shown_by(first..end))
    }

    fn read_vertex(&mut self, fields: &mut Fields) -> Result<u32, DecodeError> {
        let count = self.vertices.len() as u32;
        match fields.number()? {
            0 => {
                self.last = read_offset(fields, self.last)?;
                self.vertices.push(self.last);
                Ok(count)
            }
            ago => count.checked_sub(ago).ok_or(DecodeError::OutOfRange("a vertex")),
        }
    }

    fn read_curve(&mut self, fields: &mut Fields, ends: [u32; 2]) -> Result<[I64Vec3; 2], DecodeError> {
        let ago = fields.number()?;
        if ago == 0 {
            let [from, to] = ends.map(|vertex| self.vertices[vertex as usize]);
            let inner = [
                read_offset(fields, third(from, to, 1))?,
                read_offset(fields, third(from, to, 2))?,
            ];
            self.curves.push(Curve { ends, inner });
            return Ok(inner);
        }
        let found = self
            .curves
            .len()
            .checked_sub(ago as usize / 2)
            .and_then(|number| self.curves.get(number));
        let found = found.map(|curve| if ago % 2 == 1 { curve.reversed() } else { *curve });
        let found = found.filter(|curve| curve.ends == ends);
        found.map(|curve| curve.inner).ok_or(DecodeError::OutOfRange("a curve"))
    }
}

/// Where the centre is if the patch has that of the first pass of §5.1.
fn expected_centre(points: &[I64Vec3; 10]) -> I64Vec3 {
    average([1, 2, 3, 5, 7, 8].map(|place| points[place]))
}
