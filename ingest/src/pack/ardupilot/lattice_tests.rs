use super::*;

const SYDNEY: Lattice = Lattice {
    longitude: 151,
    latitude: -34,
    spacing: 100,
};

/// Worked out by hand: 2400 m × 89.83204650878906 = 215,596.9 units; at −33.98922° the cosine is 0.8291…
#[test]
fn blocks_begin_where_the_autopilot_counts_to() {
    assert_eq!(SYDNEY.block([0, 0]), [-340_000_000, 1_510_000_000]);
    let [latitude, longitude] = SYDNEY.block([1, 1]);
    assert_eq!(latitude, -340_000_000 + 215_596);
    let expected = 2_800.0 * 89.832_046_508_789_06 / (33.989_220_2_f64).to_radians().cos();
    assert!(
        (f64::from(longitude - 1_510_000_000) - expected).abs() <= 1.0,
        "{longitude}"
    );
}

#[test]
fn a_file_has_as_many_blocks_as_a_degree_and_room_for_two_more() {
    // 0.8290 × 111,319 m + 6,400 m, in blocks of 2,800 m; 111,319 m in blocks of 2,400 m.
    assert_eq!(SYDNEY.blocks_in_row(), 35);
    assert_eq!(SYDNEY.rows(), 47);
    let equator = Lattice {
        longitude: -180,
        latitude: 0,
        spacing: 30,
    };
    assert_eq!(equator.blocks_in_row(), ((111_318.8 + 1_920.0) / 840.0) as u32);
}

/// The autopilot asks how far a place is from the corner; for a post that is a whole number of spacings.
#[test]
fn posts_are_whole_spacings_from_the_corner_by_the_autopilots_own_measure() {
    for lattice in [
        SYDNEY,
        Lattice {
            longitude: 8,
            latitude: 61,
            spacing: 30,
        },
    ] {
        let (block, post) = ([17, 23], [27, 31]);
        let Place { longitude, latitude } = lattice.post(block, post);
        let north = (latitude - f64::from(lattice.latitude)) * 111_318.845;
        let half_way = (latitude + f64::from(lattice.latitude)) / 2.0;
        let east = (longitude - f64::from(lattice.longitude)) * 111_318.845 * half_way.to_radians().cos();
        let spacing = f64::from(lattice.spacing);
        let expected = [(17 * 24 + 27) as f64 * spacing, (23 * 28 + 31) as f64 * spacing];
        assert!(
            (north - expected[0]).abs() < 0.02 && (east - expected[1]).abs() < 0.02,
            "{north} {east}"
        );
    }
}
