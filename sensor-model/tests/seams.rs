//! Seams, spangles and open ends: where they are, against rays and against the duct's own measures.

mod common;

use common::{base_at, duct, elbow, quiet, straight, view, wide};
use ductloop_duct::network::Network;
use ductloop_nav::rig::Rig;
use ductloop_sensor::Transform;
use ductloop_sensor::frame_geometry::{FrameGeometry, Region, Sweep};
use ductloop_sensor::optics::Optics;
use ductloop_sensor::renderer::MAX_LASERS;
use ductloop_sensor::scenery::Scenery;
use ductloop_sensor::surface::Look;
use nalgebra::{Point3, Unit, Vector3};

const GAP_M: f64 = 0.0015;
const SPANGLE_M: f64 = 0.008;

fn look() -> Look {
    Look { spangle: 0.15, spangle_m: SPANGLE_M, seam_m: GAP_M, ..Look::matt(0.4) }
}

fn geometry(network: &Network, looks: &[Look], rig: &Rig, optics: &Optics, world_from_camera: &Transform) -> FrameGeometry {
    let scenery = Scenery::new(network, looks).expect("sound looks");
    let mut geometry = FrameGeometry::new(rig, optics).expect("a sound lens");
    geometry.build(&scenery, &Sweep::still(*world_from_camera), &[0.0; MAX_LASERS]).expect("the camera is in the duct");
    geometry
}

/// Rays to places of a region: its corners drawn toward its middle by so much.
fn rays(geometry: &FrameGeometry, region: &Region, inward: f64) -> Vec<Vector3<f64>> {
    let corners = &geometry.corners[region.outline.clone()];
    let middle = corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / corners.len() as f64;
    corners.iter().map(|corner| corner.coords.lerp(&middle, inward)).map(|point| point / point.z).collect()
}

/// Where a ray of the camera's frame meets the network, in the world.
fn met(network: &Network, world_from_camera: &Transform, ray: &Vector3<f64>) -> Point3<f64> {
    let origin = Point3::from(world_from_camera.translation.vector);
    let cell = network.cell_at(&origin, 0).expect("in the duct");
    let way = Unit::new_normalize(world_from_camera.rotation * ray);
    network.cast(cell, &origin, &way, 50.0).expect("a wall").point
}

#[test]
fn a_seam_runs_where_two_fittings_meet() {
    // Joints at x = 2 and at x = 3.5; the far fitting ends in a cap.
    let network = duct(&[straight(2.0, 0.5, 0.3), straight(1.5, 0.5, 0.3), straight(1.0, 0.5, 0.3)]);
    let rig = wide();
    let world_from_camera = view(&rig, &base_at(1.0, 0.05, 7.0)).world_from_camera;
    let geometry = geometry(&network, &[look()], &rig, &quiet(), &world_from_camera);
    let mut seen = 0;
    for region in &geometry.regions {
        let seams = &geometry.seams[region.seams.clone()];
        let normal = world_from_camera.rotation * region.plane.normal.into_inner();
        let joints: &[f64] = match region.cell {
            // The cap has no joint; walls, floor and ceiling have one at each end of their fitting, as far as they are seen.
            2 if normal.x > 0.5 => &[],
            0 => &[2.0],
            1 => &[2.0, 3.5],
            _ => &[3.5],
        };
        assert_eq!(seams.len(), joints.len(), "cell {}, normal {normal}", region.cell);
        for seam in seams {
            assert_eq!(seam.width_m, GAP_M);
            // d = (g . r) / (n . r) is the distance from the joint, whichever of the region's joints it is.
            let offs = rays(&geometry, region, 1e-6).into_iter().map(|ray| {
                let distance_m = seam.ridge.dot(&ray) / region.plane.normal.dot(&ray);
                let x = met(&network, &world_from_camera, &ray).x;
                joints.iter().map(|joint| ((x - joint).abs() - distance_m.abs()).abs()).collect::<Vec<_>>()
            });
            let offs: Vec<_> = offs.collect();
            let fits = |joint: usize| offs.iter().all(|off| off[joint] < 1e-9);
            assert_eq!((0..joints.len()).filter(|joint| fits(*joint)).count(), 1, "{offs:?}");
            seen += 1;
        }
    }
    assert!(seen >= 12, "four sheets each of three fittings: {seen}");
}

