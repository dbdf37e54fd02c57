//! Networks of every fitting that there is: are they closed, do portals meet, does the centreline run through their middle?

use ductloop_duct::Transform;
use ductloop_duct::cell::{Beyond, Solid, SurfaceId};
use ductloop_duct::fitting::{Fitting, Shape};
use ductloop_duct::network::{End, Network, NetworkError};
use nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;

const WIDTH: f64 = 0.5;
const HEIGHT: f64 = 0.3;

fn fitting(shape: Shape) -> Fitting {
    Fitting { shape, width_m: WIDTH, height_m: HEIGHT, surface: SurfaceId(0) }
}

fn straight(length_m: f64) -> Fitting {
    fitting(Shape::Straight { length_m })
}

fn radius(deg: f64) -> Fitting {
    fitting(Shape::RadiusElbow { angle_rad: deg.to_radians(), throat_radius_m: 0.375 })
}

fn mitre(deg: f64) -> Fitting {
    fitting(Shape::MitredElbow { angle_rad: deg.to_radians() })
}

fn zigzag() -> Network {
    let run =
        [straight(1.0), radius(90.0), straight(0.8), mitre(-90.0), straight(0.7), mitre(45.0), radius(-60.0), straight(1.0)];
    Network::from_run(&run, End::Cap, End::Open).expect("a possible run")
}

#[test]
fn every_cell_is_convex_and_every_outline_lies_on_its_face() {
    for cell in &zigzag().cells {
        for face in &cell.faces {
            for corner in &face.outline {
                assert!(face.plane.distance(corner).abs() < 1e-12, "a corner off its face");
                assert!(cell.contains(corner, 1e-9), "a corner outside its own cell");
            }
            let centre = face.outline.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / face.outline.len() as f64;
            let normal = (face.outline[1] - face.outline[0]).cross(&(face.outline[2] - face.outline[1]));
            assert!(normal.dot(&face.plane.normal) > 0.0, "an outline that is clockwise from outside");
            assert!(cell.contains(&Point3::from(centre), 1e-9));
        }
    }
}

#[test]
fn portals_meet_their_counterparts() {
    let network = zigzag();
    for (id, cell) in network.cells.iter().enumerate() {
        for (face, portal) in cell.faces.iter().flat_map(|f| f.portals.iter().map(move |p| (f, p))) {
            let Beyond::Cell(next) = portal.beyond else { continue };
            let back = network.cells[next]
                .faces
                .iter()
                .flat_map(|f| f.portals.iter().map(move |p| (f, p)))
                .find(|(_, p)| p.beyond == Beyond::Cell(id))
                .expect("a way back");
            assert!((face.plane.normal.into_inner() + back.0.plane.normal.into_inner()).norm() < 1e-9);
            for corner in &portal.outline {
                let nearest = back.1.outline.iter().map(|other| (other - corner).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-9, "cells {id} and {next}: a portal's corner {nearest} m from the other side's");
            }
        }
    }
}

#[test]
fn only_the_open_end_lets_rays_out() {
    let network = zigzag();
    let origin = network.centreline.pose_at(0.5) * Point3::new(0.0, 0.0, 0.15);
    let cell = network.cell_at(&origin, 0).expect("inside");
    // Through an elbow of 90 degrees no straight ray leaves.
    for i in 0..2000 {
        let (s, c) = libm::sincos(f64::from(i) * 0.7);
        let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / 2000.0;
        let flat = (1.0 - z * z).sqrt();
        let hit = network.cast(cell, &origin, &Unit::new_normalize(Vector3::new(c * flat, s * flat, z)), 100.0);
        assert!(hit.is_some(), "ray {i} escaped");
    }
    let at_end = network.centreline.pose_at(network.centreline.length_m() - 0.3);
    let origin = at_end * Point3::new(0.0, 0.0, 0.15);
    let cell = network.cell_at(&origin, network.cells.len() - 1).expect("inside");
    let ahead = Unit::new_normalize(at_end.rotation * Vector3::x());
    assert_eq!(network.cast(cell, &origin, &ahead, 100.0), None);
}

#[test]
fn a_ray_across_a_straight_meets_the_wall_at_half_the_width() {
    let network = Network::from_run(&[straight(1.0), straight(2.0)], End::Cap, End::Cap).expect("possible");
    let origin = Point3::new(0.4, 0.1, 0.15);
    // cast aims from the first fitting obliquely into the second.
    let direction = Unit::new_normalize(Vector3::new(1.0, 0.1, 0.0));
    let hit = network.cast(0, &origin, &direction, 100.0).expect("a wall");
    assert!((hit.point - Point3::new(1.9, 0.25, 0.15)).norm() < 1e-12, "{hit:?}");
    assert_eq!(hit.cell, 1);
    assert!((hit.normal.into_inner() + Vector3::y()).norm() < 1e-12);
}

#[test]
fn a_ray_stops_at_a_solid_and_at_nothing_behind_it() {
    let mut network = Network::from_run(&[straight(1.0), straight(2.0)], End::Cap, End::Cap).expect("possible");
    let place = Transform::translation(1.0, 0.0, 0.0);
    network.add_solid(&Solid::cuboid(&place, Vector3::new(0.1, 0.1, 0.1), SurfaceId(3)));
    assert!(network.cells.iter().all(|cell| cell.solids.len() == 1), "it stands across the joint");
    let ahead = Vector3::x_axis();
    let hit = network.cast(0, &Point3::new(0.2, 0.0, 0.05), &ahead, 100.0).expect("the box");
    assert!((hit.distance_m - 0.75).abs() < 1e-12 && hit.surface == SurfaceId(3));
    let over = network.cast(0, &Point3::new(0.2, 0.0, 0.11), &ahead, 100.0).expect("the cap");
    assert!((over.distance_m - 2.8).abs() < 1e-12);
}

