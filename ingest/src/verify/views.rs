//! What a client draws for a random camera over an archive, of which all or some is loaded.
//!
//! ```text
//! an eye above a random tile, from metres to a thousand kilometres, looks at another one
//! all is loaded, or of the tiles below the roots each by chance
//! the selection, as a library has it, says which tiles, levels and sides
//! ```

use std::collections::{BTreeMap, BTreeSet};

use fastrand::Rng;
use glam::DVec3;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{SEMI_MAJOR, SEMI_MINOR};
use terrain_core::selection::camera::{Camera, Ellipsoid, HalfSpace};
use terrain_core::selection::hierarchy::Hierarchy;
use terrain_core::selection::select::{Demand, select};
use terrain_tiles::pyramid::Pyramid;

use super::drawing::Shown;
use super::mixes::Interiors;

/// Metres that no surface is below the ellipsoid, the deepest sea and a coarse tile's error included.
const DEEPEST: f64 = 100_000.0;

/// The mix that is selected for one camera.
pub(super) fn random(pyramid: &Pyramid, tiles: &Interiors, seed: u64) -> BTreeMap<TileAddress, Shown> {
    const LOADED: f64 = 0.7;
    let mut random = Rng::with_seed(seed);
    let there: Vec<TileAddress> = tiles.keys().copied().filter(|&tile| pyramid.contains(tile)).collect();
    let Some(camera) = camera(pyramid, &there, &mut random) else {
        return BTreeMap::new();
    };
    let is_partial = random.bool();
    let is_loaded = |tile: &TileAddress| tile.zoom == 0 || !is_partial || random.f64() < LOADED;
    let loaded: BTreeSet<TileAddress> = there.into_iter().filter(is_loaded).collect();
    let demand = Demand {
        tolerance: f64::from(1_u8 << (seed % 5)),
        keep: 1.0,
        triangles: u64::MAX,
        bytes: u64::MAX,
    };
    let selection = select(pyramid, &camera, &demand, |tile| loaded.contains(&tile), &[]);
    let shown = selection.choices.into_iter().map(|choice| {
        let shown = Shown {
            interior: choice.level,
            fine_sides: choice.fine_sides,
        };
        (choice.node, shown)
    });
    shown.collect()
}

fn camera(pyramid: &Pyramid, tiles: &[TileAddress], random: &mut Rng) -> Option<Camera> {
    let below = pyramid.bounds(random.choice(tiles.iter().copied())?);
    let [east, north, up] = below.axes;
    let aside = east * (below.half_sizes[0] * random.f64()) + north * (below.half_sizes[1] * random.f64());
    let height = below.half_sizes[2] + 10_f64.powf(6.0 * random.f64());
    let eye = below.centre + aside + up * height;
    let target = pyramid.bounds(random.choice(tiles.iter().copied())?).centre;
    Some(Camera {
        eye,
        frustum: frustum(eye, (target - eye).try_normalize()?),
        pixels_per_radian: 1000.0,
        farthest: f64::INFINITY,
        ground: Some(Ellipsoid {
            centre: DVec3::ZERO,
            axis: DVec3::Z,
            equatorial: SEMI_MAJOR - DEEPEST,
            polar: SEMI_MINOR - DEEPEST,
        }),
    })
}

/// What is within half a right angle around a direction, to the sides and up and down.
fn frustum(eye: DVec3, ahead: DVec3) -> Vec<HalfSpace> {
    let (right, up) = ahead.any_orthonormal_pair();
    let normals = [ahead + right, ahead - right, ahead + up, ahead - up];
    let half_space = |normal: DVec3| HalfSpace {
        normal,
        offset: -normal.dot(eye),
    };
    normals.map(half_space).to_vec()
}
