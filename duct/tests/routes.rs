//! Routes through networks: which turns a junction offers, where the path leads, turning back, exploring.

mod common;

use std::collections::BTreeSet;

use common::{WIDTH, fitting, mitre, straight, tee};
use ductloop_duct::centreline::Centreline;
use ductloop_duct::fitting::port::PortName::{In, Left, Out, Right};
use ductloop_duct::fitting::{Blade, Fitting, Hand, Shape};
use ductloop_duct::network::{End, Join, Network, Piece, PortRef, RouteError, Turn};
use nalgebra::{Point3, Vector3};

/// What is left of a duct in which the path turns back.
const SHORT: f64 = 0.6;
const START: PortRef = (0, In);

fn network(pieces: &[(&str, Fitting)], joins: &[(PortRef, PortRef)]) -> Network {
    let pieces: Vec<Piece> = pieces.iter().map(|(name, fitting)| Piece { fitting: *fitting, name: (*name).to_owned() }).collect();
    let joins: Vec<Join> = joins.iter().map(|(a, b)| Join { a: *a, b: *b }).collect();
    Network::assemble(&pieces, &joins, &[]).expect("a possible network")
}

/// A tee, dead ends of 2 m left and 3 m straight on.
fn fork() -> Network {
    let pieces = [("start", straight(1.0)), ("tee", tee(Hand::Left)), ("on", straight(3.0)), ("side", straight(2.0))];
    network(&pieces, &[((0, Out), (1, In)), ((1, Out), (2, In)), ((1, Left), (3, In))])
}

/// Pieces of the path join without a gap or a kink but for turning back.
fn check(path: &Centreline) {
    for pair in path.segments.windows(2) {
        let (end, start) = (pair[0].pose_at(pair[0].length_m), pair[1].pose_at(0.0));
        assert!((end.translation.vector - start.translation.vector).norm() < 1e-9, "a gap");
        // Seen from above: where a slope begins, floors have a kink.
        let [end, start] = [end, start].map(|pose| (pose.rotation * Vector3::x()).xy().normalize());
        let along = end.dot(&start);
        assert!((along - if pair[1].turns_back { -1.0 } else { 1.0 }).abs() < 1e-9, "a kink");
        assert!((pair[1].start_m - pair[0].start_m - pair[0].length_m).abs() < 1e-9);
    }
}

fn fittings(path: &Centreline) -> Vec<usize> {
    let mut seen: Vec<usize> = path.segments.iter().map(|segment| segment.fitting).collect();
    seen.dedup();
    seen
}

#[test]
fn a_junction_offers_what_its_exits_are() {
    use Turn::{Left as L, Right as R, Straight as S};
    let turns = |network: &Network, at| network.exits(at).into_iter().map(|(turn, _)| turn).collect::<Vec<_>>();
    let around = |shape| common::with_stubs(shape).expect("possible");
    let tee = around(Shape::Tee { hand: Hand::Left, branch_width_m: 0.4 });
    assert_eq!([In, Out, Left].map(|port| turns(&tee, (0, port))), [vec![L, S], vec![S, R], vec![L, R]]);
    let tee = around(Shape::SideBranch { hand: Hand::Right, branch_width_m: 0.4, shoe_m: 0.1 });
    assert_eq!([In, Out, Right].map(|port| turns(&tee, (0, port))), [vec![S, R], vec![L, S], vec![L, R]]);
    let bullhead = around(Shape::BullheadTee { branch_width_m: 0.4 });
    assert_eq!([In, Left, Right].map(|port| turns(&bullhead, (0, port))), [vec![L, R], vec![S, R], vec![L, S]]);
    let cross = around(Shape::Cross { branch_width_m: 0.4 });
    assert_eq!([In, Out, Left, Right].map(|port| turns(&cross, (0, port))), [const { [L, S, R] }; 4].map(|all| all.to_vec()));
    for deg in [30.0_f64, 45.0, 60.0] {
        let wye = around(Shape::Wye { half_angle_rad: deg.to_radians(), branch_width_m: 0.5 });
        assert_eq!([In, Left, Right].map(|port| turns(&wye, (0, port))), [vec![L, R], vec![L, R], vec![L, R]], "{deg}");
        assert_eq!(wye.exits((0, Left)), [(L, Right), (R, In)]);
    }
    // Behind a cap there is no exit.
    let capped = network(&[("start", straight(1.0)), ("t", common::tee(Hand::Left))], &[((0, Out), (1, In))]);
    assert_eq!(turns(&capped, (1, In)), []);
}

