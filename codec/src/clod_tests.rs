#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use glam::I64Vec3;
use terrain_core::Mesh;
use terrain_core::curved::model::CurvedModel;
use terrain_core::curved::simplify::{Options, simplify};

use super::*;
use crate::damage;

/// Hills of `2 · side²` patches and their levels; a crease runs through the middle.
pub(crate) fn hills(side: u32) -> CurvedLevels {
    let across = side + 1;
    let height = |x: f64, y: f64| (x / 3.0).sin() + (y / 4.0).cos() + (x - f64::from(side / 2)).abs() / 5.0;
    let plan = |vertex: u32| (f64::from(vertex % across), f64::from(vertex / across));
    let positions = (0..across * across)
        .map(plan)
        .map(|(x, y)| DVec3::new(x, y, height(x, y)))
        .collect();
    let cells = (0..across * side).filter(|cell| cell % across < side);
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|cell| {
            [
                [cell, cell + 1, cell + across + 1],
                [cell, cell + across + 1, cell + across],
            ]
        })
        .collect();
    let slope = |x: f64, side_of: f64| (x / 3.0).cos() / 3.0 + side_of / 5.0;
    let normals = triangles.iter().map(|corners| {
        let middle = corners.iter().map(|&corner| plan(corner).0).sum::<f64>() / 3.0 - f64::from(side / 2);
        corners.map(|corner| {
            let (x, y) = plan(corner);
            DVec3::new(-slope(x, middle.signum()), (y / 4.0).sin() / 4.0, 1.0)
        })
    });
    let normals: Vec<_> = normals.collect();
    let model = CurvedModel::from_mesh(&Mesh { positions, triangles }, &normals).unwrap();
    simplify(model, &Options::default(), |_| ())
}

/// Of the box around all control points of all levels.
fn longest_side(levels: &CurvedLevels) -> f64 {
    let patches = (0..levels.len()).flat_map(|level| levels.level(level));
    let points: Vec<DVec3> = patches.flat_map(|patch| patch.patch.points).collect();
    let low = points.iter().copied().reduce(DVec3::min).unwrap();
    let high = points.iter().copied().reduce(DVec3::max).unwrap();
    (high - low).max_element()
}

fn back(bytes: &[u8]) -> Result<CurvedLevels, CurvedError> {
    decode(bytes, &CurvedLimits::default())
}

#[test]
fn every_level_comes_back_within_its_error_and_meets_as_before() {
    let levels = hills(12);
    assert!(levels.len() > 4 && levels.patch_count(levels.len() - 1) < 100);
    for bits in [12, 20, 30] {
        let read = back(&encode(&levels, bits).unwrap()).unwrap();
        assert_eq!(read.len(), levels.len());
        let step = longest_side(&levels) / f64::from(bits).exp2();
        for level in 0..levels.len() {
            for (given, read) in levels.level(level).zip(read.level(level)) {
                let moved = given.patch.deviation(&read.patch);
                assert!(
                    moved <= step * 0.87 && given.error + moved <= read.error,
                    "{moved} of {step}"
                );
                assert!(read.error <= (given.error + step) * 1.000_001);
                assert_eq!((given.creases, given.levels()), (read.creases, read.levels()));
            }
            let [given, read] = [levels.model(level), read.model(level)];
            for patch in 0..given.patches().len() as u32 {
                assert_eq!(given.neighbours(patch), read.neighbours(patch));
            }
        }
    }
}

#[test]
fn a_patch_takes_few_bytes() {
    let levels = hills(24);
    let bytes = encode(&levels, 20).unwrap();
    let points = levels.patches().len() * 10 * 24;
    assert!(7 * bytes.len() < points, "{} of {points}", bytes.len());
}

#[test]
fn what_was_read_is_written_as_it_was() {
    let bytes = encode(&hills(6), 20).unwrap();
    let again = encode(&back(&bytes).unwrap(), 20).unwrap();
    assert_eq!(back(&again).unwrap().len(), back(&bytes).unwrap().len());
    assert!(again.len().abs_diff(bytes.len()) < bytes.len() / 20);
}

#[test]
fn counts_above_the_limits_and_cut_files_are_refused_before_anything_is_made() {
    let bytes = encode(&hills(6), 20).unwrap();
    let limited = |levels, patches| decode(&bytes, &CurvedLimits { levels, patches });
    assert_eq!(limited(1, 9999), Err(DecodeError::Limit("the number of levels").into()));
    assert_eq!(limited(99, 9), Err(DecodeError::Limit("the number of patches").into()));
    assert_eq!(
        back(&bytes[..bytes.len() - 1]),
        Err(DecodeError::Truncated(bytes.len() - 1).into())
    );
    assert_eq!(
        back(b"SPMF\x01"),
        Err(DecodeError::Magic("file of curved levels").into())
    );
    let longer = [bytes.as_slice(), &[0]].concat();
    assert!(back(&longer).is_err());
    assert_eq!(encode(&hills(2), 60), Err(EncodeError::TooFine(60)));
}

#[test]
fn thirds_and_averages_are_rounded_down() {
    let [from, to] = [I64Vec3::new(0, -1, 5), I64Vec3::new(10, -1, -5)];
    assert_eq!(lattice::third(from, to, 1), I64Vec3::new(3, -1, 1));
    assert_eq!(lattice::average([from, from, from, to, to, to]), I64Vec3::new(5, -1, 0));
}

/// Whatever is read can be drawn at every level.
#[test]
fn damaged_seeds_give_levels_that_can_be_drawn_or_an_error() {
    let seeds = damage::seeds("clod");
    assert!(!seeds.is_empty(), "the corpus has levels");
    for seed in seeds {
        let mut random = fastrand::Rng::with_seed(1);
        let accepted = (0..500).filter(|_| {
            let mut bytes = seed.clone();
            for _ in 0..random.usize(1..5) {
                let at = random.usize(..bytes.len());
                bytes[at] = random.u8(..);
            }
            back(&bytes).is_ok_and(|levels| {
                assert!(
                    (0..levels.len()).all(|level| levels.model(level).patches().len() == levels.patch_count(level))
                );
                true
            })
        });
        assert!(accepted.count() < 350);
    }
}
