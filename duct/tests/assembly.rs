//! Pieces joined port to port: what fits, and what is refused with the names of both ends.

mod common;

use common::{HEIGHT, WIDTH, fitting, mitre, straight, tee};
use ductloop_duct::cell::SurfaceId;
use ductloop_duct::fitting::port::PortName::{self, In, Left, Out, Right};
use ductloop_duct::fitting::{AcrossAlign, Fitting, Hand, Shape, UprightAlign};
use ductloop_duct::network::{End, Join, Network, NetworkError, Piece, PortRef};
use nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;

fn piece(name: &str, fitting: Fitting) -> Piece {
    Piece { fitting, name: name.to_owned() }
}

fn join(a: PortRef, b: PortRef) -> Join {
    Join { a, b }
}

/// Pieces one after the other, "p0", "p1", …
fn chain(fittings: &[Fitting]) -> (Vec<Piece>, Vec<Join>) {
    let pieces = fittings.iter().enumerate().map(|(i, f)| piece(&format!("p{i}"), *f)).collect();
    (pieces, (1..fittings.len()).map(|i| join((i - 1, Out), (i, In))).collect())
}

/// A square of four straights and four elbows, the last straight shorter than its opposite by so much.
fn square(short_m: f64) -> Result<Network, NetworkError> {
    let elbow = fitting(Shape::RadiusElbow { angle_rad: std::f64::consts::FRAC_PI_2, throat_radius_m: 0.3 });
    let sides = [1.0, 2.0, 1.0, 2.0 - short_m];
    let fittings: Vec<Fitting> = sides.iter().flat_map(|side| [straight(*side), elbow]).collect();
    let (pieces, mut joins) = chain(&fittings);
    joins.push(join((7, Out), (0, In)));
    Network::assemble(&pieces, &joins, &[])
}

