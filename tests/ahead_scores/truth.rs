//! What lies ahead along the path of drawn ducts, against what a person reads off their plans.

use std::f64::consts::FRAC_PI_2;

use ductloop::Scenario;
use ductloop::ahead_scores::{TrueAhead, Way};
use ductloop_duct::network::Network;
use ductloop_sim::truth::Truth;

/// In ducts 0.5 m wide and 0.3 m high.
pub(crate) fn scenario(duct: &str) -> Scenario {
    let text = format!("format = 1\nkind = \"scenario\"\nname = \"t\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n{duct}\n");
    Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{}\n{duct}", wrong.render(false)))
}

fn network(scenario: &Scenario) -> Network {
    scenario.duct.network().unwrap_or_else(|wrong| panic!("{wrong}"))
}

/// A robot on the middle of the path of a network, in a segment of it.
fn standing(network: &Network, segment: usize, distance_m: f64, heading_rad: f64) -> Truth {
    Truth {
        world_from_base: network.centreline.pose_at(distance_m),
        cell: 0,
        fitting: network.centreline.segments[segment].fitting,
        segment,
        distance_m,
        lateral_m: 0.0,
        heading_rad,
        clearance_m: 0.1,
        speed_m_s: 0.25,
        yaw_rate_rad_s: 0.0,
        wheel_speed_rad_s: Default::default(),
        motor_current_a: Default::default(),
    }
}

#[track_caller]
fn expect(duct: &str, expected: &[(&str, f64)]) {
    let scenario = scenario(duct);
    let way = Way::new(&scenario, &network(&scenario));
    let found: Vec<(&str, f64)> = way.things().iter().map(|thing| (thing.fitting.word(), thing.at_m)).collect();
    let same =
        found.len() == expected.len() && std::iter::zip(&found, expected).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-6);
    assert!(same, "{duct}\nfound {found:?}\nexpected {expected:?}");
}

/// The path's arc through a tee, or about the inner corner of a mitre, in a duct 0.5 m wide.
const ARC_M: f64 = 0.25 * FRAC_PI_2;

#[test]
fn a_straight_duct_ends_at_its_cap_or_nowhere() {
    expect("run = [{ straight_m = 2.0 }, { straight_m = 1.0 }]\nexit = \"open\"", &[]);
    expect("run = [{ straight_m = 2.0 }, { straight_m = 1.0 }]\nexit = \"cap\"", &[("dead-end", 3.0)]);
    // Neither slopes nor grilles nor ceilings nor open dampers show in a plan.
    expect(
        "run = [{ straight_m = 1.0 }, { slope_deg = 5, length_m = 1.0 }, { grille = \"left\" }, { damper = \"open\" },\n\
         { transition_m = 0.4, to_height_m = 0.25 }, { straight_m = 1.0 }]\nexit = \"open\"",
        &[],
    );
}

#[test]
fn elbows_turn_to_the_side_that_one_comes_to_them_by() {
    let run = "run = [{ straight_m = 2.0 }, { mitre_deg = 90 }, { straight_m = 1.5 }, { elbow_deg = -90, throat_radius_m = 0.375 },\n\
               { straight_m = 2.0 }]\nexit = \"cap\"";
    let second = 2.0 + ARC_M + 1.5;
    let end = second + 0.625 * FRAC_PI_2 + 2.0;
    expect(run, &[("elbow-left", 2.0), ("elbow-right", second), ("dead-end", end)]);
    // There and back again: left of the one way is right of the other. It turns round 0.6 m before the cap.
    let turn = end - 0.6;
    let back = [turn + 1.4, turn + 1.4 + 0.625 * FRAC_PI_2 + 1.5];
    expect(
        &format!("{run}\n[route]\nturns = [\"turn-back\"]\nturn_back_m = 0.6"),
        &[
            ("elbow-left", 2.0),
            ("elbow-right", second),
            ("dead-end", end),
            ("elbow-left", back[0]),
            ("elbow-right", back[1]),
            // The cap behind the start.
            ("dead-end", back[1] + ARC_M + 2.0),
        ],
    );
}