#[test]
fn a_route_leads_where_its_turns_say() {
    let network = fork();
    let left = network.path(&[Turn::Left], START, SHORT).expect("a way");
    check(&left);
    assert_eq!(fittings(&left), [0, 1, 3]);
    let quarter = 0.25 * std::f64::consts::FRAC_PI_2;
    assert!((left.length_m() - 3.0 - quarter).abs() < 1e-12);
    let end = left.pose_at(left.length_m());
    assert!((end.translation.vector - Vector3::new(1.25, 2.25, 0.0)).norm() < 1e-12);
    let straight_on = network.path(&[Turn::Straight, Turn::Stop], START, SHORT).expect("a way");
    assert_eq!(straight_on, network.centreline, "what a run follows by itself");
    assert!((straight_on.length_m() - 4.0 - WIDTH).abs() < 1e-12);
    // To a stop before a junction.
    let stopped = network.path(&[Turn::Stop], START, SHORT).expect("a way");
    assert!((stopped.length_m() - 1.0).abs() < 1e-12);
}

#[test]
fn a_dead_end_is_left_the_way_it_was_entered() {
    let network = fork();
    let route = [Turn::Straight, Turn::TurnBack, Turn::Right, Turn::TurnBack, Turn::Right, Turn::Stop];
    let path = network.path(&route, START, SHORT).expect("a way");
    check(&path);
    assert_eq!(fittings(&path), [0, 1, 2, 1, 3, 1, 0]);
    let quarter = 0.25 * std::f64::consts::FRAC_PI_2;
    // Straight on and back, to the left by a right turn, back, and right again: out where it came in.
    let expected = 1.0 + WIDTH + 2.0 * (3.0 - SHORT) + 2.0 * quarter + 2.0 * (2.0 - SHORT) + 1.0;
    assert!((path.length_m() - expected).abs() < 1e-12, "{}", path.length_m());
    let end = path.pose_at(path.length_m());
    assert!(end.translation.vector.norm() < 1e-12 && (end.rotation * Vector3::x() + Vector3::x()).norm() < 1e-12, "{end:?}");
    let turn = path.segments.iter().position(|segment| segment.turns_back).expect("it turns back");
    let at = path.segments[turn].world_from_start.translation.vector;
    assert!((at - Vector3::new(1.0 + WIDTH + 3.0 - SHORT, 0.0, 0.0)).norm() < 1e-12);
    // In a short duct, midway.
    let stub = self::network(
        &[("start", straight(1.0)), ("tee", tee(Hand::Left)), ("stub", straight(0.4))],
        &[((0, Out), (1, In)), ((1, Left), (2, In))],
    );
    let path = stub.path(&[Turn::Left, Turn::TurnBack, Turn::Right], START, SHORT).expect("a way");
    check(&path);
    let turn = path.segments.iter().find(|segment| segment.turns_back).expect("it turns back");
    assert!((turn.world_from_start.translation.y - 0.45).abs() < 1e-12);
}

