#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_codec::LevelLimits;
use terrain_codec::spt;

use super::*;

fn golden() -> Tile {
    let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../codec/golden/jacksboro_v3.spt")).unwrap();
    spt::decode(&bytes, &LevelLimits::default()).unwrap()
}

#[test]
fn a_summary_has_the_levels_of_the_inside_and_holds_every_vertex() {
    let tile = golden();
    let summary = Summary::of(&tile, 7).unwrap();
    assert_eq!(summary.levels.len(), tile.interior_levels());
    for (interior, level) in summary.levels.iter().enumerate() {
        let is_finest = interior + 1 == summary.levels.len();
        let detail = terrain_codec::tile::Detail {
            interior,
            fine_sides: [is_finest; 4],
        };
        assert_eq!(level.triangles, tile.surface(detail).triangles.len() as u64);
        assert_eq!((level.error, level.bytes), (tile.partition.levels[interior].error, 7));
        for position in tile.surface(detail).positions {
            assert!(summary.bounds.distance(tile.earth_centred(position)) < 1e-6);
        }
    }
}

#[test]
fn boxes_of_parents_hold_those_of_their_children() {
    let leaf = golden();
    let summary = |address| {
        let moved = Tile {
            address,
            ..leaf.clone()
        };
        (address, Summary::of(&moved, 1).unwrap())
    };
    let above: Vec<TileAddress> = std::iter::successors(Some(leaf.address), |tile| tile.parent()).collect();
    let pyramid = Pyramid::new(above.iter().copied().map(summary));
    assert_eq!(pyramid.len(), above.len());
    assert_eq!(pyramid.roots().collect::<Vec<_>>(), above[above.len() - 1..]);
    for pair in above.windows(2) {
        let (inner, outer) = (pyramid.bounds(pair[0]), pyramid.bounds(pair[1]));
        assert_eq!(pyramid.children(pair[1]).collect::<Vec<_>>(), [pair[0]]);
        for axis in outer.axes {
            let offset = (inner.centre - outer.centre).dot(axis).abs();
            assert!(offset + inner.reach(axis) <= outer.reach(axis) + 1e-6);
        }
    }
}

#[test]
fn a_tile_without_its_parent_is_left_out_with_all_below_it() {
    let tile = golden();
    let summary = Summary::of(&tile, 1).unwrap();
    let [root, child] = [TileAddress::new(0, 1, 0).unwrap(), TileAddress::new(1, 3, 1).unwrap()];
    let orphan = TileAddress::new(2, 0, 0).unwrap();
    let all = [root, child, orphan, orphan.children()[2]];
    let pyramid = Pyramid::new(all.map(|address| (address, summary.clone())));
    assert_eq!(all.map(|address| pyramid.contains(address)), [true, true, false, false]);
}
