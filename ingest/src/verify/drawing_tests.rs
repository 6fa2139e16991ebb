use std::collections::BTreeSet;

use super::*;
use crate::verify::tests::fixture::{LEAF, ROOT, Sample};

fn corners(drawing: &Drawing) -> BTreeSet<[[u64; 3]; 3]> {
    let corner = |index: u32| drawing.positions[index as usize].to_array().map(f64::to_bits);
    drawing.triangles.iter().map(|triangle| triangle.map(corner)).collect()
}

#[test]
fn every_level_is_drawn_as_the_reader_of_tiles_draws_it() {
    let sample = Sample::of(|column, row| (column * column + 3 * row) as f32);
    for address in [LEAF, ROOT] {
        let tile = &sample.tiles[&address];
        let all = (0..interior_levels(tile)).map(coarse_sided).chain([finest(tile)]);
        let sizes: BTreeSet<usize> = all
            .map(|shown| {
                let theirs = tile.surface(terrain_codec::tile::Detail {
                    interior: shown.interior,
                    fine_sides: shown.fine_sides,
                });
                let ours = draw(tile, shown);
                let theirs = Drawing {
                    positions: theirs.positions,
                    triangles: theirs.triangles,
                };
                assert_eq!(corners(&ours), corners(&theirs), "{address} {shown:?}");
                assert_eq!(no_surface(&ours), None);
                ours.triangles.len()
            })
            .collect();
        assert!(sizes.len() >= 2, "{address} has one surface only");
    }
}

#[test]
fn what_is_no_surface_is_told() {
    let square = Drawing {
        positions: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| DVec3::new(x, y, 5.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    assert_eq!(no_surface(&square), None);
    let with = |triangle: [u32; 3]| Drawing {
        triangles: vec![[0, 1, 2], triangle],
        ..square.clone()
    };
    let tells = |drawing: &Drawing, what: &str| no_surface(drawing).is_some_and(|fault| fault.contains(what));
    assert!(tells(&with([0, 3, 2]), "triangle 1 is not counter-clockwise"));
    assert!(tells(&with([0, 0, 2]), "triangle 1 is not counter-clockwise"));
    assert!(tells(&with([0, 1, 3]), "two triangles run along edge 0–1"));
    assert!(tells(&with([0, 2, 4]), "triangle 1 has a corner that is not there"));
}

#[test]
fn a_tile_whose_arrays_do_not_fit_together_is_unsound() {
    let sample = Sample::new();
    let whole = &sample.tiles[&LEAF];
    assert_eq!(unsound(whole), None);
    let tells = |change: &dyn Fn(&mut Tile), what: &str| {
        let mut tile = whole.clone();
        change(&mut tile);
        let fault = unsound(&tile);
        assert!(fault.as_ref().is_some_and(|fault| fault.contains(what)), "{fault:?}");
    };
    tells(&|tile| tile.outline_errors.truncate(2), "outline errors");
    tells(&|tile| tile.partition.representatives.truncate(2), "one representative");
    tells(
        &|tile| tile.partition.levels[0].vertex_end = u32::MAX,
        "do not end where",
    );
    tells(
        &|tile| tile.partition.levels[1].error = 1e9,
        "larger error for a finer level",
    );
    tells(&|tile| tile.partition.levels[1].error = f64::NAN, "no number of metres");
    tells(&|tile| tile.partition.representatives[0] = 1, "does not come before it");
    tells(
        &|tile| tile.partition.triangles[0][1] = u32::MAX,
        "corner that is not there",
    );
    tells(&|tile| tile.partition.positions[0].z = f64::NAN, "off its lattice");
}