/// In a branch of several pieces, with an elbow and a slope, the way back is the way in.
#[test]
fn turning_back_goes_over_several_pieces() {
    let slope = fitting(Shape::Slope { length_m: 1.0, angle_rad: 0.1 });
    let pieces = [("start", straight(1.0)), ("elbow", mitre(-60.0)), ("slope", slope), ("last", straight(0.3))];
    let network = network(&pieces, &[((0, Out), (1, In)), ((1, Out), (2, In)), ((2, Out), (3, In))]);
    let path = network.path(&[Turn::TurnBack, Turn::Stop], START, SHORT).expect("a way");
    check(&path);
    assert_eq!(fittings(&path), [0, 1, 2, 1, 0], "the last 0.6 m are left out");
    let half = path.length_m() / 2.0;
    for step in 0..=50 {
        let off = half * f64::from(step) / 50.0;
        let (out, back) = (path.pose_at(half - off), path.pose_at(half + off));
        assert!((out.translation.vector - back.translation.vector).norm() < 1e-9);
        let forward = |pose: nalgebra::Isometry3<f64>| pose.rotation * Vector3::x();
        assert!(step == 0 || (forward(out) + forward(back)).norm() < 1e-9, "at {off}");
    }
    assert!((path.length_m() / 2.0 - (network.centreline.length_m() - SHORT)).abs() < 1e-12);
    assert_eq!(path.pose_at(path.length_m()).translation.vector.norm(), 0.0);
}

#[test]
fn a_turn_that_is_not_there_is_refused_with_what_there_is() {
    let network = fork();
    let told = |route: &[Turn]| network.path(route, START, SHORT).expect_err("no such way").to_string();
    assert_eq!(
        told(&[Turn::Right]),
        "turn 1 of the route, at `tee`, is \"right\"; the junction offers \"left\", \"straight\", \"stop\""
    );
    assert_eq!(
        told(&[Turn::Left, Turn::Left]),
        "turn 2 of the route, at `side`, is \"left\"; the end of the duct offers \"turn-back\", \"stop\""
    );
    assert_eq!(
        told(&[]),
        "the route has no turn for `tee`, a junction, after 0 turns; it offers \"left\", \"straight\", \"stop\""
    );
    assert_eq!(
        told(&[Turn::Left, Turn::Stop, Turn::Left]),
        "the route ends with turn 2 at `side`, and goes on with \"left\" after it"
    );
    assert_eq!(network.path(&[], (9, In), SHORT), Err(RouteError::Start { piece: 9, port: In }));
    assert_eq!(network.path(&[], (0, Left), SHORT), Err(RouteError::Start { piece: 0, port: Left }));
}

#[test]
fn what_cannot_be_passed_is_turned_back_from() {
    let shut = fitting(Shape::Damper { length_m: 0.3, blade: Blade::Shut });
    let pieces = [("start", straight(2.0)), ("damper", shut), ("behind", straight(2.0))];
    let network = network(&pieces, &[((0, Out), (1, In)), ((1, Out), (2, In))]);
    assert!((network.centreline.length_m() - 4.3).abs() < 1e-12, "the reference path goes on");
    assert_eq!(network.path(&[], START, SHORT).expect("a path"), network.centreline);
    let stopped = network.path(&[Turn::Stop], START, SHORT).expect("a path");
    assert!((stopped.length_m() - 2.0).abs() < 1e-12);
    let back = network.path(&[Turn::TurnBack, Turn::Stop], START, SHORT).expect("a path");
    check(&back);
    assert!((back.length_m() - 2.0 * (2.0 - SHORT)).abs() < 1e-12);
    let refused = network.path(&[Turn::Left], START, SHORT).expect_err("no left").to_string();
    assert_eq!(
        refused,
        "turn 1 of the route, at `damper`, is \"left\"; a fitting that cannot be passed offers \"turn-back\", \"stop\""
    );
}

