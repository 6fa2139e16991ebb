use super::*;

/// Bits of which about one in `rarity` is 1.
fn bits(count: usize, rarity: u8) -> Vec<bool> {
    let mut random = fastrand::Rng::with_seed(7);
    (0..count).map(|_| random.u8(0..rarity) == 0).collect()
}

fn encoded(bits: &[bool]) -> Vec<u8> {
    let mut encoder = Encoder::new();
    let mut probability = Probability::default();
    for &bit in bits {
        encoder.bit(&mut probability, bit);
    }
    encoder.finish()
}

#[test]
fn rare_bits_cost_their_entropy_and_come_back() {
    for (rarity, entropy) in [(2, 1.0), (10, 0.469), (100, 0.0808)] {
        let bits = bits(100_000, rarity);
        let bytes = encoded(&bits);
        let cost = bytes.len() as f64 * 8.0 / bits.len() as f64;
        assert!(cost < entropy * 1.07 + 0.005, "{cost} bits each for one in {rarity}");
        let mut decoder = Decoder::new(&bytes, false);
        let mut probability = Probability::default();
        let read: Vec<bool> = bits.iter().map(|_| decoder.bit(&mut probability, false)).collect();
        assert!(read == bits && !decoder.is_exhausted());
    }
}

#[test]
fn even_bits_keep_their_order_and_cost_one_bit_each() {
    let mut encoder = Encoder::new();
    encoder.even_bits(40, 0x12_3456_789a);
    let bytes = encoder.finish();
    assert_eq!(bytes.len(), 5);
    assert_eq!(Decoder::new(&bytes, false).even_bits(40, 0), 0x12_3456_789a);
}

#[test]
fn a_carry_runs_through_bytes_already_written() {
    let mut encoder = Encoder::new();
    let mut probability = Probability::default();
    // Zeros are in the upper part of the range: 2,000 of them drive `low` towards all ones, and what follows over the edge.
    let bits: Vec<bool> = (0..2000).map(|index| index % 997 == 996).collect();
    for &bit in &bits {
        encoder.bit(&mut probability, bit);
        encoder.even_bits(1, u64::from(bit));
    }
    let bytes = encoder.finish();
    let mut decoder = Decoder::new(&bytes, false);
    let mut probability = Probability::default();
    let read = bits
        .iter()
        .all(|&bit| decoder.bit(&mut probability, false) == bit && (decoder.even_bits(1, 0) == 1) == bit);
    assert!(read);
}

#[test]
fn nothing_takes_no_byte() {
    assert_eq!(Encoder::new().finish(), [0_u8; 0]);
    assert_eq!(encoded(&[true]).len(), 0, "the lower half of the range holds 0");
    assert_eq!(encoded(&[false]).len(), 1);
}

#[test]
fn reading_on_after_the_end_is_noticed() {
    let mut decoder = Decoder::new(&[0x12], false);
    let reads = (0..).take_while(|_| {
        decoder.even_bits(1, 0);
        !decoder.is_exhausted()
    });
    assert_eq!(
        reads.take(1000).count(),
        8 + 7,
        "a byte, and almost as much again before it is noticed"
    );
}
