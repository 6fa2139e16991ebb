#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

/// A point that places are far from; those in odd columns do not count.
struct Point {
    at: DVec3,
    asked: usize,
}

fn counts(place: &Place) -> bool {
    (place.grid.x as usize).is_multiple_of(2)
}

impl Far for Point {
    fn distance(&mut self, on_ellipsoid: DVec3) -> Result<f64> {
        self.asked += 1;
        Ok(on_ellipsoid.distance(self.at))
    }

    fn add(&mut self, places: &[Place], worst: &mut Worst) -> Result<()> {
        for place in places.iter().filter(|place| counts(place)) {
            worst.meet(self.distance(place.on_ellipsoid)?, place.grid);
        }
        Ok(())
    }
}

#[test]
fn the_farthest_of_many_is_found_by_asking_for_few() {
    let place = |column: usize, row: usize| Place {
        grid: DVec2::new(column as f64, row as f64),
        on_ellipsoid: DVec3::new(column as f64, 2.0 * row as f64, 0.0),
    };
    let places: Vec<Place> = (0..101)
        .flat_map(|row| (0..300).map(move |column| place(column, row)))
        .collect();
    for at in [DVec3::ZERO, DVec3::new(120.0, 90.0, 5.0), DVec3::new(700.0, -50.0, 0.0)] {
        let mut point = Point { at, asked: 0 };
        let found = farthest(places.clone(), &mut point).unwrap();
        let far = places.iter().filter(|place| counts(place));
        let expected = far.map(|place| place.on_ellipsoid.distance(at)).fold(0.0, f64::max);
        assert_eq!(found.figure, expected);
        assert!(point.asked < places.len() / 20, "{}", point.asked);
    }
    assert_eq!(
        farthest(
            Vec::new(),
            &mut Point {
                at: DVec3::ZERO,
                asked: 0
            }
        )
        .unwrap(),
        Worst::default()
    );
}
