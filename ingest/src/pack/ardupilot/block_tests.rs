use super::*;

const LATTICE: Lattice = Lattice {
    longitude: -85,
    latitude: 36,
    spacing: 100,
};

fn heights() -> Vec<Option<i16>> {
    (0..POSTS[0] * POSTS[1]).map(|post| Some(post as i16 - 400)).collect()
}

#[test]
fn fields_are_where_the_autopilot_reads_them() {
    let bytes = encode(LATTICE, [3, 5], &heights());
    assert_eq!(bytes.len(), BYTES);
    let short = |at: usize| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
    assert_eq!(bytes[..8], [255, 255, 255, 255, 255, 255, 255, 0]);
    assert_eq!([short(18), short(20)], [1, 100]);
    // The first post, its neighbour to the east, the one north of it.
    assert_eq!([short(22), short(24), short(22 + 64)], [-400, -399, -368]);
    assert_eq!([short(1814), short(1816), short(1818)], [3, 5, -85]);
    assert_eq!([bytes[1820], bytes[1821]], [36, 1]);
    assert!(bytes[1822..].iter().all(|&byte| byte == 0));
}

/// CRC-16/XMODEM, bit by bit.
#[test]
fn the_checksum_is_that_of_all_before_the_minor_version() {
    let mut bytes = encode(LATTICE, [3, 5], &heights());
    let stored = u16::from_le_bytes([bytes[16], bytes[17]]);
    bytes[16..18].fill(0);
    let checksum = bytes[..1821].iter().fold(0_u16, |sum, &byte| {
        (0..8).fold(sum ^ u16::from(byte) << 8, |sum, _| {
            sum << 1 ^ if sum & 0x8000 == 0 { 0 } else { 0x1021 }
        })
    });
    assert_eq!(stored, checksum);
}

#[test]
fn a_post_without_ground_is_no_zero_and_its_square_is_not_there() {
    let mut heights = heights();
    let post = 9 * POSTS[1] + 30;
    heights[post as usize] = None;
    let bytes = encode(LATTICE, [0, 0], &heights);
    let bitmap = u64::from_le_bytes(bytes[..8].try_into().unwrap_or_default());
    assert_eq!(bitmap, ((1 << 56) - 1) & !(1 << (8 * 2 + 7)));
    let at = 22 + 2 * post as usize;
    assert_eq!(i16::from_le_bytes([bytes[at], bytes[at + 1]]), i16::MIN);
    assert_eq!(
        i16::from_le_bytes([bytes[at + 2], bytes[at + 3]]),
        (post + 1) as i16 - 400
    );
}
