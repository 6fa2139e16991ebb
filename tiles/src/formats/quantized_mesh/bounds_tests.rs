use super::*;
use crate::address::TileAddress;
use crate::formats::quantized_mesh::QuantizedMesh;
use crate::outside::Outside;

#[test]
fn a_hemisphere_has_its_occlusion_point_far_out() {
    let root = QuantizedMesh::unmeasured(TileAddress { zoom: 0, x: 0, y: 0 }, &[], &Outside::Ellipsoid);
    assert_eq!(root.horizon_occlusion_point.length(), 1e6);
    let pole = horizon_occlusion_point(DVec3::Z, &[DVec3::new(0.0, 0.0, SEMI_MINOR)]);
    assert!((pole - DVec3::Z).length() < 1e-15);
}

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
