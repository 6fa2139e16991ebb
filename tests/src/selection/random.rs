//! Pyramids, cameras and sets of loaded tiles by a seed.

use std::collections::{BTreeMap, BTreeSet};

use fastrand::Rng;
use glam::DVec3;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{self, Geodetic};
use terrain_core::selection::camera::Camera;
use terrain_core::selection::hierarchy::{Hierarchy, Level};
use terrain_core::selection::oriented_box::OrientedBox;
use terrain_tiles::pyramid::{Pyramid, Summary};

use super::{Answer, Case, Cases, Ground, Place, TileRecord, place, pyramid};

/// Stands for no budget; whole numbers up to it are numbers of JavaScript.
const NO_BUDGET: u64 = 1 << 50;
const DEEPEST: u8 = 8;
/// Metres that a camera is above the ground at most: some Earth radii.
const HIGHEST: f64 = 2e7;
/// No surface of any random tile is as low.
const LOWEST: f64 = -500.0;

/// The cases of a seed: `pyramids` of them, with `each` cameras over each.
#[must_use]
pub fn cases(pyramids: usize, each: usize, seed: u64) -> Cases {
    let mut random = Rng::with_seed(seed);
    let mut all = Cases {
        pyramids: Vec::new(),
        cases: Vec::new(),
    };
    for number in 0..pyramids {
        let records = tiles(&mut random);
        let pyramid = pyramid(&records);
        let places: Vec<TileAddress> = records.iter().map(|record| super::address(record.tile)).collect();
        let mut before: Option<Case> = None;
        let mut found = 0;
        while found < each {
            let case = case(number, &pyramid, &places, before.as_ref(), &mut random);
            before = Some(case.clone());
            // From afar two roots are enough; a few of those will do.
            if case.answer.choices.len() > 2 || random.u8(0..6) == 0 {
                all.cases.push(case);
                found += 1;
            }
        }
        all.pyramids.push(records);
    }
    all
}

/// A camera above one of some tiles, up to a height in metres, that looks at one of them.
///
/// # Panics
/// Where there are no tiles.
#[must_use]
pub fn camera(places: &[TileAddress], highest: f64, random: &mut Rng) -> Camera {
    fresh(0, places, highest, random).camera()
}

/// Tiles that exist, of which none is without its parent, and what they claim.
fn tiles(random: &mut Rng) -> Vec<TileRecord> {
    let exist = tree(random);
    let mut summaries: BTreeMap<TileAddress, Summary> = BTreeMap::new();
    for &address in &exist {
        let above = address.parent().and_then(|parent| summaries[&parent].levels.last());
        let summary = summary(address, above.map(|level| level.error), random);
        summaries.insert(address, summary);
    }
    let pyramid = Pyramid::new(summaries);
    let record = |&address: &TileAddress| {
        TileRecord::new(
            address,
            rounded(address, pyramid.bounds(address)),
            pyramid.levels(address),
        )
    };
    let records: Vec<TileRecord> = exist.iter().map(record).collect();
    let recorded = super::pyramid(&records);
    let is_kept = |record: &TileRecord| recorded.bounds(super::address(record.tile)) == record.summary().bounds;
    assert!(records.iter().all(is_kept), "a box holds the recorded boxes below it");
    records
}

/// Roots, refined towards some places and here and there, with tiles missing.
fn tree(random: &mut Rng) -> BTreeSet<TileAddress> {
    const MOST: usize = 150;
    let mut exist = BTreeSet::new();
    let roots = [0, 1].into_iter().filter_map(|x| TileAddress::new(0, x, 0));
    exist.extend(roots.filter(|_| random.u8(0..4) > 0));
    exist.extend(TileAddress::new(0, 1, 0).filter(|_| exist.is_empty()));
    let deepest = random.u8(3..=DEEPEST);
    let gaps = if random.bool() { 0.0 } else { 0.15 };
    for _ in 0..random.usize(1..4) {
        let mut tile = random.choice(exist.iter().copied().filter(|tile| tile.zoom == 0).collect::<Vec<_>>());
        while let Some(address) = tile.filter(|tile| tile.zoom < deepest && exist.len() < MOST) {
            exist.extend(address.children().into_iter().filter(|_| random.f64() >= gaps));
            tile = random.choice(address.children()).filter(|child| exist.contains(child));
        }
    }
    for _ in 0..random.usize(0..25) {
        let parent = random.choice(
            exist
                .iter()
                .copied()
                .filter(|tile| tile.zoom < deepest)
                .collect::<Vec<_>>(),
        );
        exist.extend(
            parent
                .into_iter()
                .flat_map(TileAddress::children)
                .filter(|_| random.f64() >= gaps),
        );
    }
    exist
}