#[test]
fn elbows_turn_the_way_their_sign_says_and_keep_their_length() {
    for (fitting, radius_m) in [(radius(90.0), 0.625), (radius(-90.0), 0.625), (mitre(90.0), 0.25), (mitre(-90.0), 0.25)] {
        let left = fitting.curvature_1_m().signum();
        let exit = fitting.entry_from_exit();
        assert!((fitting.length_m() - radius_m * std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((exit.translation.vector - Vector3::new(radius_m, left * radius_m, 0.0)).norm() < 1e-12);
        assert!((exit.rotation * Vector3::x() - Vector3::new(0.0, left, 0.0)).norm() < 1e-12);
    }
}

#[test]
fn a_run_that_bites_its_own_tail_is_refused_with_both_ends() {
    let square = [straight(1.0), mitre(90.0), straight(0.5), mitre(90.0), straight(0.5), mitre(90.0), straight(2.0)];
    let refused = Network::from_run(&square, End::Open, End::Open);
    assert!(matches!(refused, Err(NetworkError::Overlap { first: 0, second: 5 | 6, .. })), "{refused:?}");
}

#[test]
fn a_point_is_found_from_whichever_cell_the_search_begins() {
    let network = zigzag();
    let middle = |id: usize| {
        let corners: Vec<_> = network.cells[id].faces.iter().flat_map(|face| &face.outline).collect();
        Point3::from(corners.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / corners.len() as f64)
    };
    for near in 0..network.cells.len() {
        for id in 0..network.cells.len() {
            assert_eq!(network.cell_at(&middle(id), near), Some(id), "from {near}");
        }
        assert_eq!(network.cell_at(&Point3::new(0.5, 0.0, -0.01), near), None);
    }
}

#[test]
fn the_overlap_that_is_reported_is_the_first_one() {
    // Three times round a square: each fitting lies where the eighth before it does.
    let side = [straight(2.0), mitre(90.0)];
    let run: Vec<Fitting> = side.into_iter().cycle().take(24).collect();
    let refused = Network::from_run(&run, End::Open, End::Open);
    assert!(matches!(refused, Err(NetworkError::Overlap { first: 0, second: 8, .. })), "{refused:?}");
}

proptest! {
    /// Any point beside the centreline is in the network, and projects back to where it was put.
    #[test]
    fn the_centreline_runs_through_the_middle(share in 0.0..1.0, beside in -0.24..0.24_f64, height in 0.01..0.29_f64) {
        let network = zigzag();
        let distance = share * network.centreline.length_m();
        let segment = network.centreline.segment_at(distance).clone();
        // Between two seams a gore's outer wall stands 2 mm inside the true cylinder, and about the inner corner of a mitre the
        // projection is not unique.
        let limit = if segment.curvature_1_m == 0.0 { 0.24 } else { 0.2 };
        prop_assume!(beside.abs() < limit);
        let point = network.centreline.pose_at(distance) * Point3::new(0.0, beside, height);
        prop_assert!(network.cell_at(&point, 0).is_some());
        let near = network.centreline.segments.iter().position(|s| *s == segment).expect("one of them");
        let back = network.centreline.project(&point, near);
        prop_assert!((back.distance_m - distance).abs() < 1e-9, "{} {}", back.distance_m, distance);
        prop_assert!((back.lateral_m - beside).abs() < 1e-9);
    }
}

/// Rays square to floor, walls and ceiling meet the bead by its height sooner, on half its width to each side of a joint, and nowhere else.
#[test]
fn beads_stand_round_every_joint() {
    const HIGH: f64 = 0.003;
    const WIDE: f64 = 0.02;
    let run = [straight(1.0), radius(90.0), straight(0.8), straight(0.7)];
    let plain = Network::from_run(&run, End::Cap, End::Open).expect("a possible run");
    let mut beaded = plain.clone();
    beaded.add_beads(HIGH, WIDE, SurfaceId(3));
    let mut joint_m = 0.0;
    for (fitting, next) in run.iter().zip(&run[1..]) {
        joint_m += fitting.length_m();
        for off in [-0.012_f64, -0.0095, -0.004, 0.004, 0.0095, 0.012] {
            // In an elbow the inner wall is shorter: there, only what is well within the bead can be told from the path's length.
            let bends = fitting.curvature_1_m() != 0.0 || next.curvature_1_m() != 0.0;
            if bends && off.abs() > 0.005 {
                continue;
            }
            let pose = plain.centreline.pose_at(joint_m + off);
            let origin = pose * Point3::new(0.0, 0.0, HEIGHT / 2.0);
            let cell = plain.cell_at(&origin, 0).expect("on the centreline");
            for way in [Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()] {
                let way = Unit::new_normalize(pose.rotation * way);
                let wall = plain.cast(cell, &origin, &way, 10.0).expect("a wall");
                let met = beaded.cast(cell, &origin, &way, 10.0).expect("a wall or a bead");
                let high = wall.distance_m - met.distance_m;
                if off.abs() < WIDE / 2.0 {
                    assert_eq!(met.surface, SurfaceId(3));
                    // A gore's wall stands askew by 3.75 degrees: 0.3 mm within 5 mm.
                    assert!((high - HIGH).abs() < if bends { 4e-4 } else { 1e-12 }, "{joint_m} {off}: {high}");
                } else {
                    assert!(high.abs() < 1e-12 && met.surface == wall.surface, "{joint_m} {off}: {high}");
                }
            }
        }
    }
    let beads = beaded.cells.iter().map(|cell| cell.solids.len()).sum::<usize>();
    // Four bars a joint, each in the cell before and in the cell behind.
    assert_eq!(beads, 3 * 4 * 2);
}
