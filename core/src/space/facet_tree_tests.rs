#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

fn random_facets(count: usize, seed: u64) -> (Vec<Facet>, fastrand::Rng) {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut point = || DVec3::new(random.f64(), random.f64(), random.f64());
    let facets = (0..count)
        .map(|_| {
            let middle = point() * 10.0;
            [middle + point(), middle + point(), middle + point()]
        })
        .collect();
    (facets, random)
}

#[test]
fn the_nearest_facet_is_that_of_all_wherever_the_search_begins() {
    for count in [1, 4, 5, 300] {
        let (facets, mut random) = random_facets(count, 5);
        let (tree, order) = FacetTree::new(&facets);
        for _ in 0..200 {
            let point = DVec3::new(random.f64(), random.f64(), random.f64()) * 12.0 - 1.0;
            let distances = facets.iter().map(|&facet| squared_to_triangle(point, facet));
            let least = distances.fold(f64::INFINITY, f64::min);
            let nearest = tree.nearest(point, random.u32(0..2 * count as u32), 0.0).unwrap();
            assert_eq!(nearest.squared, least);
            let facet = facets[order[nearest.facet as usize] as usize];
            assert_eq!(squared_to_triangle(point, facet), least);
            let some = tree.nearest(point, 0, least * 4.0).unwrap();
            assert!(
                (least..=least * 4.0).contains(&some.squared),
                "{} {least}",
                some.squared
            );
        }
    }
}

#[test]
fn no_facet_is_next_to_anything_in_an_empty_tree() {
    assert!(FacetTree::new(&[]).0.nearest(DVec3::ZERO, 0, 0.0).is_none());
}