/// `above` is the error of the parent's finest level.
fn summary(address: TileAddress, above: Option<f64>, random: &mut Rng) -> Summary {
    let bottom = LOWEST + 100.0 + 4000.0 * random.f64().powi(2);
    let heights = [bottom, bottom + 3000.0 * random.f64()];
    let finest = if random.u8(0..32) == 0 {
        0.0
    } else {
        above.unwrap_or(40_000.0) * (0.3 + 0.5 * random.f64())
    };
    let count = random.usize(1..6);
    let triangles = random.u64(20..3000);
    let level = |index: usize| Level {
        error: rounded_to(finest * (1.0 + (count - 1 - index) as f64 / 4.0), 1e3),
        triangles: triangles * (index as u64 + 1),
        bytes: triangles * 40,
    };
    Summary {
        bounds: bounds(address, heights),
        levels: (0..count).map(level).collect(),
    }
}

fn bounds(address: TileAddress, heights: [f64; 2]) -> OrientedBox {
    const STEPS: u32 = 8;
    let half = address.degrees() / 2.0;
    let turned = ellipsoid::east_north_up(address.west() + half, address.south() + half);
    let along = |from: f64, step: u32| from + address.degrees() * f64::from(step) / f64::from(STEPS);
    let points = (0..=STEPS).flat_map(|row| (0..=STEPS).map(move |column| (row, column)));
    let points = points.flat_map(|(row, column)| {
        heights.map(|height| {
            ellipsoid::to_earth_centred(Geodetic {
                longitude: along(address.west(), column),
                latitude: along(address.south(), row),
                height,
            })
        })
    });
    OrientedBox::around([turned.x_axis, turned.y_axis, turned.z_axis], points)
        .unwrap_or_else(|| unreachable!("there are points"))
}

/// The box in short numbers, and larger, so that rounding takes nothing from it and a parent's still holds its children's.
fn rounded(address: TileAddress, bounds: OrientedBox) -> OrientedBox {
    // A margin along turned axes reaches up to √3 times as far.
    let margin = 20.0 * f64::from(1_u32 << (DEEPEST + 1 - address.zoom));
    OrientedBox {
        centre: short(bounds.centre, 1e3),
        axes: bounds.axes.map(|axis| short(axis, 1e6)),
        half_sizes: bounds.half_sizes.map(|half| (half + margin).ceil()),
    }
}

fn short(vector: DVec3, steps: f64) -> DVec3 {
    DVec3::new(
        rounded_to(vector.x, steps),
        rounded_to(vector.y, steps),
        rounded_to(vector.z, steps),
    )
}

/// To whole parts, of which there are `steps` in 1; never −0.
fn rounded_to(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps + 0.0
}

fn case(number: usize, pyramid: &Pyramid, places: &[TileAddress], before: Option<&Case>, random: &mut Rng) -> Case {
    let follows = before.filter(|_| random.u8(0..5) < 2);
    let mut case = match follows {
        Some(before) => following(before, random),
        None => fresh(number, places, HIGHEST, random),
    };
    if random.u8(0..5) < 3 {
        case.loaded = Some(loaded(places, random));
    }
    case.answer = (&case.selection(pyramid)).into();
    if random.u8(0..3) == 0 {
        let all = case.answer.choices.len() as f64;
        let share = 0.05 + 1.2 * random.f64();
        // Of some 1500 triangles a tile.
        case.triangles = (1500.0 * all * share) as u64;
        case.bytes = if random.bool() { NO_BUDGET } else { case.triangles * 40 };
        case.answer = (&case.selection(pyramid)).into();
    }
    case
}

