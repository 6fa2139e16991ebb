use super::*;

/// A part of a segment is where the same part of the whole is, to the bit: so tiles beside each other agree.
#[test]
fn steps_in_a_rectangle_are_those_of_the_whole_segment() {
    let segment = [DVec2::new(-3.7, 1.25), DVec2::new(41.3, 17.9)];
    let whole = steps(segment, [DVec2::splat(-100.0), DVec2::splat(100.0)]);
    assert_eq!([whole[0][0], whole[whole.len() - 1][1]], segment);
    assert!(whole.windows(2).all(|pair| pair[0][1] == pair[1][0]));
    let within = |at: DVec2| at.clamp(DVec2::new(10.0, 3.0), DVec2::new(20.0, 9.0)) == at;
    let part = steps(segment, [DVec2::new(10.0, 3.0), DVec2::new(20.0, 9.0)]);
    assert!(part.iter().all(|step| whole.contains(step)));
    let inside: Vec<&GridStep> = whole
        .iter()
        .filter(|step| step.iter().any(|&end| within(end)))
        .collect();
    assert!(inside.len() > 10 && inside.into_iter().all(|step| part.contains(step)));
}

#[test]
fn a_step_ends_at_each_grid_line_and_nowhere_else() {
    let found = steps(
        [DVec2::new(0.5, 0.5), DVec2::new(2.5, 1.5)],
        [DVec2::ZERO, DVec2::splat(4.0)],
    );
    let ends: Vec<DVec2> = found.iter().map(|step| step[1]).collect();
    assert_eq!(
        ends,
        [(1.0, 0.75), (1.5, 1.0), (2.0, 1.25), (2.5, 1.5)].map(DVec2::from)
    );
}

#[test]
fn what_is_along_an_outline_is_not_on_the_surface() {
    let samples = [0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0];
    let heights = Heights {
        columns: 3,
        rows: 2,
        samples: &samples,
    };
    let step = |from: (f64, f64), to: (f64, f64)| is_on_surface(heights, [from, to].map(DVec2::from));
    assert!(step((0.2, 0.1), (0.9, 0.8)));
    assert!(!step((1.2, 0.1), (1.9, 0.8)));
    assert!(!step((1.0, 0.0), (1.0, 1.0)));
    assert!(!step((0.0, 0.0), (0.0, 1.0)));
}
