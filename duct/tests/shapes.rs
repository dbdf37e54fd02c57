//! Every fitting, in both hands and at several angles and sizes: are its cells convex and closed, its ports where closed forms say, its
//! paths from port to port?

mod common;

use common::{HEIGHT, WIDTH, cases, corners, fitting, shapes, volume_m3, with_stubs};
use ductloop_duct::Transform;
use ductloop_duct::cell::{Beyond, Cell, Side};
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{AcrossAlign, Blade, Fitting, FittingError, Hand, Shape, UprightAlign};
use nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;

fn closed_cells(shape: Shape) -> Vec<Cell> {
    fitting(shape).cells(0, 0, |_| Side::Wall)
}

/// A pseudo-random direction and more, without a generator: Weyl's sequence.
fn weyl(i: u32, step: f64) -> f64 {
    let x = f64::from(i) * step;
    x - x.floor()
}

#[test]
fn every_cell_is_convex_and_every_outline_lies_on_its_face() {
    for shape in shapes() {
        for cell in closed_cells(shape) {
            for face in &cell.faces {
                for corner in &face.outline {
                    assert!(face.plane.distance(corner).abs() < 1e-12, "{shape:?}: a corner off its face");
                    assert!(cell.contains(corner, 1e-9), "{shape:?}: a corner outside its own cell");
                }
                let n = face.outline.len();
                for i in 0..n {
                    let [a, b, c] = [0, 1, 2].map(|k| face.outline[(i + k) % n]);
                    let turn = (b - a).cross(&(c - b)).dot(&face.plane.normal);
                    assert!(turn > 0.0, "{shape:?}: an outline that is not convex, or clockwise from outside");
                }
            }
        }
    }
}

#[test]
fn volumes_are_those_of_the_closed_forms() {
    for case in cases() {
        for shape in [case.shape, case.mirrored] {
            let volume: f64 = closed_cells(shape).iter().map(volume_m3).sum();
            assert!((volume - case.volume_m3).abs() < 1e-12, "{shape:?}: {volume}, not {}", case.volume_m3);
        }
    }
}

#[test]
fn mirrored_fittings_are_mirror_images() {
    let flip = |p: &Point3<f64>| Point3::new(p.x, -p.y, p.z);
    for case in cases() {
        let (shape, mirrored) = (fitting(case.shape), fitting(case.mirrored));
        let other = |name| match name {
            PortName::Left => PortName::Right,
            PortName::Right => PortName::Left,
            other => other,
        };
        for port in shape.ports() {
            let image = mirrored.port(other(port.name)).expect("the mirrored port");
            assert_eq!((port.width_m, port.height_m), (image.width_m, image.height_m));
            for point in [Point3::origin(), Point3::new(1.0, 0.0, 0.0)] {
                let off = flip(&(port.entry_from_port * point)) - image.entry_from_port * point;
                assert!(off.norm() < 1e-12, "{:?}: {off}", case.shape);
            }
        }
        let (cells, images) = (closed_cells(case.shape), closed_cells(case.mirrored));
        assert_eq!(cells.len(), images.len());
        // A point is within as many cells and solids as its image is. Corners of solids say where those are.
        for corner in cells.iter().flat_map(|cell| corners(cell).chain(cell.solids.iter().flat_map(|solid| &solid.corners))) {
            let image = flip(corner);
            let places: Vec<&Point3<f64>> =
                images.iter().flat_map(|cell| corners(cell).chain(cell.solids.iter().flat_map(|solid| &solid.corners))).collect();
            assert!(places.iter().any(|place| (*place - image).norm() < 1e-9), "{:?}: no corner at {image}", case.shape);
        }
    }
}