/// The search stays on its pass, whatever other pass goes by the same place.
#[test]
fn projection_stays_on_its_own_pass() {
    let network = fork();
    let route = [Turn::Straight, Turn::TurnBack, Turn::Right, Turn::TurnBack, Turn::Right, Turn::Stop];
    let path = network.path(&route, START, SHORT).expect("a way");
    let mut near = 0;
    let steps = 4000;
    for step in 0..=steps {
        let distance = path.length_m() * f64::from(step) / f64::from(steps);
        let point = path.pose_at(distance) * Point3::new(0.0, 0.05, 0.0);
        let forward = path.pose_at(distance).rotation * Vector3::x();
        // Just behind a turn, by its place alone a point could as well be just before it.
        let at = path.project_facing(&point, &forward, near, distance);
        assert!((at.distance_m - distance).abs() < 1e-9, "{distance}: {}", at.distance_m);
        assert!((at.lateral_m - 0.05).abs() < 1e-9);
        if near == at.segment {
            assert_eq!(path.project(&point, near), at);
        }
        near = at.segment;
    }
    // Past the turn, the way back has begun; it is not left again by going on.
    let turn = path.segments.iter().position(|segment| segment.turns_back).expect("it turns back");
    let turn_m = path.segments[turn].start_m;
    let beyond = path.pose_at(turn_m - 0.01) * Point3::new(0.21, 0.0, 0.0);
    let at = path.project(&beyond, turn - 1);
    assert_eq!(at.segment, turn);
    assert!((at.distance_m - (turn_m - 0.2)).abs() < 1e-9, "before the start of the way back");
    assert_eq!(path.project(&beyond, turn).segment, turn);
    // Short of the turn but facing back: on the way back.
    let place = path.pose_at(turn_m - 0.3);
    let (point, ahead) = (place * Point3::origin(), place.rotation * Vector3::x());
    assert!((path.project_facing(&point, &ahead, turn - 1, turn_m).distance_m - (turn_m - 0.3)).abs() < 1e-9);
    assert!((path.project_facing(&point, &-ahead, turn - 1, turn_m).distance_m - (turn_m + 0.3)).abs() < 1e-9);
}

#[test]
fn exploring_sees_every_branch_once() {
    let network = fork();
    let route = network.exploration(START);
    assert_eq!(route, [Turn::Left, Turn::TurnBack, Turn::Left, Turn::Stop]);
    check(&network.path(&route, START, SHORT).expect("a way"));
    // A cross with a tee on its left: all branches, each once in and once out but the last.
    let wide = fitting(Shape::Cross { branch_width_m: 0.5 });
    let pieces = [
        ("start", straight(1.0)),
        ("cross", wide),
        ("a", straight(2.0)),
        ("tee", tee(Hand::Left)),
        ("a1", straight(1.0)),
        ("a2", straight(1.0)),
        ("b", straight(2.0)),
        ("c", straight(2.0)),
    ];
    let joins = [
        ((0, Out), (1, In)),
        ((1, Left), (2, In)),
        ((2, Out), (3, In)),
        ((3, Left), (4, In)),
        ((3, Out), (5, In)),
        ((1, Out), (6, In)),
        ((1, Right), (7, In)),
    ];
    let network = self::network(&pieces, &joins);
    let route = network.exploration(START);
    let path = network.path(&route, START, SHORT).expect("a way");
    check(&path);
    let seen: BTreeSet<usize> = path.segments.iter().map(|segment| segment.fitting).collect();
    assert_eq!(seen.len(), 8);
    let visits = |fitting: usize| fittings(&path).iter().filter(|f| **f == fitting).count();
    assert_eq!([2, 4, 5, 6, 7].map(visits), [2, 1, 1, 1, 1], "dead ends once, the way to the tee there and back");
}

