use super::*;

#[test]
fn oct_encoded_normals_are_within_a_degree() {
    assert_eq!(oct_encode(DVec3::Z), [128, 128]);
    assert_eq!(oct_encode(DVec3::X), [255, 128]);
    assert_eq!(oct_encode(DVec3::NEG_Z), [255, 255]);
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..2_000 {
        let mut unit = || f64::from(random.u32(..2_001)) / 1_000.0 - 1.0;
        let Some(vector) = DVec3::new(unit(), unit(), unit()).try_normalize() else {
            continue;
        };
        let angle = oct_decode(oct_encode(vector)).angle_between(vector).to_degrees();
        assert!(angle < 1.0, "{vector} {angle}");
    }
}