#[test]
fn portals_meet_their_counterparts() {
    for shape in shapes() {
        let network = with_stubs(shape).unwrap_or_else(|error| panic!("{shape:?}: {error}"));
        let mut joined = 0;
        for (id, cell) in network.cells.iter().enumerate() {
            for (face, portal) in cell.faces.iter().flat_map(|f| f.portals.iter().map(move |p| (f, p))) {
                let Beyond::Cell(next) = portal.beyond else { continue };
                joined += 1;
                let (other, back) = network.cells[next]
                    .faces
                    .iter()
                    .flat_map(|f| f.portals.iter().map(move |p| (f, p)))
                    .find(|(_, p)| p.beyond == Beyond::Cell(id))
                    .unwrap_or_else(|| panic!("{shape:?}: no way back from {next} to {id}"));
                assert!((face.plane.normal.into_inner() + other.plane.normal.into_inner()).norm() < 1e-9, "{shape:?}");
                assert_eq!(portal.outline.len(), back.outline.len());
                for corner in &portal.outline {
                    let nearest = back.outline.iter().map(|other| (other - corner).norm()).fold(f64::INFINITY, f64::min);
                    assert!(nearest < 1e-9, "{shape:?}, cells {id} and {next}: {nearest} m from the other side's corner");
                }
            }
        }
        assert!(joined >= 2 * network.fittings[0].ports().len(), "{shape:?}: a port leads nowhere");
    }
}

/// From inside a closed network every ray meets something, and never beyond the sheet metal: the cell of the hit holds it.
#[test]
fn closed_networks_are_watertight() {
    const RAYS: u32 = 10_000;
    for shape in shapes() {
        let network = with_stubs(shape).expect("possible");
        // A grille is open.
        let is_open = matches!(shape, Shape::Grille { .. });
        let mut escaped = 0;
        for i in 0..RAYS {
            let id = i as usize % network.cells.len();
            let all: Vec<Point3<f64>> = corners(&network.cells[id]).copied().collect();
            // A mixture of all corners, mostly near two of them.
            let weights: Vec<f64> = (0..all.len()).map(|k| 0.01 + libm::pow(weyl(i + 1, 0.31 + 0.171 * k as f64), 8.0)).collect();
            let total: f64 = weights.iter().sum();
            let sum = all.iter().zip(&weights).fold(Vector3::zeros(), |sum, (p, w)| sum + p.coords * *w);
            let origin = Point3::from(sum / total);
            let z = 2.0 * weyl(i, 0.754_877_666_246_693) - 1.0;
            let (s, c) = libm::sincos(std::f64::consts::TAU * weyl(i, 0.569_840_290_998_053));
            let flat = (1.0 - z * z).sqrt();
            match network.cast(id, &origin, &Unit::new_normalize(Vector3::new(c * flat, s * flat, z)), 1e3) {
                None => escaped += 1,
                Some(hit) => assert!(network.cells[hit.cell].contains(&hit.point, 1e-9), "{shape:?}: a hit outside its cell"),
            }
        }
        assert_eq!(escaped > 0, is_open, "{shape:?}: {escaped} rays escaped");
    }
}

