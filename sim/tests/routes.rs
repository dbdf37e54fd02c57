//! Truth along a route: through junctions, into a dead end and back.

mod common;

use common::{HZ, SpeedLoop, fitting, pose, world};
use ductloop_duct::fitting::port::PortName::{In, Left, Out};
use ductloop_duct::fitting::{Hand, Shape};
use ductloop_duct::network::{Join, Network, Piece, Turn};
use ductloop_nav::messages::Sides;
use ductloop_sim::RobotSpec;

fn piece(name: &str, shape: Shape) -> Piece {
    Piece { fitting: fitting(shape), name: name.to_owned() }
}

#[test]
fn the_truth_follows_a_route_into_a_branch_and_out_again() {
    let straight = |name, length_m| piece(name, Shape::Straight { length_m });
    let pieces = [
        straight("supply", 1.2),
        piece("tee", Shape::Tee { hand: Hand::Left, branch_width_m: 0.5 }),
        straight("branch", 1.2),
        straight("main", 1.5),
    ];
    let joins = [Join { a: (0, Out), b: (1, In) }, Join { a: (1, Left), b: (2, In) }, Join { a: (1, Out), b: (3, In) }];
    let network = Network::assemble(&pieces, &joins, &[]).expect("a network");
    let path = network.path(&[Turn::Left, Turn::TurnBack, Turn::Left], (0, In), 0.3).expect("a route");
    let robot = RobotSpec::incra1();
    let mut world = world(&network, &robot, &pose(0.4, 0.0, 0.0));
    world.follow(&path);
    let mut hold = SpeedLoop::new();
    let mut before = world.truth();
    let (mut fittings, mut segments, mut turned) = (vec![before.fitting], vec![before.segment], 0.0);
    while before.distance_m < path.length_m() - 0.4 {
        let truth = world.truth();
        if fittings.last() != Some(&truth.fitting) {
            fittings.push(truth.fitting);
        }
        if segments.last() != Some(&truth.segment) {
            segments.push(truth.segment);
        }
        // At the turn it is at one place of the path however long it turns; elsewhere a tick is 0.2 mm, a little more inside of a bend.
        let step = truth.distance_m - before.distance_m;
        assert!(step.abs() < 1e-3, "{step} m at {} m", truth.distance_m);
        assert!(truth.lateral_m.abs() < 0.1, "{truth:?}");
        // Where the path turns back it is faced the wrong way, and turned round on the spot.
        let spins = truth.heading_rad.abs() > 0.7;
        turned += if spins { 1.0 / f64::from(HZ) } else { 0.0 };
        let speed = if spins { 0.0 } else { 0.25 };
        let segment = path.segment_at(truth.distance_m);
        let yaw_rate =
            (speed * segment.curvature_1_m - 3.0 * truth.lateral_m * f64::from(u8::from(!spins)) - 2.0 * truth.heading_rad)
                .clamp(-1.0, 1.0);
        let half = robot.chi() * robot.track_m / 2.0 * yaw_rate;
        hold.step(
            &mut world,
            Sides { left: (speed - half) / robot.wheel_radius_m, right: (speed + half) / robot.wheel_radius_m },
        );
        before = truth;
        assert!(world.tick() < 90 * u64::from(HZ), "{truth:?}");
    }
    println!("{fittings:?} {segments:?}, {:.1} s turning, {:?}", turned, world.collisions());
    assert_eq!(fittings, [0, 1, 2, 1, 3]);
    assert!(segments.is_sorted() && segments.last() == Some(&(path.segments.len() - 1)), "{segments:?}");
    assert!(turned > 1.0);
    assert_eq!(world.collisions().count, 0);
}

#[test]
fn without_a_route_truth_is_measured_along_the_network_s_own_path() {
    let network = common::straight(3.0);
    let mut world = world(&network, &RobotSpec::incra1(), &pose(1.0, 0.05, 0.1));
    let before = world.truth();
    world.follow(&network.centreline);
    assert_eq!(world.truth(), before);
}
