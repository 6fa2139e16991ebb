use super::*;

#[test]
fn a_plane_has_its_gradient_however_few_of_its_heights_are_measured() {
    let offsets = array::from_fn(|y| array::from_fn(|x| [1.5 * (x as f64 - 3.0), 3.0 - y as f64]));
    let plane = |y: usize, x: usize| 100.0 + 3.0 * x as f64 - 5.0 * y as f64;
    let whole = gradient(|y, x| Some(plane(y, x)), &offsets);
    let half = gradient(|y, x| (x + y < 6).then(|| plane(y, x)), &offsets);
    for [east, north] in [whole, half] {
        assert!(
            (east - 2.0).abs() < 1e-12 && (north - 5.0).abs() < 1e-12,
            "{east} {north}"
        );
    }
    assert_eq!(gradient(|_, _| None, &offsets), [0.0; 2]);
    assert_eq!(gradient(|y, _| (y == 3).then_some(1.0), &offsets), [0.0; 2]);
}

#[test]
fn greys_tell_normals() {
    assert_eq!(greys([0.0, 0.0]), (128, 128));
    for slope in [-20.0, -0.3, -0.004, 0.02, 0.5, 3.0] {
        let (east, north) = greys([slope, 0.0]);
        let root = (f64::from(east) - 128.0) / 127.0;
        let normal = root * root.abs();
        assert!((normal + slope / slope.hypot(1.0)).abs() < 0.01, "{slope}: {normal}");
        assert_eq!(north, 128);
    }
}

#[test]
fn tiles_ask_for_the_same_places_along_their_common_side() {
    for (zoom, x, y) in [(11, 1090, 1436), (2, 7, 0), (6, 40, 63)] {
        let [west, east] = [0, 1].map(|beside| {
            let x = (x + beside) % (2 << zoom);
            Corners::new(TileAddress { zoom, x, y })
        });
        assert_eq!((west.width, west.margin), (east.width, east.margin));
        let [of_west, of_east] = [west.places(), east.places()];
        for row in 0..ROWS {
            for column in 0..=2 * west.margin as usize {
                let place = of_west[row * west.width + CELLS as usize + column];
                assert_eq!(place, of_east[row * west.width + column]);
                assert!(place.latitude.abs() <= 90.0 && place.longitude < 180.0);
            }
        }
    }
}

/// In cells, of a place in a raster.
fn row_and_column(at: usize) -> [i64; 2] {
    [at as i64 / i64::from(SIDE), at as i64 % i64::from(SIDE)].map(|corner| SPACING * corner)
}

/// The slope of a plane across a pole, whose heights are `rise` metres a metre along the Earth's first axis, at a row and a column.
fn slope_of_plane(address: TileAddress, rise: f64, row: i64, column: i64) -> [f64; 2] {
    let step = address.degrees() / CELLS as f64;
    let longitude = (i64::from(address.x) * CELLS + column) as f64 * step - 180.0;
    let frame = east_north_up(longitude, Corners::new(address).latitude(row + REACH));
    [frame.x_axis.x * rise, frame.y_axis.x * rise]
}

#[test]
fn light_is_that_of_a_plane_across_a_pole_up_to_the_pole() {
    let rise = 0.01;
    for (zoom, x, y) in [(0, 0, 0), (0, 1, 0), (1, 2, 1), (3, 7, 0), (3, 8, 0), (6, 127, 63)] {
        let address = TileAddress { zoom, x, y };
        let heights: Vec<Option<f64>> = Corners::new(address)
            .places()
            .iter()
            .map(|place| Some(rise * on_ellipsoid(DVec2::new(place.longitude, place.latitude)).x))
            .collect();
        let found: Vec<[f64; 2]> = gradients(address, &heights).collect();
        for (at, [east, north]) in found.into_iter().enumerate() {
            let [row, column] = row_and_column(at);
            let [true_east, true_north] = slope_of_plane(address, rise, row, column);
            let place = format!("{address}, row {row}, column {column}: {east} {north} for {true_east} {true_north}");
            assert!((north - true_north).abs() < 0.03 * rise, "{place}");
            // Beside the pole less of it may be told, never more.
            let is_less = east * true_east >= 0.0 && east.abs() <= true_east.abs();
            assert!((east - true_east).abs() < 0.03 * rise || is_less, "{place}");
            let cells_to_pole =
                (90.0 - Corners::new(address).latitude(row + REACH).abs()) * CELLS as f64 / address.degrees();
            let is_told = zoom == 0 || cells_to_pole > 6.0 * f64::from(1_u32 << (2 * zoom.saturating_sub(3)));
            assert!(!is_told || (east - true_east).abs() < 0.03 * rise, "{place}");
        }
    }
}

/// Where tiles meet the surface is nearer to the source than beside: at 0° and 180° that is so at every zoom.
#[test]
fn a_meridian_that_is_lower_is_no_wall_where_cells_are_narrow() {
    let address = TileAddress { zoom: 3, x: 8, y: 0 };
    let corners = Corners::new(address);
    let lower = |place: &Place| Some(if place.longitude == 0.0 { -100.0 } else { 0.0 });
    let heights: Vec<Option<f64>> = corners.places().iter().map(lower).collect();
    for (at, [east, north]) in gradients(address, &heights).enumerate() {
        let [row, _] = row_and_column(at);
        let rise = 100.0 / corners.cell_metres(row + REACH);
        let is_beside_the_pole = row > CELLS - 8;
        assert!(
            east.abs() < 0.6 * rise || is_beside_the_pole && east.abs() < 2.0 * rise,
            "row {row}: {east} of {rise}"
        );
        assert!(north.abs() < 0.5 * rise, "row {row}: {north} of {rise}");
    }
}
