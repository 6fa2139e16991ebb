#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::super::tests::{batches, square};
use super::*;

#[test]
fn any_level_follows_any_other() {
    let mesh = square();
    let coarsest = vec![[1, 2, 0], [2, 3, 0]];
    let middle = vec![[1, 2, 4], [2, 3, 4], [0, 1, 4], [3, 0, 4]];
    let expected = [mesh.triangles().to_vec(), middle, coarsest];
    let mut view = LevelView::default();
    for level in [2, 0, 1, 0, 2, 1] {
        view.set_level(&mesh, level).unwrap();
        assert_eq!(view.triangles(), expected[level], "level {level}");
        assert_eq!(view.positions(), &mesh.positions()[..6 - level]);
    }
}

#[test]
fn a_level_is_drawn_while_vertices_that_it_names_are_still_on_their_way() {
    let mut mesh = MultilevelMesh::default();
    let [coarse, ..] = batches();
    mesh.add_level(coarse).unwrap();
    let mut view = LevelView::default();
    view.set_level(&mesh, 0).unwrap();
    assert_eq!(view.triangles(), [[1, 2, 0], [2, 3, 0]]);
}

#[test]
fn a_geomorph_moves_the_new_vertices_from_their_representatives() {
    let mesh = square();
    let mut view = LevelView::default();
    view.set_fractional_level(&mesh, 0.25).unwrap();
    assert_eq!(view.triangles(), mesh.triangles());
    assert_eq!(view.positions()[4..], [[2.0, 2.0], [2.75, 2.0]]);
    view.set_fractional_level(&mesh, 1.75).unwrap();
    assert_eq!(view.positions()[4..], [[0.5, 0.5]]);
}

#[test]
fn a_level_of_64_bits_is_not_rounded_to_32() {
    let mesh = square();
    let mut view = LevelView::default();
    view.set_fractional_level(&mesh, 0.1).unwrap();
    assert!(
        (view.positions()[5][0] - 2.9).abs() < 1e-15,
        "{:?}",
        view.positions()[5]
    );
    view.set_fractional_level(&mesh, 0.1_f32).unwrap();
    assert!((view.positions()[5][0] - 2.9).abs() > 1e-9, "{:?}", view.positions()[5]);
}

#[test]
fn a_vertex_without_representative_is_at_its_own_place_at_once() {
    let mut mesh = MultilevelMesh::default();
    let [mut coarse, middle, mut fine] = batches();
    coarse.triangles = vec![[1, 2, 4], [2, 3, 4]];
    coarse.representatives = vec![(4, 0)];
    fine.triangles = vec![[4, 1, 5], [2, 4, 5]];
    for batch in [coarse, middle, fine] {
        mesh.add_level(batch).unwrap();
    }
    let mut view = LevelView::default();
    view.set_fractional_level(&mesh, 0.5).unwrap();
    assert_eq!(view.positions()[5], [3.0, 2.0]);
}

#[test]
fn whole_numbers_are_the_levels_themselves() {
    let mesh = square();
    let (mut whole, mut fractional) = (LevelView::default(), LevelView::default());
    for level in 0..3_u8 {
        whole.set_level(&mesh, level.into()).unwrap();
        fractional.set_fractional_level(&mesh, level).unwrap();
        assert_eq!(whole.positions(), fractional.positions());
        assert_eq!(whole.triangles(), fractional.triangles());
    }
}

#[test]
fn levels_that_are_not_there_are_refused_and_the_view_stays() {
    let mesh = square();
    let mut view = LevelView::default();
    view.set_level(&mesh, 1).unwrap();
    let before = view.clone();
    for level in [-0.5, 2.5, f32::NAN, f32::INFINITY] {
        assert!(view.set_fractional_level(&mesh, level).is_err(), "{level}");
    }
    let refusal = view.set_level(&mesh, 3).unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "level 3 does not exist; the mesh has 3 levels, 0 being the finest"
    );
    assert!(view.set_level(&MultilevelMesh::default(), 0).is_err());
    assert_eq!(view, before);
}
