use super::*;
use crate::progressive::tests::hills;

fn model() -> Model {
    Model::quantised(&hills(20), 12).unwrap()
}

#[test]
fn positions_stay_within_half_a_step() {
    let partition = hills(20);
    let model = model();
    assert_eq!(model.partition.positions.iter().fold(0.0_f64, |high, at| high.max(at.max_element())), 4096.0);
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