#[test]
fn a_square_closes_and_one_a_millimetre_short_does_not() {
    let closed = square(0.0).expect("it closes");
    assert_eq!(closed.joined_ports().len(), 8);
    // Round and back where it began.
    assert!((closed.centreline.length_m() - 6.0 - 4.0 * 0.55 * std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    let refused = square(1e-3);
    let Err(NetworkError::Gap { a, b, off_mm, off_deg, join: 7 }) = &refused else { panic!("{refused:?}") };
    assert_eq!((a.as_str(), b.as_str()), ("p7.out", "p0.in"));
    assert!((off_mm - 1.0).abs() < 1e-6 && *off_deg < 1e-6, "{off_mm} {off_deg}");
    let told = refused.expect_err("just seen").to_string();
    assert_eq!(told, "`p7.out` and `p0.in` do not meet: they are 1.000 mm apart and 0.0000 degrees askew");
}

#[test]
fn a_cycle_that_comes_back_askew_says_by_how_much() {
    let (pieces, mut joins) = chain(&[mitre(90.0), mitre(90.0), mitre(90.0), mitre(80.0)]);
    joins.push(join((3, Out), (0, In)));
    let refused = Network::assemble(&pieces, &joins, &[]);
    assert!(matches!(refused, Err(NetworkError::Gap { off_deg, .. }) if (off_deg - 10.0).abs() < 1e-6), "{refused:?}");
}

#[test]
fn what_cannot_be_joined_is_named() {
    let pieces = [piece("trunk", straight(1.0)), piece("branching", tee(Hand::Left)), piece("leg", straight(1.0))];
    let told = |joins: &[Join], ends: &[(PortRef, End)]| {
        Network::assemble(&pieces, joins, ends).expect_err("it cannot be made").to_string()
    };
    let trunk = join((0, Out), (1, In));
    assert_eq!(
        told(&[trunk, join((1, Right), (2, In))], &[]),
        "`branching`, a tee, has no port `right`; it has `in`, `out`, `left`"
    );
    assert_eq!(
        told(&[trunk, join((1, Out), (2, In)), join((1, Left), (2, In))], &[]),
        "`leg.in` is joined to `branching.out` and to `branching.left`; a port can be joined once"
    );
    assert_eq!(
        told(&[trunk, join((1, Left), (2, In))], &[((1, Left), End::Open)]),
        "`branching.left` is joined to `leg.in` and to the open; a port can be joined once"
    );
    assert_eq!(told(&[trunk], &[]), "`leg` is not joined to the rest: no way leads to it from `trunk`");
    assert_eq!(told(&[trunk, join((1, Left), (3, In))], &[]), "there is no piece 3; there are 3, counted from 0");
    let narrow = Fitting { width_m: 0.4, ..straight(1.0) };
    let refused = Network::assemble(&[piece("a", straight(1.0)), piece("b", narrow)], &[join((0, Out), (1, In))], &[]);
    assert_eq!(
        refused.expect_err("sizes differ").to_string(),
        "`a.out` is 0.5 x 0.3 m and `b.in` is 0.4 x 0.3 m: ports that are joined must have the same size"
    );
    let twice = Network::assemble(&[piece("a", straight(1.0)), piece("a", straight(1.0))], &[], &[]);
    assert_eq!(twice.expect_err("same name").to_string(), "two pieces are called `a`: fittings 0 and 1, counted from 0");
    let bad = Network::assemble(&[piece("a", straight(1.0)), piece("b", straight(-1.0))], &[], &[]);
    assert_eq!(bad.expect_err("impossible").to_string(), "`b`: the length is -1 m; it must be positive and finite");
    assert_eq!(Network::assemble(&[], &[], &[]), Err(NetworkError::Empty));
}

#[test]
fn overlapping_pieces_are_refused_with_both_names() {
    let run = [tee(Hand::Left), mitre(90.0), straight(1.0), mitre(90.0), straight(2.0)];
    let (mut pieces, mut joins) = chain(&run);
    let net = Network::assemble(&pieces, &joins, &[]);
    assert!(net.is_ok(), "{net:?}");
    // From the branch, right into what comes back over it.
    pieces.push(piece("branch", straight(2.0)));
    joins.push(join((0, Left), (5, In)));
    let refused = Network::assemble(&pieces, &joins, &[]).expect_err("they cross").to_string();
    assert_eq!(refused, "`p4` and `branch` overlap");
}

/// Three sides of a square that climb: over itself if it climbs by more than its height, through itself else.
#[test]
fn ducts_that_pass_over_each_other_do_not_overlap() {
    let crossing = |deg: f64| {
        let slope = fitting(Shape::Slope { length_m: 2.0, angle_rad: deg.to_radians() });
        let (pieces, joins) = chain(&[straight(2.0), mitre(90.0), slope, mitre(90.0), straight(1.5), mitre(90.0), straight(3.0)]);
        Network::assemble(&pieces, &joins, &[])
    };
    // 2 m at 8 degrees climb 0.281 m, at 9 degrees 0.317 m; the duct is 0.3 m high.
    let through = crossing(8.0).expect_err("through itself").to_string();
    assert_eq!(through, "`p0` and `p6` overlap");
    let over = crossing(9.0).expect("over itself");
    assert!((over.world_from_fitting[6].translation.z - 2.0 * libm::tan(9_f64.to_radians())).abs() < 1e-12);
}

/// Two slopes that pass each other edge to edge: apart only along the cross product of an edge of each.
#[test]
fn sloped_pieces_are_told_apart_by_their_edges() {
    let (width_m, height_m) = (0.2, 0.1);
    let at = |shape| Fitting { shape, width_m, height_m, surface: SurfaceId(0) };
    let climb = at(Shape::Slope { length_m: 3.0, angle_rad: 10_f64.to_radians() });
    let run = |lift: f64| {
        let lift = at(Shape::Slope { length_m: 1.0, angle_rad: libm::atan(lift) });
        let elbow = at(Shape::MitredElbow { angle_rad: std::f64::consts::FRAC_PI_2 });
        let fall = at(Shape::Slope { length_m: 3.0, angle_rad: -10_f64.to_radians() });
        let level = at(Shape::Straight { length_m: 1.2 });
        chain(&[climb, elbow, lift, elbow, level, elbow, fall])
    };
    // The way back falls across the climb. How high above it, at the worst corner, is a closed form; the search must agree.
    for lift in [-0.17, -0.1, -0.05, 0.0, 0.05, 0.1, 0.17] {
        let (pieces, joins) = run(lift);
        let result = Network::assemble(&pieces, &joins, &[]);
        let tan = libm::tan(10_f64.to_radians());
        // Plan: the climb lies along x; elbows of 0.2 m; the fall starts at y = 0.1 + 1.0 + 0.2 - 0.1 … and goes along -y over x.
        let (slope_end_z, lift_z) = (3.0 * tan, lift);
        let x = 3.1 - 0.1 - 1.2 - 0.1;
        let (x_near, x_far) = (x - 0.1, x + 0.1);
        let start_y = 1.2 - 0.1;
        // Floor of the fall over y in [-0.1, 0.1], ceiling of the climb over x in [x_near, x_far], and the other way round.
        let fall_floor = |y: f64| slope_end_z + lift_z - tan * (start_y - y);
        let gap_above = fall_floor(-0.1) - (x_far * tan + height_m);
        let gap_below = x_near * tan - (fall_floor(0.1) + height_m);
        let clear = gap_above.max(gap_below);
        if clear > 2e-3 {
            assert!(result.is_ok(), "lift {lift}: clear by {clear}, and {result:?}");
        } else if clear < -0.02 {
            assert!(matches!(result, Err(NetworkError::Overlap { first: 0, second: 6, .. })), "lift {lift}: {clear} {result:?}");
        }
    }
}

/// A tree of every junction, closed: no ray escapes, and each port leads where the joins say.
#[test]
fn a_network_of_all_junctions_is_watertight() {
    let all = [
        piece("start", straight(1.0)),
        piece("tee", tee(Hand::Left)),
        piece("on", straight(3.0)),
        piece("cross", fitting(Shape::Cross { branch_width_m: 0.5 })),
        piece("wye-leg", straight(4.0)),
        piece("wye", fitting(Shape::Wye { half_angle_rad: 0.785, branch_width_m: 0.5 })),
        piece("up", straight(1.0)),
        piece("bull", fitting(Shape::BullheadTee { branch_width_m: 0.5 })),
        piece("shoe-leg", straight(1.5)),
        piece("shoe", fitting(Shape::SideBranch { hand: Hand::Right, branch_width_m: 0.5, shoe_m: 0.12 })),
        piece(
            "narrower",
            fitting(Shape::Transition {
                length_m: 0.5,
                to_width_m: 0.3,
                to_height_m: 0.2,
                across: AcrossAlign::Left,
                upright: UprightAlign::Concentric,
            }),
        ),
    ];
    let joins = [
        join((0, Out), (1, In)),
        join((1, Out), (2, In)),
        join((2, Out), (3, In)),
        join((3, Out), (4, In)),
        join((4, Out), (5, In)),
        join((1, Left), (6, In)),
        join((6, Out), (7, In)),
        join((3, Right), (8, In)),
        // Entered by its branch.
        join((8, Out), (9, Right)),
        join((5, Left), (10, In)),
    ];
    let network = Network::assemble(&all, &joins, &[]).expect("possible");
    for (a, b) in network.joined_ports() {
        let (out, into) = (network.world_from_port(a).expect("a port"), network.world_from_port(b).expect("a port"));
        assert!((out.translation.vector - into.translation.vector).norm() < 1e-12);
        assert!((out.rotation * Vector3::x() + into.rotation * Vector3::x()).norm() < 1e-12);
    }
    let origin = Point3::new(0.5, 0.01, HEIGHT / 3.0);
    for i in 0..10_000 {
        let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / 10_000.0;
        let (s, c) = libm::sincos(f64::from(i) * 0.7);
        let flat = (1.0 - z * z).sqrt();
        let ray = Unit::new_normalize(Vector3::new(c * flat, s * flat, z * 0.01));
        let hit = network.cast(0, &origin, &ray, 1e3).unwrap_or_else(|| panic!("ray {i} escaped"));
        assert!(network.cells[hit.cell].contains(&hit.point, 1e-9));
    }
    // Of the same network with an open end at the wye's right, rays get out; there is a straight view down the trunk's right half.
    let open = Network::assemble(&all, &joins, &[((3, Left), End::Open)]).expect("possible");
    let cell = open.cell_at(&(open.world_from_fitting[3] * Point3::new(0.25, 0.0, 0.1)), 0).expect("inside");
    let origin = open.world_from_fitting[3] * Point3::new(0.25, 0.0, 0.1);
    assert_eq!(open.cast(cell, &origin, &Vector3::y_axis(), 1e3), None);
}

/// However a network is entered into the list, it is the same network.
#[test]
fn a_piece_may_be_joined_by_any_port() {
    // The tee entered by its `out` and left by its branch: a turn to the right for one who comes that way.
    let pieces = [piece("a", straight(1.0)), piece("t", tee(Hand::Left)), piece("b", straight(1.0))];
    let network = Network::assemble(&pieces, &[join((1, Out), (0, Out)), join((2, Out), (1, Left))], &[]).expect("possible");
    let end = network.world_from_port((2, In)).expect("a port");
    let expected = Vector3::new(1.0 + WIDTH / 2.0, -WIDTH / 2.0 - 1.0, 0.0);
    assert!((end.translation.vector - expected).norm() < 1e-12, "{end:?}");
    assert!((end.rotation * Vector3::x() + Vector3::y()).norm() < 1e-12);
}

proptest! {
    /// A shape joined by any of its ports to a duct, and a duct to each other: it stands as the ports say.
    #[test]
    fn ports_that_are_joined_face_each_other(which in 0_usize..1000, by in 0_usize..4) {
        let shapes = common::shapes();
        let it = fitting(shapes[which % shapes.len()]);
        let ports = it.ports();
        let by = ports[by % ports.len()];
        let lead = Fitting { width_m: by.width_m, height_m: by.height_m, ..straight(0.7) };
        let network = Network::assemble(&[piece("lead", lead), piece("it", it)], &[join((0, Out), (1, by.name))], &[]);
        let network = network.expect("possible");
        let out = network.world_from_port((1, by.name)).expect("a port");
        prop_assert!((out.translation.vector - Vector3::new(0.7, 0.0, 0.0)).norm() < 1e-12);
        prop_assert!((out.rotation * Vector3::x() + Vector3::x()).norm() < 1e-12);
        prop_assert!(PortName::ALL.iter().all(|name| network.attached((1, *name)).is_some() == it.port(*name).is_some()));
    }
}
