#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

#[test]
fn a_rung_is_a_quarter_of_a_power_of_two() {
    let rung = Rung::of(1.3);
    assert_eq!((rung.start(), rung.next().start()), (1.25, 1.5));
    assert_eq!(Rung::of(1.75).next().start(), 2.0);
    assert!(Rung::of(0.0) < Rung::of(f64::MIN_POSITIVE) && Rung::of(1e300) < Rung::of(f64::INFINITY));
}

#[test]
fn low_rungs_come_first_and_on_a_rung_those_that_wait_longest() {
    let (low, high) = (Rung::of(1.0), Rung::of(2.0));
    let mut queue = Queue::new(4);
    for (vertex, rung) in [(0, low), (1, low), (2, low), (0, low), (1, high)] {
        queue.put(vertex, rung);
    }
    assert!(queue.is_past(1, low) && queue.is_past(3, low) && !queue.is_past(2, low));
    let order: Vec<(Rung, u32)> = std::iter::from_fn(|| queue.take()).collect();
    assert_eq!(order, [(low, 2), (low, 0), (high, 1)]);
}

#[test]
fn what_was_taken_can_be_put_back() {
    let rung = Rung::of(1.0);
    let mut queue = Queue::new(1);
    queue.put(0, rung);
    let (_, vertex) = queue.take().unwrap();
    queue.put(vertex, rung.next());
    assert_eq!(queue.take(), Some((rung.next(), 0)));
    assert_eq!(queue.take(), None);
}