#[test]
fn ports_are_where_closed_forms_say() {
    let at = |fitting: &Fitting, name| fitting.port(name).expect("it has this port").entry_from_port;
    let near = |pose: Transform, [x, y, z]: [f64; 3], heading_deg: f64| {
        let forward = pose.rotation * Vector3::x();
        let (s, c) = libm::sincos(heading_deg.to_radians());
        let off = (pose.translation.vector - Vector3::new(x, y, z)).norm() + (forward - Vector3::new(c, s, 0.0)).norm();
        assert!(off < 1e-12, "{pose:?} is not at {x} {y} {z}, {heading_deg} degrees");
        assert!((pose.rotation * Vector3::z() - Vector3::z()).norm() < 1e-12, "ports stand upright");
    };
    for shape in shapes() {
        near(at(&fitting(shape), PortName::In), [0.0; 3], 180.0);
    }
    for (hand, side, heading) in [(Hand::Left, 1.0, 90.0), (Hand::Right, -1.0, -90.0)] {
        let name = if hand == Hand::Left { PortName::Left } else { PortName::Right };
        let tee = fitting(Shape::Tee { hand, branch_width_m: 0.4 });
        near(at(&tee, PortName::Out), [0.4, 0.0, 0.0], 0.0);
        near(at(&tee, name), [0.2, side * 0.25, 0.0], heading);
        assert_eq!(tee.ports().len(), 3);
        let branch = fitting(Shape::SideBranch { hand, branch_width_m: 0.4, shoe_m: 0.1 });
        near(at(&branch, PortName::Out), [0.5, 0.0, 0.0], 0.0);
        near(at(&branch, name), [0.3, side * 0.35, 0.0], heading);
        let bullhead = fitting(Shape::BullheadTee { branch_width_m: 0.4 });
        near(at(&bullhead, name), [0.2, side * 0.25, 0.0], heading);
        assert_eq!(bullhead.port(PortName::Out), None);
        let cross = fitting(Shape::Cross { branch_width_m: 0.4 });
        near(at(&cross, name), [0.2, side * 0.25, 0.0], heading);
        near(at(&cross, PortName::Out), [0.4, 0.0, 0.0], 0.0);
        // As wide as the stem, at 60 degrees: ports from the walls' ends to the middle.
        let wye = fitting(Shape::Wye { half_angle_rad: std::f64::consts::FRAC_PI_3, branch_width_m: 0.5 });
        near(at(&wye, name), [0.25 * libm::sin(std::f64::consts::FRAC_PI_3), side * 0.125, 0.0], side * 60.0);
    }
    let slope = fitting(Shape::Slope { length_m: 2.0, angle_rad: 10_f64.to_radians() });
    near(at(&slope, PortName::Out), [2.0, 0.0, 2.0 * libm::tan(10_f64.to_radians())], 0.0);
    let offset = fitting(Shape::Offset { length_m: 1.0, aside_m: -0.3 });
    near(at(&offset, PortName::Out), [1.0, -0.3, 0.0], 0.0);
    for (across, y) in [(AcrossAlign::Concentric, 0.0), (AcrossAlign::Left, 0.1), (AcrossAlign::Right, -0.1)] {
        for (upright, z) in [(UprightAlign::FlatBottom, 0.0), (UprightAlign::Concentric, 0.05)] {
            let shape = Shape::Transition { length_m: 0.5, to_width_m: 0.3, to_height_m: 0.2, across, upright };
            near(at(&fitting(shape), PortName::Out), [0.5, y, z], 0.0);
            let out = fitting(shape).port(PortName::Out).expect("it has one");
            assert_eq!((out.width_m, out.height_m), (0.3, 0.2));
        }
    }
}