/// With a loop: every stretch is gone through, and the route ends.
#[test]
fn exploring_a_loop_ends() {
    // A square from a tee's two exits back into a second tee.
    let pieces = [
        ("start", straight(1.0)),
        ("one", tee(Hand::Left)),
        ("on", straight(2.0)),
        ("two", tee(Hand::Left)),
        ("far", straight(1.0)),
        ("up1", straight(1.0)),
        ("e1", mitre(-90.0)),
        ("across", straight(2.0)),
        ("e2", mitre(-90.0)),
        ("down", straight(1.0)),
    ];
    let joins = [
        ((0, Out), (1, In)),
        ((1, Out), (2, In)),
        ((2, Out), (3, In)),
        ((3, Out), (4, In)),
        ((1, Left), (5, In)),
        ((5, Out), (6, In)),
        ((6, Out), (7, In)),
        ((7, Out), (8, In)),
        ((8, Out), (9, In)),
        ((9, Out), (3, Left)),
    ];
    let network = network(&pieces, &joins);
    let route = network.exploration(START);
    let path = network.path(&route, START, SHORT).expect("a way");
    check(&path);
    let seen: BTreeSet<usize> = path.segments.iter().map(|segment| segment.fitting).collect();
    assert_eq!(seen.len(), 10, "{route:?}");
}

/// The example of the open end: turned back from, as a dead end is.
#[test]
fn an_open_exit_of_a_junction_can_be_left_by_but_is_not_explored() {
    let pieces = [("start", straight(1.0)), ("tee", tee(Hand::Right)), ("on", straight(2.0))];
    let pieces: Vec<Piece> = pieces.iter().map(|(name, fitting)| Piece { fitting: *fitting, name: (*name).to_owned() }).collect();
    let joins = [Join { a: (0, Out), b: (1, In) }, Join { a: (1, Out), b: (2, In) }];
    let network = Network::assemble(&pieces, &joins, &[((1, Right), End::Open)]).expect("possible");
    assert_eq!(network.exploration(START), [Turn::Straight, Turn::Stop]);
    let out = network.path(&[Turn::Right], START, SHORT).expect("a way out");
    assert!((out.length_m() - 1.0 - 0.25 * std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    let refused = network.path(&[Turn::Right, Turn::TurnBack], START, SHORT);
    assert!(matches!(&refused, Err(RouteError::NotOffered { index: 1, offers, .. }) if *offers == [Turn::Stop]), "{refused:?}");
}

/// Out of a branch backwards, past the junction, and on from there: on the way back as soon as it has left the way in.
#[test]
fn what_backs_out_of_a_branch_is_on_the_way_back_once_it_goes_on() {
    let path = fork().path(&[Turn::Left, Turn::TurnBack, Turn::Left, Turn::Stop], START, SHORT).expect("a way");
    let turn_m = path.segments.iter().find(|segment| segment.turns_back).expect("it turns back").start_m;
    let mut near = 0;
    // In and, still facing in, out again.
    let way_in = (0..100).map(|step| turn_m * f64::from(step) / 100.0);
    for distance in way_in.clone().chain(way_in.rev().filter(|distance| *distance > 0.4)) {
        let pose = path.pose_at(distance);
        let at = path.project_facing(&(pose * Point3::origin()), &(pose.rotation * Vector3::x()), near, turn_m);
        assert!((at.distance_m - distance).abs() < 1e-9 && at.lateral_m.abs() < 1e-9, "{distance}: {at:?}");
        near = at.segment;
    }
    // From before the tee straight past it: the path comes round its corner.
    let start = path.pose_at(0.4);
    let at = |along_m: f64, near: usize, farthest_m: f64| {
        path.project_facing(&(start * Point3::new(along_m, 0.0, 0.0)), &Vector3::x(), near, farthest_m)
    };
    let (mut skipped, mut farthest_m) = (near, 0.0_f64);
    for step in 0..=160 {
        near = at(0.01 * f64::from(step), near, turn_m).segment;
        // Who never was in the branch, and goes straight past it, has not come out of it.
        let past = at(0.01 * f64::from(step), skipped, farthest_m);
        (skipped, farthest_m) = (past.segment, farthest_m.max(past.distance_m));
    }
    assert!(at(1.6, skipped, farthest_m).distance_m < turn_m, "it has left the path");
    let there = at(1.6, near, turn_m);
    // Half a metre behind the tee, 2.5 m before the end of the duct.
    assert!((there.distance_m - (path.length_m() - 2.5)).abs() < 1e-9 && there.lateral_m.abs() < 1e-9, "{there:?}");
}