/// A tee with its branch on the left: a branch on the left, one on the right, or the end across another duct.
#[test]
fn a_tee_is_what_it_is_from_each_of_its_sides() {
    let tee = "run = [{ straight_m = 2.0 }, { tee = \"left\", name = \"t\" }, { straight_m = 1.5 }]\nexit = \"cap\"\n\
               [[duct.branch]]\nfrom = \"t.left\"\nrun = [{ straight_m = 1.2 }]\nend = \"cap\"\n[route]\nturn_back_m = 0.5\nturns =";
    // From its `in` past it, and back from its `out`: 1.0 m back from where it turned round.
    let turned = 2.5 + 1.0;
    expect(
        &format!("{tee} [\"straight\", \"turn-back\", \"straight\"]"),
        &[("branch-left", 2.0), ("dead-end", 4.0), ("branch-right", turned + 1.0), ("dead-end", turned + 1.0 + 2.5)],
    );
    // Into its branch and out of it, back to where it came from.
    let turned = 2.0 + ARC_M + 0.7;
    expect(
        &format!("{tee} [\"left\", \"turn-back\", \"right\"]"),
        &[
            ("branch-left", 2.0),
            ("dead-end", 2.0 + ARC_M + 1.2),
            ("bullhead-tee", turned + 0.7),
            ("dead-end", turned + 0.7 + ARC_M + 2.0),
        ],
    );
    // A route that stops before it.
    expect(&format!("{tee} [\"stop\"]"), &[("branch-left", 2.0)]);
}

#[test]
fn junctions_are_known_by_the_ways_that_are_open() {
    let two = |piece: &str| {
        format!(
            "run = [{{ straight_m = 1.0 }}, {piece}]\n\
             [[duct.branch]]\nfrom = \"j.left\"\nrun = [{{ straight_m = 2.0 }}]\nend = \"open\"\n\
             [[duct.branch]]\nfrom = \"j.right\"\nrun = [{{ straight_m = 2.0 }}]\nend = \"open\"\n[route]\nturns = [\"left\"]"
        )
    };
    expect(&two("{ bullhead_m = 0.5, name = \"j\" }"), &[("bullhead-tee", 1.0)]);
    expect(&two("{ wye_deg = 45, branch_width_m = 0.4, name = \"j\" }"), &[("bullhead-tee", 1.0)]);
    expect(&two("{ cross_m = 0.5, name = \"j\" }, { straight_m = 1.0 }"), &[("cross", 1.0)]);
    // With only one of its branches open a cross is a tee, a bull-head tee an elbow; without any, a tee is straight.
    let one = |piece: &str, turn: &str| {
        format!(
            "run = [{{ straight_m = 1.0 }}, {piece}]\nexit = \"open\"\n[[duct.branch]]\nfrom = \"j.right\"\nrun = [{{ straight_m = 2.0 }}]\n\
             end = \"open\"\n[route]\nturns = [\"{turn}\"]"
        )
    };
    expect(&one("{ cross_m = 0.5, name = \"j\" }, { straight_m = 1.0 }", "right"), &[("branch-right", 1.0)]);
    expect(&one("{ bullhead_m = 0.5, name = \"j\" }", "right"), &[("elbow-right", 1.0)]);
    expect(
        "run = [{ straight_m = 1.0 }, { tee = \"left\" }, { straight_m = 1.0 }]\nexit = \"open\"\n[route]\nturns = [\"straight\"]",
        &[],
    );
}

#[test]
fn what_cannot_be_passed_is_ahead_too() {
    // The hole is in the middle of 2 m.
    expect(
        "run = [{ straight_m = 2.0 }, { drop_m = 0.5, length_m = 2.0 }, { straight_m = 1.0 }]\n[route]\nturns = [\"stop\"]",
        &[("drop", 2.75)],
    );
    expect(
        "run = [{ straight_m = 2.0 }, { vaned_deg = 90 }, { straight_m = 1.0 }]\n[route]\nturns = [\"stop\"]",
        &[("obstacle", 2.0)],
    );
    // The curtain stands in the middle of the damper, 3 mm thick.
    expect(
        "run = [{ straight_m = 2.0 }, { damper = \"shut\", length_m = 0.4 }, { straight_m = 1.0 }]\n[route]\nturns = [\"stop\"]",
        &[("dead-end", 2.2 - 0.0015)],
    );
}

