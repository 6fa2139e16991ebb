use super::*;

const VOID: f32 = f32::NAN;

fn values(first: [i64; 2], columns: usize, values: Vec<f32>) -> Values<f32> {
    Values {
        first,
        columns,
        rows: values.len() / columns,
        values,
    }
}

#[test]
fn one_value_goes_on_everywhere_and_what_is_there_stays() {
    let mut one = vec![VOID; 63];
    one[31] = 5.0;
    assert_eq!(values([-3, 4], 9, one).spread(5), vec![5.0; 63]);
    let ends = values([0, 0], 4, vec![1.0, VOID, VOID, 4.0]).spread(3);
    assert!(
        ends[0] == 1.0 && ends[3] == 4.0 && ends[0] < ends[1] && ends[1] < ends[2] && ends[2] < ends[3],
        "{ends:?}"
    );
}

#[test]
fn nothing_comes_of_nothing_nor_beyond_the_largest_squares() {
    assert!(
        values([0, 0], 3, vec![VOID; 9])
            .spread(4)
            .iter()
            .all(|value| value.is_nan())
    );
    let mut far = vec![VOID; 64];
    far[0] = 1.0;
    let spread = values([0, 0], 64, far).spread(2);
    assert!(spread[4] == 1.0 && spread[63].is_nan());
}

#[test]
fn what_comes_out_does_not_depend_on_the_rectangle() {
    let levels = 3;
    let reach = 2 << levels;
    let mut random = fastrand::Rng::with_seed(5);
    let (columns, rows) = (90, 70);
    let all: Vec<f32> = (0..columns * rows)
        .map(|_| if random.u8(0..6) == 0 { random.f32() } else { VOID })
        .collect();
    let whole = values([-7, 3], columns, all.clone()).spread(levels);
    let [left, top, width, height] = [20, 17, 50, 40];
    let part = (top..top + height).flat_map(|row| all[row * columns + left..][..width].to_vec());
    let part = values([-7 + left as i64, 3 + top as i64], width, part.collect()).spread(levels);
    for row in reach..height - reach {
        for column in reach..width - reach {
            let (here, there) = (part[row * width + column], whole[(top + row) * columns + left + column]);
            assert!(here == there || (here.is_nan() && there.is_nan()), "{column} {row}");
        }
    }
}
