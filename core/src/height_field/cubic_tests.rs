#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

fn quadratic(at: DVec2) -> SlopedPoint {
    SlopedPoint {
        point: GridPoint {
            grid: at,
            height: 3.0 + at.x - 2.0 * at.y + 0.5 * at.x * at.x - at.x * at.y + 0.25 * at.y * at.y,
        },
        slope: DVec2::new(1.0 + at.x - at.y, -2.0 - at.x + 0.5 * at.y),
    }
}

fn random_place(random: &mut fastrand::Rng) -> DVec2 {
    DVec2::new(random.f64(), random.f64()) * 40.0
}

fn random_point(random: &mut fastrand::Rng) -> SlopedPoint {
    SlopedPoint {
        point: GridPoint {
            grid: random_place(random),
            height: random.f64() * 100.0,
        },
        slope: random_place(random) - 20.0,
    }
}

#[test]
fn quadratic_ground_is_met_exactly() {
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..200 {
        let corners = [(); 3].map(|()| quadratic(random_place(&mut random)));
        let cubic = Cubic::through(corners).unwrap();
        let [u, v] = [random.f64(), random.f64()];
        let [a, b, c] = corners.map(|corner| corner.point.grid);
        let at = a + (b - a) * u + (c - a) * (1.0 - u) * v;
        let expected = quadratic(at).point.height;
        assert!(
            (cubic.height(at) - expected).abs() < 1e-6 * (1.0 + expected.abs()),
            "{at}"
        );
    }
}

#[test]
fn triangles_with_an_edge_in_common_have_the_same_curve_there() {
    let mut random = fastrand::Rng::with_seed(2);
    for _ in 0..200 {
        let [a, b, c, d] = [(); 4].map(|()| random_point(&mut random));
        let [one, other] = [[a, b, c], [b, a, d]].map(|corners| Cubic::through(corners).unwrap());
        for share in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let at = a.point.grid.lerp(b.point.grid, share);
            assert!((one.height(at) - other.height(at)).abs() < 1e-6);
        }
        let b300_b210_b120_b030 = [0, 1, 3, 6].map(|index| one.control_heights[index]);
        let turned = [6, 3, 1, 0].map(|index| other.control_heights[index]);
        assert_eq!(b300_b210_b120_b030, turned);
    }
}

#[test]
fn slopes_at_corners_are_those_given() {
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..200 {
        let corners = [(); 3].map(|()| random_point(&mut random));
        let cubic = Cubic::through(corners).unwrap();
        for corner in corners {
            let SlopedPoint { point, slope } = corner;
            for step in [DVec2::X, DVec2::Y] {
                let step = step * 1e-5;
                let rise = cubic.height(point.grid + step) - cubic.height(point.grid - step);
                let sharpness = corners
                    .iter()
                    .map(|other| other.point.grid.distance(point.grid))
                    .fold(0.0, f64::max);
                assert!(
                    (rise / 2e-5 - slope.dot(step) / 1e-5).abs() < 1e-3 * (1.0 + sharpness),
                    "{corners:?}"
                );
            }
        }
    }
}

#[test]
fn what_is_asked_of_a_corner_is_what_the_triangle_is_off() {
    let mut random = fastrand::Rng::with_seed(4);
    for _ in 0..200 {
        let [a, b, c] = [(); 3].map(|()| random_point(&mut random));
        let unknown = Unknown::new(a.point.grid, b, c).unwrap();
        let cubic = Cubic::through([a, b, c]).unwrap();
        let (at, sample) = (random_place(&mut random), random.f64() * 100.0);
        let Asked {
            of_height,
            of_slope,
            target,
        } = unknown.asked(at - a.point.grid, sample);
        let left = of_height * a.point.height + of_slope.dot(a.slope) - target;
        let expected = cubic.height(at) - sample;
        assert!(
            (left - expected).abs() < 1e-6 * (1.0 + expected.abs()),
            "{left} {expected}"
        );
    }
}