/// Objects in the robot's way are met at their near face, from both sides; those beside it or above it are not.
#[test]
fn objects_stand_where_they_are_met() {
    let duct = |object: &str| {
        format!(
            "run = [{{ straight_m = 4.0 }}]\nexit = \"cap\"\n[[duct.object]]\nat_m = 1.5\n{object}\n\
             [route]\nturn_back_m = 0.5\nturns = [\"turn-back\"]"
        )
    };
    expect(
        &duct("size_m = [0.2, 0.1, 0.1]"),
        &[("obstacle", 1.4), ("dead-end", 4.0), ("obstacle", 3.5 + 1.9), ("dead-end", 7.0)],
    );
    expect(
        &duct("size_m = [0.2, 0.48, 0.1]"),
        &[("dead-end", 1.4), ("dead-end", 4.0), ("dead-end", 3.5 + 1.9), ("dead-end", 7.0)],
    );
    expect(&duct("size_m = [0.2, 0.1, 0.1]\nleft_m = 0.19"), &[("dead-end", 4.0), ("dead-end", 7.0)]);
    expect(&duct("size_m = [0.2, 0.1, 0.05]\nabove_m = 0.25"), &[("dead-end", 4.0), ("dead-end", 7.0)]);
}

#[test]
fn dimensions_are_those_of_the_fittings() {
    let scenario = scenario(
        "run = [{ straight_m = 2.0 }, { transition_m = 0.4, to_width_m = 0.4 }, { straight_m = 1.0 }, { elbow_deg = 45, throat_radius_m = 0.3 },\n\
         { straight_m = 1.0 }]\nexit = \"open\"",
    );
    let way = Way::new(&scenario, &network(&scenario));
    let [taper, elbow] = way.things() else { panic!("{way:?}") };
    assert_eq!((taper.fitting.word(), taper.width_m, taper.width_after_m, taper.radius_m), ("transition", 0.5, Some(0.4), None));
    assert!((taper.to_m - 2.4).abs() < 1e-9);
    assert_eq!((elbow.fitting.word(), elbow.width_m, elbow.width_after_m), ("elbow-left", 0.4, None));
    assert!(elbow.radius_m.is_some_and(|radius_m| (radius_m - 0.5).abs() < 1e-9), "{elbow:?}");
    // The rising slit meets the ceiling there (`docs/navigation.md`).
    assert!((2.4..2.8).contains(&elbow.reach_m), "{elbow:?}");
}

/// From place to place: what is next, how far, whether it can be seen, and whether the robot is in something.
#[test]
fn what_is_ahead_of_a_place() {
    let scenario = scenario(
        "run = [{ straight_m = 4.0 }, { mitre_deg = 90 }, { straight_m = 4.0 }]\nentry = \"open\"\nexit = \"cap\"\n[route]\nturns = [\"turn-back\"]",
    );
    let network = network(&scenario);
    let way = Way::new(&scenario, &network);
    let end = 8.0 + ARC_M;
    let segments = network.centreline.segments.len();
    let nose_m = scenario.robot.nose_m;
    let at = |segment: usize, distance_m: f64, heading_rad: f64| way.ahead(&standing(&network, segment, distance_m, heading_rad));
    let is = |found: Option<TrueAhead>, word: &str, distance_m: f64, [in_reach, inside]: [bool; 2]| {
        let found = found.unwrap_or_else(|| panic!("{word}, {distance_m}: off the path"));
        let same = found.fitting.word() == word && (found.distance_m - distance_m).abs() < 1e-6 || found.distance_m == distance_m;
        assert!(same && (found.is_in_reach, found.is_inside) == (in_reach, inside), "{word}, {distance_m}: {found:?}");
    };
    is(at(0, 1.0, 0.1), "elbow-left", 3.0, [false, false]);
    is(at(0, 2.0, 0.0), "elbow-left", 2.0, [true, false]);
    is(at(0, 4.0 - nose_m - 0.01, 0.0), "elbow-left", nose_m + 0.01, [true, false]);
    is(at(0, 4.0 - nose_m + 0.01, 0.0), "elbow-left", nose_m - 0.01, [true, true]);
    is(at(1, 4.1, 0.0), "dead-end", end - 4.1, [false, true]);
    is(at(2, 6.0, 0.0), "dead-end", end - 6.0, [true, false]);
    // On the way back the same elbow, to the other side.
    let back = network.centreline.segments[3].start_m;
    is(at(3, back + 1.0, 0.0), "elbow-right", 4.0 - (end - back) - 1.0, [true, false]);
    is(at(segments - 1, network.centreline.length_m() - 1.0, 0.0), "straight", f64::INFINITY, [false, false]);
    // Turning round, and in a fitting that the path does not go through.
    assert_eq!(at(0, 2.0, 1.0), None);
    let elsewhere = Truth { fitting: 1, ..standing(&network, 0, 2.0, 0.0) };
    assert_eq!(way.ahead(&elsewhere), None);
}
