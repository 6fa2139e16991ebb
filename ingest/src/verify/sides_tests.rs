#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use glam::DVec2;
use terrain_codec::filled::Filled;
use terrain_codec::tile::Lineage;
use terrain_core::SurfacePartition;

use super::*;
use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;

fn tile(zoom: u8, x: u32, y: u32) -> Tile {
    Tile {
        address: TileAddress { zoom, x, y },
        extent_bits: 10 - zoom,
        height_exponent: 0,
        sampling: None,
        lineage: Lineage::default(),
        breaklines: Vec::new(),
        filled: Filled::default(),
        partition: SurfacePartition::default(),
        outline_errors: Vec::new(),
    }
}

/// Eleven columns from 179° to 181° east, with a void half where the test says.
fn across_the_antimeridian(is_void: impl Fn(usize) -> bool) -> HeightGrid {
    let height = |index: usize| if is_void(index % 11) { f32::NAN } else { 0.0 };
    HeightGrid {
        columns: 11,
        rows: 11,
        heights: (0..121).map(height).collect(),
        georeference: GeoReference::wgs84(11, 11, DVec2::new(179.0, 11.0), DVec2::new(0.2, -0.2)),
    }
}

#[test]
fn one_place_is_one_node_whichever_tile_and_zoom_it_is_seen_from() {
    let corner = |tile: &Tile, x: f64, y: f64| node(tile, DVec3::new(x, y, 5.0));
    let (east, west) = (tile(1, 3, 0), tile(1, 0, 0));
    assert_eq!(corner(&east, 512.0, 7.0), corner(&west, 0.0, 7.0));
    assert_eq!(
        corner(&tile(0, 1, 0), 600.0, 700.0),
        corner(&tile(1, 3, 1), 88.0, 188.0)
    );
    assert_eq!(
        node(&west, DVec3::new(1.0, 1.0, 0.0)),
        node(&west, DVec3::new(1.0, 1.0, -0.0))
    );
}

#[test]
fn an_edge_on_the_antimeridian_is_one_sided_only_where_the_source_ends_on_it() {
    let (east, west) = (tile(1, 3, 1), tile(1, 0, 1));
    let edge = |tile: &Tile, x: f64| {
        [
            node(tile, DVec3::new(x, 57.0, 0.0)),
            node(tile, DVec3::new(x, 60.0, 0.0)),
        ]
    };
    let sided = |grid: &HeightGrid, tile: &Tile, side, x| {
        let source = Source::from(grid);
        is_one_sided(&source, tile.address, tile.extent_bits, side, edge(tile, x)).unwrap()
    };
    let whole = across_the_antimeridian(|_| false);
    assert!(!sided(&whole, &east, Side::East, 512.0) && !sided(&whole, &west, Side::West, 0.0));
    let half = across_the_antimeridian(|column| column > 5);
    assert!(sided(&half, &east, Side::East, 512.0) && !sided(&half, &west, Side::West, 0.0));
    let half = across_the_antimeridian(|column| column < 5);
    assert!(!sided(&half, &east, Side::East, 512.0) && sided(&half, &west, Side::West, 0.0));
}
