//! Partitions that are refined from view to view: what is drawn, and that a client that writes anew only what it is told to draws it.

use std::sync::Arc;

use glam::DVec3;
use terrain_core::levels::collapse_log::Band;
use terrain_core::levels::replay::{Demand, Replay};
use terrain_core::levels::view_error::{View, ViewErrors};
use terrain_core::levels::view_refinement::ViewRefinement;
use terrain_core::selection::camera::HalfSpace;
use terrain_core::{CollapseLog, SurfacePartition};

use crate::consistency::{Field, field};

const FIELDS: u64 = 12;

/// The log of a random field in four bands, whose errors grow.
fn in_bands(mut log: CollapseLog) -> CollapseLog {
    let count = log.collapses.len();
    let bands = (1..=4).map(|band| Band {
        end: count * band / 4,
        error: band as f64,
    });
    log.bands = bands.collect();
    log
}

/// Partitions of one level for each band, and of one for each raw level.
fn partitions(field: &Field) -> [SurfacePartition; 2] {
    let log = in_bands(field.log.clone());
    let replay = Replay::run(&field.mesh, &log, Demand::Consistent, |_| ()).unwrap();
    [replay.band_batches(&log, 0.5), replay.level_batches(&log, 0.5)]
        .map(|batches| SurfacePartition::from_replay(&field.mesh, &replay, &batches).unwrap())
}

#[test]
fn the_log_of_a_partition_makes_the_partition_again() {
    for seed in 0..FIELDS {
        for partition in partitions(&field(seed)) {
            let (mesh, log) = partition.to_log();
            let again = SurfacePartition::from_log(&mesh, &log, 0.5).unwrap();
            assert_eq!(again, partition, "seed {seed}");
        }
    }
}

fn random_view(random: &mut fastrand::Rng) -> View {
    let mut place = |height: f64| DVec3::new(random.f64() * 100.0, random.f64() * 100.0, height);
    let (eye, ahead) = (place(12.0), place(5.0));
    let normal = (ahead - eye).normalize();
    let ahead_of_the_eye = HalfSpace {
        normal,
        offset: -normal.dot(eye),
    };
    View {
        eye,
        focal_length: 40.0 * random.f64(),
        frustum: random.bool().then_some(ahead_of_the_eye).into_iter().collect(),
    }
}

#[test]
fn of_every_view_that_and_no_more_is_split_which_it_needs_and_the_client_draws_it() {
    let mut splits = 0;
    for seed in 0..FIELDS {
        let field = field(seed);
        for partition in partitions(&field) {
            let mut refinement = ViewRefinement::new(&partition).unwrap();
            let (mesh, log) = partition.to_log();
            let mut field = Field::new(mesh, log, field.random.clone());
            let bands = field.log.bands.clone();
            let error = |at: usize| bands[bands.partition_point(|band| band.end <= at)].error;
            let errors: Vec<f64> = (0..field.log.collapses.len()).map(error).collect();
            let dag = Arc::clone(refinement.surface().dag());
            let errors = ViewErrors::new(&field.mesh, &field.log, &dag, &errors).unwrap();
            let (mut corners, mut positions) = (vec![], vec![DVec3::NAN; field.mesh.positions.len()]);
            for _ in 0..20 {
                let (view, within) = (random_view(&mut field.random), field.random.f64() * 3.0);
                splits += refinement.refine(&view, within).splits;
                field.check(refinement.surface());
                let mut is_needed: Vec<bool> = vec![];
                for collapse in 0..dag.len() as u32 {
                    let mut below = dag.constraints(collapse).iter();
                    let is_forced = below.any(|&needed| is_needed[needed as usize]);
                    is_needed.push(errors.screen_error(&view, collapse) > within || is_forced);
                }
                let is_right = |c: u32| refinement.surface().is_performed(c) != is_needed[c as usize];
                assert!((0..dag.len() as u32).all(is_right), "seed {seed}, {view:?}");
                let [places, vertices] = refinement.take_undrawn();
                let surface = refinement.surface();
                corners.resize(surface.triangles().len(), [0; 3]);
                for place in places {
                    corners[place as usize] = surface.corners(surface.triangles()[place as usize]);
                }
                for vertex in vertices {
                    positions[vertex as usize] = surface.position(vertex);
                }
                let there: Vec<[u32; 3]> = surface.triangles().iter().map(|&t| surface.corners(t)).collect();
                assert_eq!(corners, there);
                let mut drawn = there.iter().flatten();
                assert!(drawn.all(|&vertex| positions[vertex as usize] == surface.position(vertex)));
            }
            let [places, vertices] = refinement.take_undrawn();
            assert!(places.is_empty() && vertices.is_empty(), "nothing changed since");
        }
    }
    assert!(splits > 2000, "{splits}");
}
