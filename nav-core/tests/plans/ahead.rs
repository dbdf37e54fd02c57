//! What lies ahead is told from ranges: plans of fittings, drawn here as walls, are met by rays as a line scanner's would be, and the robot
//! moves towards them.

use super::plan::{AT_M, CAMERA_M, FLOOR_M, Floor, HALF_M, WIDTH_M, Wall, plans, scan, scan_with_floor, shoed, side_wall, wye};
use ductloop_nav::ahead::{Ahead, DuctPlace, Fitting, Side};

/// Drives along the middle from the duct's beginning; returns, frame by frame, where the robot was and what it took the fitting for.
fn drive(walls: &[Wall], to_m: f64, noise: f64) -> Vec<(f64, Fitting)> {
    let mut ahead = Ahead::new([CAMERA_M, 0.0]);
    (0..(to_m / 0.01) as usize)
        .map(|step| {
            let along_m = 0.5 + 0.01 * step as f64;
            let (lateral_m, heading_rad) = (0.02 * libm::sin(3.0 * along_m), 0.03 * libm::cos(5.0 * along_m));
            let place = DuctPlace { along_m, lateral_m, heading_rad, width_m: WIDTH_M };
            (along_m, ahead.look(&place, &scan(walls, [along_m, lateral_m, heading_rad], noise)).fitting)
        })
        .take_while(|(along_m, _)| *along_m < to_m)
        .collect()
}

/// From one and a half widths before it on (a transition: 1.2) each fitting is told for what it is, and never is it taken for another one.
#[test]
fn fittings_are_told_in_time() {
    for (index, (expected, walls)) in plans().into_iter().enumerate() {
        let seen = drive(&walls, AT_M - 0.1, 0.2);
        let wrong: Vec<_> =
            seen.iter().filter(|(_, fitting)| ![expected, Fitting::Unknown, Fitting::Straight].contains(fitting)).collect();
        assert!(wrong.is_empty(), "{index}, {expected:?}: {wrong:?}");
        let known = seen.iter().find(|(_, fitting)| *fitting == expected).map(|(at_m, _)| AT_M - at_m);
        // A wall that leaves its line by a little must be seen for a while.
        let in_time_m = if expected == Fitting::Transition { 1.2 * WIDTH_M } else { 1.5 * WIDTH_M };
        assert!(known.is_some_and(|distance_m| distance_m >= in_time_m), "{index}, {expected:?}: told {known:?} m before it");
        let lost: Vec<_> = seen.iter().filter(|(at_m, f)| AT_M - at_m < WIDTH_M && *f != expected).collect();
        assert!(lost.is_empty(), "{index}, {expected:?}: {lost:?}");
    }
}

/// A duct that goes straight on is straight, and one that is not yet seen is not known.
#[test]
fn a_straight_is_straight() {
    let walls = [side_wall(HALF_M, 0.0, 20.0), side_wall(-HALF_M, 0.0, 20.0)];
    let seen = drive(&walls, 6.0, 0.2);
    assert!(seen.iter().all(|(_, fitting)| matches!(fitting, Fitting::Straight | Fitting::Unknown)), "{seen:?}");
    let straight = seen.iter().skip(40).filter(|(_, fitting)| *fitting == Fitting::Straight).count();
    assert_eq!(straight, seen.len() - 40);
}

/// Who is a degree off in heading at first, as behind a bend, sees the walls farther on aside of where they are found later: no offset.
#[test]
fn a_duct_that_was_seen_askew_is_no_offset() {
    for off_rad in [-0.025, -0.0175, 0.0175, 0.025] {
        for (expected, walls) in plans().into_iter().filter(|(fitting, _)| *fitting == Fitting::BullheadTee) {
            let mut ahead = Ahead::new([CAMERA_M, 0.0]);
            for step in 0..140 {
                let along_m = AT_M - 1.5 + 0.01 * f64::from(step);
                let left = (f64::from(step - 50) / 20.0).clamp(0.0, 1.0);
                let heading_rad = off_rad * (1.0 - left);
                let place = DuctPlace { along_m, lateral_m: 0.0, heading_rad, width_m: WIDTH_M };
                let seen = ahead.look(&place, &scan(&walls, [along_m, 0.0, 0.0], 0.2)).fitting;
                assert!(!matches!(seen, Fitting::Offset(_)), "{expected:?}, {off_rad} off: {seen:?} at {along_m}");
            }
        }
    }
}