#[test]
fn there_are_no_seams_on_what_has_none_or_far_from_them() {
    let network = duct(&[straight(2.0, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    let rig = wide();
    let world_from_camera = view(&rig, &base_at(1.0, 0.0, 0.0)).world_from_camera;
    let plain = geometry(&network, &[Look::matt(0.4)], &rig, &quiet(), &world_from_camera);
    assert!(plain.seams.is_empty() && plain.regions.iter().all(|region| region.texture.is_none()));
    let beaded = {
        let mut network = network.clone();
        network.add_beads(0.003, 0.02, ductloop_duct::cell::SurfaceId(0));
        geometry(&network, &[look()], &rig, &quiet(), &world_from_camera)
    };
    assert!(beaded.regions.iter().any(|region| region.body.is_some()));
    assert!(beaded.regions.iter().all(|region| region.body.is_none() || region.seams.is_empty()), "a bead is one piece");
}

/// A spangle is the same piece of sheet wherever it is seen from, and as large as it is said to be.
#[test]
fn spangles_stay_on_the_sheet() {
    let network = duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(1.0, 0.5, 0.3)]);
    let rig = wide();
    let poses = [base_at(1.0, 0.05, 7.0), base_at(1.6, -0.08, -5.0)].map(|base| view(&rig, &base).world_from_camera);
    let [first, second] = poses.map(|pose| geometry(&network, &[look()], &rig, &quiet(), &pose));
    let coordinates = |region: &Region, pose: &Transform, point: &Point3<f64>| {
        let ray = pose.inverse_transform_point(point).coords;
        region.texture.expect("spangle").at(&ray, &region.plane)
    };
    let mut shared = 0;
    for region in &first.regions {
        // The same sheet, if the other camera sees it: its corners need not be in view for the coordinates to agree.
        let Some(other) = second.regions.iter().find(|other| other.sheet == region.sheet) else { continue };
        shared += 1;
        let corners = &first.corners[region.outline.clone()];
        let points: Vec<_> = corners.iter().map(|corner| poses[0] * corner).collect();
        let here: Vec<_> = points.iter().map(|point| coordinates(region, &poses[0], point)).collect();
        for (i, point) in points.iter().enumerate() {
            let there = coordinates(other, &poses[1], point);
            assert!((0..2).all(|axis| (here[i][axis] - there[axis]).abs() < 1e-6), "{:?} and {there:?}", here[i]);
            let next = (i + 1) % points.len();
            let [ds, dt] = [0, 1].map(|axis| here[next][axis] - here[i][axis]);
            let length_m = (points[next] - point).norm();
            assert!(((ds * ds + dt * dt).sqrt() * SPANGLE_M - length_m).abs() < 1e-9, "{length_m}");
            // Counted from the sheet's own corner: small numbers, which single precision holds.
            assert!(here[i].iter().all(|count| count.abs() * SPANGLE_M < 6.0));
        }
    }
    assert!(shared > 10, "{shared}");
}

/// Open ends are seen where a ray leaves the network, and only by daylight.
#[test]
fn an_open_end_is_seen_through_the_duct() {
    let network = {
        use ductloop_duct::network::End;
        Network::from_run(&[straight(2.0, 0.5, 0.3), straight(1.0, 0.5, 0.3)], End::Cap, End::Open).expect("a duct")
    };
    let rig = wide();
    let world_from_camera = view(&rig, &base_at(1.0, 0.05, 7.0)).world_from_camera;
    let dark = geometry(&network, &[look()], &rig, &quiet(), &world_from_camera);
    assert!(dark.grilles.is_empty());
    let day = geometry(&network, &[look()], &rig, &Optics { ambient_dn: 60.0, ..quiet() }, &world_from_camera);
    assert_eq!(day.grilles.len(), 1);
    let outline: Vec<_> = day.corners[day.grilles[0].clone()].iter().map(|corner| world_from_camera * corner).collect();
    // All of the end at x = 3 is in view.
    assert_eq!(outline.len(), 4);
    for corner in &outline {
        assert!((corner.x - 3.0).abs() < 1e-9 && (corner.y.abs() - 0.25).abs() < 1e-9);
        assert!(corner.z.abs() < 1e-9 || (corner.z - 0.3).abs() < 1e-9);
    }
    assert_eq!(day.regions.len(), dark.regions.len());
    assert!(day.regions.iter().all(|region| region.glow.is_some()), "daylight falls on everything");
}
