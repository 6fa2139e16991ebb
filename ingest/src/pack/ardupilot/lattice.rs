//! Where the autopilot looks for heights, in its own arithmetic (ArduPilot, `AP_Terrain` and `Location`): a flat Earth about the
//! south-west corner of a degree, whose metres east are scaled by the cosine of the latitude half-way. Whatever is truer is wrong here.
//!
//! ```text
//! degree ─▶ posts every so many metres north and east of its corner ─▶ blocks of 28 × 32 posts, 24 and 28 posts apart
//! ```

use terrain_tiles::ground::Place;

/// Posts of a block northwards and eastwards.
pub(super) const POSTS: [u32; 2] = [28, 32];
/// Posts from block to block: blocks overlap by four.
pub(super) const STEP: [u32; 2] = [24, 28];
/// Metres in 10⁻⁷ degrees of latitude, single precision.
const METRES_IN_UNIT: f32 = 0.011_131_884_5;
/// The inverse, in single precision, too.
const UNITS_IN_METRE: f32 = 89.832_05;
/// 10⁻⁷ degrees in a degree.
const UNITS: f64 = 1e7;
/// The cosine is never taken as less.
const LEAST_SCALE: f64 = 0.01;

/// The posts of one file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    /// Whole degrees of the south-west corner.
    pub(super) longitude: i16,
    pub(super) latitude: i8,
    /// Metres from post to post.
    pub(super) spacing: u16,
}

impl Lattice {
    /// Blocks in a row of the file: those of the degree at its south side, and of two blocks more.
    pub(super) fn blocks_in_row(self) -> u32 {
        let [latitude, longitude] = self.corner();
        let spacing = f64::from(self.spacing);
        let room = 2.0 * spacing * f64::from(POSTS[1]);
        let [_, end] = offset([latitude, longitude + UNITS], [0.0, room]);
        let metres = (end - longitude) * scale(latitude) * f64::from(METRES_IN_UNIT);
        (metres / (spacing * f64::from(STEP[1]))) as u32
    }

    /// Rows of blocks of the file: those that begin in the degree.
    pub(super) fn rows(self) -> u32 {
        let begins_here = |row: &u32| self.block([*row, 0])[0] < self.corner()[0] as i32 + UNITS as i32;
        (0..).take_while(begins_here).count() as u32
    }

    /// Latitude and longitude of a block's south-west post, as the autopilot compares them: 10⁻⁷ degrees.
    pub(super) fn block(self, index: [u32; 2]) -> [i32; 2] {
        offset(self.corner(), self.metres(index, [0, 0])).map(|degrees| degrees as i32)
    }

    /// Where the autopilot is when it takes the height of a post of a block as the ground's.
    pub(super) fn post(self, block: [u32; 2], post: [u32; 2]) -> Place {
        let [latitude, longitude] = self.corner();
        let [north, east] = self
            .metres(block, post)
            .map(|metres| metres / f64::from(METRES_IN_UNIT));
        let middle = latitude + north / 2.0;
        let longitude = (longitude + east / scale(middle)) / UNITS;
        Place::turned(longitude, ((latitude + north) / UNITS).min(90.0))
    }

    /// Metres north and east of the corner.
    fn metres(self, block: [u32; 2], post: [u32; 2]) -> [f64; 2] {
        [0, 1].map(|axis| f64::from((block[axis] * STEP[axis] + post[axis]) * u32::from(self.spacing)))
    }

    /// 10⁻⁷ degrees.
    fn corner(self) -> [f64; 2] {
        [f64::from(self.latitude), f64::from(self.longitude)].map(|degrees| degrees * UNITS)
    }
}

/// A place, in 10⁻⁷ degrees, so many metres north and east of another; each step is cut off to whole numbers.
fn offset([latitude, longitude]: [f64; 2], [north, east]: [f64; 2]) -> [f64; 2] {
    let up = (north * f64::from(UNITS_IN_METRE)).trunc();
    let across = (east * f64::from(UNITS_IN_METRE) / scale(latitude + up * 0.5)).trunc();
    [latitude + up, longitude + across]
}

/// How much shorter a degree of longitude is at a latitude in 10⁻⁷ degrees.
fn scale(latitude: f64) -> f64 {
    let cosine = f64::from((latitude / UNITS).to_radians() as f32).cos() as f32;
    f64::from(cosine).max(LEAST_SCALE)
}

#[cfg(test)]
#[path = "lattice_tests.rs"]
mod tests;