/// Every passage of every fitting starts at one port and ends at the other, in their directions, without a kink, and inside.
#[test]
fn passages_lead_from_port_to_port_inside_the_cells() {
    const STEPS: usize = 40;
    for shape in shapes() {
        let it = fitting(shape);
        let cells = closed_cells(shape);
        // Two arcs rise by their length, a slanting floor by its own: between them are tenths of a millimetre.
        let bends_and_rises = matches!(shape, Shape::Transition { across, upright: UprightAlign::Concentric, .. }
            if across != AcrossAlign::Concentric);
        let above = if bends_and_rises { 5e-4 } else { 1e-6 };
        for from in it.ports() {
            for to in it.ports().into_iter().filter(|to| to.name != from.name) {
                let what = format!("{shape:?} from {} to {}", from.name, to.name);
                let path = it.passage(from.name, to.name).unwrap_or_else(|| panic!("{what}: no way"));
                let mut expected = from.entry_from_port;
                let mut forward = -(expected.rotation * Vector3::x());
                for piece in &path {
                    let start = piece.entry_from_start;
                    assert!((start.translation.vector - expected.translation.vector).norm() < 1e-9, "{what}: a gap");
                    assert!((start.rotation * Vector3::x() - forward).norm() < 1e-9, "{what}: a kink");
                    assert!(piece.length_m > 0.0);
                    for step in 0..=STEPS {
                        let along = piece.length_m * step as f64 / STEPS as f64 * libm::cos(piece.pitch_rad);
                        let mut pose = start * ductloop_duct::centreline::start_from_along(piece.curvature_1_m, along);
                        pose.translation.z += along * libm::tan(piece.pitch_rad);
                        let low = pose * Point3::new(0.0, 0.0, above);
                        assert!(cells.iter().any(|cell| cell.contains(&low, 1e-9)), "{what}: outside at {low}");
                        (expected, forward) = (pose, pose.rotation * Vector3::x());
                    }
                }
                let end = to.entry_from_port;
                assert!((end.translation.vector - expected.translation.vector).norm() < 1e-9, "{what}: ends at {expected}");
                assert!((end.rotation * Vector3::x() - forward).norm() < 1e-9, "{what}: ends askew");
                let (first, last) = (path[0], path[path.len() - 1]);
                assert_eq!((first.width_m[0], first.height_m[0]), (from.width_m, from.height_m), "{what}");
                let off = (last.width_m[1] - to.width_m).abs() + (last.height_m[1] - to.height_m).abs();
                assert!(off < 1e-12, "{what}");
                // The other way round it is the same path.
                let back = it.passage(to.name, from.name).expect("both ways");
                let length = |path: &[ductloop_duct::fitting::passage::PathPiece]| path.iter().map(|p| p.length_m).sum::<f64>();
                assert!((length(&path) - length(&back)).abs() < 1e-12, "{what}");
                for (piece, reversed) in path.iter().zip(back.iter().rev()) {
                    assert!((piece.curvature_1_m + reversed.curvature_1_m).abs() < 1e-9 * piece.curvature_1_m.abs().max(1.0));
                    assert!((piece.pitch_rad + reversed.pitch_rad).abs() < 1e-12);
                }
            }
        }
    }
}

/// The arc of a turn in a junction is tangent to both centrelines, with half the narrower width as its radius.
#[test]
fn turns_in_junctions_have_half_the_narrower_width_as_radius() {
    for (branch_width_m, radius_m) in [(0.5, 0.25), (0.3, 0.15), (0.8, 0.25)] {
        let shapes = [
            Shape::Tee { hand: Hand::Left, branch_width_m },
            Shape::BullheadTee { branch_width_m },
            Shape::SideBranch { hand: Hand::Left, branch_width_m, shoe_m: 0.1 },
            Shape::Cross { branch_width_m },
            Shape::Wye { half_angle_rad: 0.7, branch_width_m },
        ];
        for shape in shapes {
            let path = fitting(shape).passage(PortName::In, PortName::Left).expect("a way left");
            let arcs: Vec<f64> = path.iter().map(|p| p.curvature_1_m).filter(|c| *c != 0.0).collect();
            assert_eq!(arcs.len(), 1, "{shape:?}");
            assert!((1.0 / arcs[0] - radius_m).abs() < 1e-9, "{shape:?}: {}", 1.0 / arcs[0]);
        }
    }
}

#[test]
fn what_cannot_be_made_is_refused() {
    let positive = |error| matches!(error, Err(FittingError::NotPositive { .. }));
    let too_large = |error| matches!(error, Err(FittingError::TooLarge { .. }));
    let out_of_range = |error| matches!(error, Err(FittingError::OutOfRange { .. }));
    let check = |shape| fitting(shape).validate();
    let transition = |length_m, to_width_m, across| Shape::Transition {
        length_m,
        to_width_m,
        to_height_m: HEIGHT,
        across,
        upright: UprightAlign::FlatBottom,
    };
    assert!(positive(check(Shape::Tee { hand: Hand::Left, branch_width_m: 0.0 })));
    assert!(positive(check(Shape::Slope { length_m: f64::NAN, angle_rad: 0.1 })));
    assert!(positive(check(Shape::Drop { length_m: 1.0, hole_length_m: 0.5, hole_width_m: 0.3, depth_m: -1.0 })));
    assert!(too_large(check(transition(0.09, 0.3, AcrossAlign::Concentric))));
    assert_eq!(check(transition(0.11, 0.3, AcrossAlign::Concentric)), Ok(()));
    assert!(too_large(check(transition(0.11, 0.3, AcrossAlign::Left))), "one side draws in by all of it");
    assert!(too_large(check(Shape::Offset { length_m: 0.5, aside_m: 0.6 })));
    assert!(too_large(check(Shape::Offset { length_m: 0.4, aside_m: 0.3 })), "arcs of 0.21 m about which no duct of 0.5 m bends");
    assert!(too_large(check(Shape::Drop { length_m: 1.0, hole_length_m: 0.5, hole_width_m: WIDTH + 0.01, depth_m: 1.0 })));
    assert!(out_of_range(check(Shape::Slope { length_m: 1.0, angle_rad: 0.18 })));
    assert!(out_of_range(check(Shape::Wye { half_angle_rad: 0.5, branch_width_m: 0.5 })));
    assert!(check(Shape::VanedElbow { angle_rad: 2.2 }).is_err());
}

