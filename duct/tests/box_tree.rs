//! The tree of boxes against a search through all of them.

use ductloop_duct::box_tree::{Bounds, BoxTree};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

/// Boxes of integer size and place, so that many of them just touch.
fn any_box() -> impl Strategy<Value = Bounds> {
    ([0_i8..12, 0..12, 0..3], [0_i8..4, 0..4, 0..2]).prop_map(|(low, size)| {
        let low = Point3::from(low.map(f64::from));
        Bounds { low, high: low + Vector3::from(size.map(f64::from)) }
    })
}

proptest! {
    #[test]
    fn the_tree_finds_what_going_through_all_finds(
        boxes in prop::collection::vec(any_box(), 0..40),
        wanted in any_box(),
        from in 0_usize..45,
        divisor in 1_usize..4,
    ) {
        let accept = |i: usize| i.is_multiple_of(divisor);
        let meets = |b: &Bounds| (0..3).all(|i| b.high[i] >= wanted.low[i] && wanted.high[i] >= b.low[i]);
        let expected = (from..boxes.len()).find(|i| meets(&boxes[*i]) && accept(*i));
        prop_assert_eq!(BoxTree::new(&boxes).first(from, &wanted, accept), expected);
    }
}

#[test]
fn bounds_are_the_extremes_and_all_of_space_where_they_are_unknown() {
    let points = [Point3::new(1.0, -2.0, 3.0), Point3::new(-1.0, 5.0, 0.0), Point3::new(0.0, 0.0, 4.0)];
    let expected = Bounds { low: Point3::new(-1.0, -2.0, 0.0), high: Point3::new(1.0, 5.0, 4.0) };
    assert_eq!(Bounds::around(&points), expected);
    let far = Bounds::around(&[Point3::new(1e300, 0.0, 0.0)]);
    assert!(!far.meets(&expected));
    for spoiled in [f64::NAN, f64::INFINITY] {
        assert!(far.meets(&Bounds::around(&[points[0], Point3::new(0.0, spoiled, 0.0)])));
    }
    assert!(!far.meets(&Bounds::around([])));
}
