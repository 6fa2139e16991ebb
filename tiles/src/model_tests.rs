#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::progressive::tests::hills;

fn model() -> Model {
    Model::quantised(&hills(20), 12).unwrap()
}

#[test]
fn positions_stay_within_half_a_step() {
    let partition = hills(20);
    let model = model();
    assert_eq!(
        model
            .partition
            .positions
            .iter()
            .fold(0.0_f64, |high, at| high.max(at.max_element())),
        4096.0
    );
    for (at, quantised) in partition.positions.iter().zip(&model.in_units().positions) {
        assert!((*at - *quantised).abs().max_element() <= model.step.x / 2.0 * 1.000_001);
    }
}

#[test]
fn a_model_comes_back_and_encodes_to_as_many_levels() {
    let model = model();
    let bytes = encode(&model).unwrap();
    let decoded = decode(&bytes, &Limits::default()).unwrap();
    assert_eq!((decoded.origin, decoded.step), (model.origin, model.step));
    assert_eq!(decoded.partition.levels, model.partition.levels);
    assert_eq!(decoded.partition.triangles.len(), 2 * 19 * 19);
}

#[test]
fn levels_that_are_there_are_read_and_the_rest_may_be_missing() {
    let bytes = encode(&model()).unwrap();
    let end = |level: usize| word(&bytes, HEADER_LENGTH + ENTRY_LENGTH * level) as usize;
    let decoded = decode(&bytes[..end(2)], &Limits::default()).unwrap();
    assert_eq!(decoded.partition.levels, model().partition.levels[..3]);
    let all = decode(&bytes, &Limits::default()).unwrap();
    assert_eq!(
        decoded.partition.lod(1).triangles.len(),
        all.partition.lod(1).triangles.len()
    );
    assert_eq!(
        decode(&bytes[..end(0) - 1], &Limits::default()),
        Err(DecodeError::Truncated(end(0) - 1))
    );
}

#[test]
fn damaged_bytes_give_a_model_or_an_error_and_no_panic() {
    let bytes = encode(&model()).unwrap();
    for bit in 0..bytes.len() * 8 {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        if let Ok(model) = decode(&damaged, &Limits::default()) {
            partition::validate(&model.partition).unwrap();
        }
    }
}

#[test]
fn counts_above_the_limits_are_refused_before_any_is_made() {
    let bytes = encode(&model()).unwrap();
    let limits = |vertices, triangles, levels| Limits {
        vertices,
        triangles,
        levels,
    };
    assert_eq!(
        decode(&bytes, &limits(399, 1 << 20, 99)),
        Err(DecodeError::Limit("the number of vertices"))
    );
    assert_eq!(
        decode(&bytes, &limits(400, 721, 99)),
        Err(DecodeError::Limit("the number of triangles"))
    );
    assert_eq!(
        decode(&bytes, &limits(400, 722, 1)),
        Err(DecodeError::Limit("the number of levels"))
    );
}

#[test]
fn a_lattice_that_is_none_is_refused() {
    let partition = hills(10);
    assert_eq!(Model::quantised(&partition, 32), Err(EncodeError::Lattice));
    let flat = Model {
        step: DVec3::new(1.0, 0.0, 1.0),
        ..model()
    };
    assert_eq!(encode(&flat), Err(EncodeError::Lattice));
}