/// Vanes leave no way for a robot, an open damper leaves it all but the curtain, a shut one none.
#[test]
fn vanes_and_curtains_stand_in_the_way() {
    let network = with_stubs(Shape::VanedElbow { angle_rad: 90_f64.to_radians() }).expect("possible");
    let vanes: Vec<_> = network.cells[0].solids.iter().collect();
    // 0.707 m of mitre line at 83 mm a vane.
    assert_eq!(vanes.len(), 8);
    for solid in &vanes {
        assert!(network.encloses(solid), "a vane reaches into the sheet");
    }
    assert!(!fitting(Shape::VanedElbow { angle_rad: 1.0 }).is_passable());
    for (blade, share) in [(Blade::Open, 0.88), (Blade::Shut, 0.0)] {
        let network = with_stubs(Shape::Damper { length_m: 0.3, blade }).expect("possible");
        assert!(network.cells.iter().flat_map(|cell| &cell.solids).all(|solid| network.encloses(solid)));
        for up in [0.05, 0.5, 0.85, 0.9, 0.95] {
            let hit = network.cast(0, &Point3::new(0.001, 0.1, up * HEIGHT), &Vector3::x_axis(), 100.0).expect("something");
            assert_eq!(hit.distance_m > 0.3, up < share, "{blade:?} at {up}");
        }
    }
}

/// Through the hole in the floor one sees the shaft's floor, beside it the duct's.
#[test]
fn a_drop_has_a_shaft_below() {
    let network =
        with_stubs(Shape::Drop { length_m: 0.8, hole_length_m: 0.4, hole_width_m: 0.3, depth_m: 1.0 }).expect("possible");
    for (x, y, depth) in [(0.4, 0.0, 1.0), (0.21, 0.14, 1.0), (0.19, 0.0, 0.0), (0.4, 0.16, 0.0)] {
        let hit = network.cast(0, &Point3::new(x, y, 0.2), &-Vector3::z_axis(), 100.0).expect("a floor");
        assert!((hit.distance_m - 0.2 - depth).abs() < 1e-12, "{x} {y}");
    }
}

proptest! {
    /// A random point of a cell is in that cell and, away from boundaries, in no other.
    #[test]
    fn a_point_is_in_one_cell(seed in 0_u32..1_000_000, which in 0_usize..1000) {
        let all = shapes();
        let shape = all[which % all.len()];
        let network = with_stubs(shape).expect("possible");
        let id = seed as usize % network.cells.len();
        let points: Vec<Point3<f64>> = corners(&network.cells[id]).copied().collect();
        let weights: Vec<f64> = (0..points.len()).map(|k| 1e-3 + weyl(seed + 1, 0.317 + 0.1713 * k as f64)).collect();
        let total: f64 = weights.iter().sum();
        let sum = points.iter().zip(&weights).fold(Vector3::zeros(), |sum, (p, w)| sum + p.coords * *w);
        let point = Point3::from(sum / total);
        prop_assert!(network.cells[id].contains(&point, 1e-12));
        for (other, cell) in network.cells.iter().enumerate() {
            prop_assert_eq!(cell.contains(&point, -1e-9), other == id && network.cells[id].contains(&point, -1e-9), "{:?}", shape);
        }
    }
}
