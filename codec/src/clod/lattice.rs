//! The integer lattice of a file's control points.

use glam::{DVec3, I64Vec3};
use integer_encoding::VarInt;

use crate::DecodeError;
use crate::fields::Fields;

/// The longest side of a model is divided by two to this at most.
pub const MOST_BITS: u32 = 38;

/// Where lattice points are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lattice {
    /// Where (0, 0, 0) is.
    origin: DVec3,
    /// From one to the next along each axis; above 0.
    step: f64,
}

impl Lattice {
    /// The lattice of `2^bits` steps along the longest side of a box around points.
    pub(super) fn over(points: impl Iterator<Item = DVec3>, bits: u32) -> Self {
        let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.fold(nowhere, |(low, high), at| (low.min(at), high.max(at)));
        let side = (high - low).max_element();
        Self {
            origin: if low.is_finite() { low } else { DVec3::ZERO },
            step: if side > 0.0 && side.is_finite() {
                side / f64::from(bits).exp2()
            } else {
                1.0
            },
        }
    }

    pub(super) fn write(&self, bytes: &mut Vec<u8>) {
        let numbers = self.origin.to_array().into_iter().chain([self.step]);
        bytes.extend(numbers.flat_map(f64::to_le_bytes));
    }

    pub(super) fn read(fields: &mut Fields) -> Result<Self, DecodeError> {
        let [x, y, z, step] = fields.doubles()?;
        let origin = DVec3::new(x, y, z);
        if !origin.is_finite() || !step.is_normal() || step < 0.0 {
            return Err(DecodeError::OutOfRange("the lattice"));
        }
        Ok(Self { origin, step })
    }

    pub(super) fn nearest(&self, point: DVec3) -> I64Vec3 {
        ((point - self.origin) / self.step).round().as_i64vec3()
    }

    pub(super) fn point(&self, place: I64Vec3) -> DVec3 {
        self.origin + place.as_dvec3() * self.step
    }

    /// How far rounding moves a point at most, and with it a patch, which is in the hull of its control points: half a diagonal
    /// of the lattice's cubes, and what is lost in double precision.
    pub(super) fn rounding(&self) -> f64 {
        let reach = self.origin.abs().max_element() + self.step * f64::from(MOST_BITS).exp2();
        self.step * (3.0_f64.sqrt() / 2.0) + reach * 4.0 * f64::EPSILON
    }
}

/// The lattice point a third, or two, of the way from one to another, rounded down.
pub(super) fn third(from: I64Vec3, to: I64Vec3, thirds: i64) -> I64Vec3 {
    let sum = from * (3 - thirds) + to * thirds;
    I64Vec3::from_array(sum.to_array().map(|coordinate| coordinate.div_euclid(3)))
}

/// The average of six lattice points, rounded down.
pub(super) fn average(points: [I64Vec3; 6]) -> I64Vec3 {
    let sum: I64Vec3 = points.into_iter().sum();
    I64Vec3::from_array(sum.to_array().map(|coordinate| coordinate.div_euclid(6)))
}

/// Writes how far a lattice point is from where it is expected.
pub(super) fn write_offset(bytes: &mut Vec<u8>, expected: I64Vec3, place: I64Vec3) {
    let offset = place - expected;
    bytes.extend(offset.to_array().into_iter().flat_map(VarInt::encode_var_vec));
}

/// Reads a lattice point by how far it is from where it is expected.
pub(super) fn read_offset(fields: &mut Fields, expected: I64Vec3) -> Result<I64Vec3, DecodeError> {
    let offset = [
        fields.signed_number()?,
        fields.signed_number()?,
        fields.signed_number()?,
    ];
    let place = expected + I64Vec3::from_array(offset);
    let reach = 1_i64 << (MOST_BITS + 4);
    if place.abs().max_element() > reach {
        return Err(DecodeError::OutOfRange("a control point"));
    }
    Ok(place)
}