/// A wye is called a bull-head tee, and a branch with a shoe a branch, from a width before it on; neither is taken for anything else.
#[test]
fn wyes_and_shoes_are_told() {
    let wyes = [30.0_f64, 45.0].map(|turn_deg| (Fitting::BullheadTee, wye(turn_deg.to_radians(), 0.9 * WIDTH_M).0));
    let shoes = [(0.125, true), (0.125, false), (0.25, false)]
        .map(|(shoe_m, is_near)| (Fitting::Branch(Side::Left), shoed(shoe_m, is_near).0));
    for (index, (expected, walls)) in wyes.into_iter().chain(shoes).enumerate() {
        let seen = drive(&walls, AT_M - 0.1, 0.2);
        let wrong: Vec<_> =
            seen.iter().filter(|(_, fitting)| ![expected, Fitting::Unknown, Fitting::Straight].contains(fitting)).collect();
        assert!(wrong.is_empty(), "{index}: {wrong:?}");
        let lost: Vec<_> = seen.iter().filter(|(at_m, fitting)| AT_M - at_m < WIDTH_M && *fitting != expected).collect();
        assert!(lost.is_empty(), "{index}: {lost:?}");
    }
}

/// Drives along the middle over a floor; says what was seen, frame by frame.
fn drive_over(floor: Floor, to_m: f64) -> Vec<(f64, Fitting, f64)> {
    let walls = [side_wall(HALF_M, 0.0, 20.0), side_wall(-HALF_M, 0.0, 20.0)];
    let mut ahead = Ahead::new([CAMERA_M, 0.0]);
    (0..)
        .map(|step| 0.5 + 0.01 * f64::from(step))
        .take_while(|along_m| *along_m < to_m)
        .map(|along_m| {
            let place = DuctPlace { along_m, lateral_m: 0.0, heading_rad: 0.0, width_m: WIDTH_M };
            let seen = ahead.look(&place, &scan_with_floor(&walls, floor, [along_m, 0.0, 0.0], 0.2));
            (along_m, seen.fitting, seen.at_m)
        })
        .collect()
}

/// A floor that ends is a drop as soon as it has been missed for 120 mm, at its edge; until then it is nothing.
#[test]
fn a_hole_is_a_drop_at_its_edge() {
    for long_m in [0.3, 1.0] {
        let seen = drive_over(Floor::Hole { from_m: AT_M, to_m: AT_M + long_m }, AT_M - 0.3);
        let told = seen.iter().find(|(_, fitting, _)| *fitting == Fitting::Drop);
        let before = seen.iter().filter(|(along_m, ..)| along_m + FLOOR_M < AT_M);
        assert!(
            before.clone().all(|(_, fitting, _)| matches!(fitting, Fitting::Straight | Fitting::Unknown)),
            "{long_m}: {seen:?}"
        );
        assert!(told.is_some_and(|(along_m, _, at_m)| AT_M - along_m > 0.7 && (at_m - AT_M).abs() < 0.05), "{long_m}: {told:?}");
        assert!(seen.last().is_some_and(|(_, fitting, _)| *fitting == Fitting::Drop), "{long_m}: {:?}", seen.last());
    }
}

/// Behind a crest of 5 degrees the light falls on a floor that is lower, farther on: no drop. A floor that is level is none either.
#[test]
fn a_crest_is_no_drop() {
    for floor in [Floor::Crest { from_m: AT_M, slope: libm::tan(5.0_f64.to_radians()) }, Floor::Hole { from_m: 50.0, to_m: 51.0 }]
    {
        let seen = drive_over(floor, AT_M + 1.0);
        assert!(
            seen.iter().all(|(_, fitting, _)| matches!(fitting, Fitting::Straight | Fitting::Unknown)),
            "{floor:?}: {seen:?}"
        );
    }
}
