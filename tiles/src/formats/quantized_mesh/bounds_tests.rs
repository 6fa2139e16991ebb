use super::*;
use terrain_codec::address::TileAddress;

use crate::formats::quantized_mesh::fixture::unmeasured;
use crate::outside::Outside;

#[test]
fn a_hemisphere_has_its_occlusion_point_far_out() {
    let root = unmeasured(TileAddress { zoom: 0, x: 0, y: 0 }, &[], &Outside::Ellipsoid);
    assert_eq!(root.horizon_occlusion_point.length(), 1e6);
    let pole = horizon_occlusion_point(DVec3::Z, &[DVec3::new(0.0, 0.0, SEMI_MINOR)]);
    assert!((pole - DVec3::Z).length() < 1e-15);
}
