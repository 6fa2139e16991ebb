use super::*;

#[test]
fn a_fill_asks_only_where_its_size_leaves_a_choice() {
    let asked = |answers: &[bool], count| {
        let mut answers = answers.iter().copied();
        let fill = ask_fill(count, |_, _| answers.next());
        fill.filter(|_| answers.next().is_none())
    };
    assert_eq!(asked(&[], 0), Some(vec![]));
    assert_eq!(asked(&[], 1), Some(vec![[false, false]]));
    assert_eq!(asked(&[true], 2), Some(vec![[true, false], [false, false]]));
    assert_eq!(asked(&[false], 2), Some(vec![[false, true], [false, false]]));
    let both = [[true, true], [false, false], [false, false]];
    assert_eq!(asked(&[true, true], 3), Some(both.to_vec()));
    assert_eq!(asked(&[true], 3), None, "too few answers");
}

#[test]
fn the_third_edge_of_a_triangle_with_two_marked_ones_costs_nothing() -> Result<(), SplitError> {
    let surface = ClosedSurface::new(3, &[[0, 1, 2]])?;
    assert_eq!(mark_bits(&surface, &[[0, 1], [0, 2]]), [true, true]);
    assert_eq!(mark_bits(&surface, &[]), [false, false, false]);
    assert_eq!(marked_edges(&surface, &[true, true])?, [[0, 1], [0, 2]]);
    assert_eq!(marked_edges(&surface, &[true]), Err(SplitError::BitCount("marks")));
    Ok(())
}
