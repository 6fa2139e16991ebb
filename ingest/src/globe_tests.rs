use glam::DVec2;

use super::*;
use crate::height_grid::HeightGrid;

/// Degrees from column to column and from row to row.
const STEP: f64 = 15.0;
const COLUMNS: usize = 24;

/// Metres that tell where a sample is: hundreds of whole columns from −180° on, and rows from the north.
fn height(longitude: f64, row: usize) -> f32 {
    (100.0 * ((longitude + 180.0).rem_euclid(360.0) / STEP).floor() + row as f64) as f32
}

/// A grid from a longitude on whose first row is at a latitude; the first column is there again at the end if asked for.
fn grid(west: f64, north: f64, columns: usize, rows: usize) -> HeightGrid {
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (west + STEP * column as f64, row)));
    HeightGrid {
        columns,
        rows,
        heights: places.map(|(longitude, row)| height(longitude, row)).collect(),
        georeference: GeoReference::wgs84(columns, rows, DVec2::new(west, north), DVec2::new(STEP, -STEP)),
    }
}

fn all(globe: &Globe) -> Vec<f32> {
    let [columns, rows] = Raster::size(globe);
    globe.read(0..columns, 0..rows).unwrap().heights
}

#[test]
fn every_writing_of_a_raster_is_read_alike() {
    let at_points = [(-180.0, 24), (0.0, 24), (-180.0, 25), (20.0 * STEP, 25), (-75.0, 40)];
    let read = at_points.map(|(west, columns)| {
        let grid = grid(west, 75.0, columns, 11);
        let globe = Globe::around(&grid).unwrap();
        let fingerprint = globe.georeference().fingerprint();
        (Raster::size(&globe), globe.origin(), fingerprint, all(&globe))
    });
    for other in &read[1..] {
        assert!(*other == read[0], "{:?} {:?}", other.0, other.1);
    }
}

#[test]
fn samples_keep_their_places_and_go_on_through_the_antimeridian() {
    let grid = grid(22.5, 60.0, COLUMNS, 9);
    let globe = Globe::around(&grid).unwrap();
    let [columns, rows] = Raster::size(&globe);
    assert_eq!([columns, rows], [COLUMNS + 2 * BESIDE, 9]);
    let heights = all(&globe);
    for (index, &found) in heights.iter().enumerate() {
        let place = globe
            .georeference()
            .geographic(DVec2::new((index % columns) as f64, (index / columns) as f64));
        assert_eq!(found, height(place.x, index / columns), "{place}");
    }
    let [west, south, east, north] = globe.georeference().geographic_bounds();
    assert_eq!([west, south, east, north], [-180.0, -60.0, 180.0, 60.0]);
    let window = globe.read(3..columns - 5, 2..4).unwrap().heights;
    let cut: Vec<f32> = (2..4)
        .flat_map(|row| heights[row * columns..][3..columns - 5].to_vec())
        .collect();
    assert_eq!(window, cut);
}

#[test]
fn a_row_at_a_pole_has_one_height() {
    let grid = grid(0.0, 90.0, COLUMNS + 1, 13);
    let globe = Globe::around(&grid).unwrap();
    assert_eq!(Raster::size(&globe)[1], 13);
    let [columns, rows] = Raster::size(&globe);
    for row in [0, rows - 1] {
        let heights = globe.read(0..columns, row..row + 1).unwrap().heights;
        assert_eq!(heights, vec![1150.0 + row as f32; columns]);
    }
}

/// Half a cell before the pole: half-way to the row beyond, all columns have the same height.
#[test]
fn the_surface_comes_to_one_height_at_a_pole_between_rows() {
    let grid = grid(-180.0 + STEP / 2.0, 82.5, COLUMNS, 12);
    let globe = Globe::around(&grid).unwrap();
    let [columns, rows] = Raster::size(&globe);
    assert_eq!(rows, 14);
    for [row, mean] in [[0, 1150], [rows - 2, 1161]] {
        let pair = globe.read(0..columns, row..row + 2).unwrap().heights;
        let (beyond, nearest) = pair.split_at(columns);
        let half_way: Vec<f32> = beyond.iter().zip(nearest).map(|(a, b)| (a + b) / 2.0).collect();
        assert_eq!(half_way, vec![mean as f32; columns]);
    }
}

#[test]
fn voids_stay_and_a_sample_that_is_there_twice_is_taken_where_it_is_a_height() {
    let mut grid = grid(0.0, 60.0, COLUMNS + 1, 9);
    grid.heights[3 * 25] = f32::NAN;
    grid.heights[3 * 25 + 7] = f32::NAN;
    let globe = Globe::around(&grid).unwrap();
    let columns = Raster::size(&globe)[0];
    let row = globe.read(0..columns, 3..4).unwrap().heights;
    let at = |longitude: f64| row[BESIDE + ((longitude + 180.0) / STEP) as usize];
    assert_eq!(at(0.0), height(0.0, 3));
    assert!(at(105.0).is_nan());
    let once = &row[BESIDE..BESIDE + COLUMNS];
    assert_eq!(once.iter().filter(|height| height.is_nan()).count(), 1);
}

#[test]
fn other_rasters_have_sides() {
    let mut turned = grid(-180.0, 60.0, COLUMNS, 9);
    turned.georeference = GeoReference::wgs84(COLUMNS, 9, DVec2::new(180.0, 60.0), DVec2::new(-STEP, -STEP));
    let others = [grid(-180.0, 60.0, COLUMNS - 1, 9), grid(0.0, 60.0, 2, 9), turned];
    assert!(others.iter().all(|other| Globe::around(other).is_none()));
    let meant = GeoReference::wgs84(COLUMNS, 9, DVec2::new(-180.0, 60.0), DVec2::new(STEP * 1.0003, -STEP));
    let nearly = HeightGrid {
        georeference: meant,
        ..grid(-180.0, 60.0, COLUMNS, 9)
    };
    assert!(Globe::around(&nearly).is_some());
}
