use super::*;

fn twice_area([a, b, c]: [DVec3; 3]) -> f64 {
    let [ab, ac] = [b - a, c - a];
    ab.y * ac.z - ab.z * ac.y
}

/// Every lattice covers its domain once: no triangle is turned over, and their areas add up.
#[test]
fn triangles_cover_the_domain_once_whatever_the_sides() {
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..500 {
        let is_gradual = random.bool();
        let steps: u32 = if is_gradual {
            1 << random.u32(0..6)
        } else {
            random.u32(1..20)
        };
        let cuts = [(); 3].map(|()| match is_gradual {
            true => EdgeCuts::gradual(1.0 + random.f64() * f64::from(steps - 1)),
            false => EdgeCuts::even(random.u32(1..=steps)),
        });
        let lattice = PatchLattice {
            steps,
            sides: [0, 1, 2].map(|side| (&cuts[side], random.bool())),
        };
        let areas = lattice
            .triangles()
            .map(|places| twice_area(places.map(|place| lattice.domain(place))));
        let areas: Vec<f64> = areas.collect();
        assert!(areas.iter().all(|&area| area > -1e-12), "{steps} {cuts:?} {areas:?}");
        assert!((areas.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn places_inside_are_counted_in_their_order() {
    let cuts = EdgeCuts::even(1);
    for steps in 1..12 {
        let lattice = PatchLattice {
            steps,
            sides: [(&cuts, false); 3],
        };
        let numbers: Vec<u32> = lattice.inside().map(|at| lattice.number_inside(at)).collect();
        assert_eq!(numbers, (0..lattice.count_inside()).collect::<Vec<_>>());
        assert_eq!(lattice.places().count(), 3 + numbers.len());
    }
}