/// The same a moment later: for more tolerance, or from elsewhere.
fn following(before: &Case, random: &mut Rng) -> Case {
    let is_moved = random.u8(0..3) == 0;
    Case {
        before: before.answer.choices.clone(),
        eye: if is_moved {
            short(moved(before.eye.into(), random), 1e3).to_array()
        } else {
            before.eye
        },
        tolerance: if is_moved {
            before.tolerance
        } else {
            before.tolerance * 1.5
        },
        triangles: NO_BUDGET,
        bytes: NO_BUDGET,
        ..before.clone()
    }
}

/// Some way towards the Earth's centre or away from it, and to the side.
fn moved(eye: DVec3, random: &mut Rng) -> DVec3 {
    let height = (eye.length() - ellipsoid::SEMI_MINOR).abs();
    eye + eye.normalize() * height * (0.6 * random.f64() - 0.3) + DVec3::new(-eye.y, eye.x, 0.0) * 1e-4 * random.f64()
}

fn fresh(number: usize, places: &[TileAddress], highest: f64, random: &mut Rng) -> Case {
    let eye = short(eye(tile(places, random), highest, random), 1e3);
    let ahead = {
        let target = tile(places, random);
        let [longitude, latitude] = inside(target, random);
        let surface = ellipsoid::to_earth_centred(Geodetic {
            longitude,
            latitude,
            height: 0.0,
        });
        (surface - eye).normalize()
    };
    Case {
        pyramid: number,
        eye: eye.to_array(),
        frustum: frustum(eye, ahead, random),
        pixels_per_radian: rounded_to(300.0 + 1500.0 * random.f64(), 1e3),
        farthest: random
            .choice([None, None, None, Some(2e4), Some(2e5), Some(2e6)])
            .flatten(),
        ground: (random.u8(0..4) > 0).then_some(Ground {
            centre: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            equatorial: ellipsoid::SEMI_MAJOR + LOWEST,
            polar: rounded_to(ellipsoid::SEMI_MINOR, 1e3) + LOWEST,
        }),
        tolerance: *random.choice([&0.5, &1.0, &2.0, &4.0, &16.0]).unwrap_or(&2.0),
        keep: *random.choice([&1.0, &0.75, &0.5]).unwrap_or(&1.0),
        triangles: NO_BUDGET,
        bytes: NO_BUDGET,
        loaded: None,
        before: Vec::new(),
        answer: Answer {
            choices: Vec::new(),
            requests: Vec::new(),
            tolerance: None,
        },
    }
}

fn tile(places: &[TileAddress], random: &mut Rng) -> TileAddress {
    places[random.usize(..places.len())]
}

fn inside(tile: TileAddress, random: &mut Rng) -> [f64; 2] {
    [tile.west(), tile.south()].map(|from| from + tile.degrees() * random.f64())
}

/// Above a tile, from ten metres on.
fn eye(tile: TileAddress, highest: f64, random: &mut Rng) -> DVec3 {
    let [longitude, latitude] = inside(tile, random);
    let height = 10.0 * (highest / 10.0).powf(random.f64());
    ellipsoid::to_earth_centred(Geodetic {
        longitude,
        latitude,
        height,
    })
}

/// Four sides and the near plane.
fn frustum(eye: DVec3, ahead: DVec3, random: &mut Rng) -> Vec<[f64; 4]> {
    let right = ahead
        .cross(eye.normalize())
        .try_normalize()
        .unwrap_or(ahead.any_orthonormal_vector());
    let up = right.cross(ahead);
    let high = (0.2 + 0.4 * random.f64()).tan();
    let wide = high * (0.6 + random.f64());
    let normals = [
        ahead * wide + right,
        ahead * wide - right,
        ahead * high + up,
        ahead * high - up,
        ahead,
    ];
    let half_space = |normal: DVec3| {
        let normal = short(normal, 1e6);
        [normal.x, normal.y, normal.z, rounded_to(-normal.dot(eye) - 1.0, 1e3)]
    };
    normals.map(half_space).to_vec()
}

/// Coarse tiles more often than fine ones, and not always the roots.
fn loaded(places: &[TileAddress], random: &mut Rng) -> Vec<Place> {
    let share = 0.8 + 0.2 * random.f64();
    let is_loaded = |tile: &&TileAddress| random.f64() < share.powi(i32::from(tile.zoom) + 1);
    let found: Vec<TileAddress> = places.iter().filter(is_loaded).copied().collect();
    found.into_iter().map(place).collect()
}
