//! Into how many parts an exposure is divided, and that they are the whole of it.

mod common;

use common::{LOOKS, base_at, duct, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::network::Network;
use ductloop_sensor::Transform;
use ductloop_sensor::exposure_parts::{PARTS_MAX, parts, whole};
use ductloop_sensor::frame_geometry::{FrameGeometry, Sweep};
use ductloop_sensor::optics::{Lens, Optics};
use ductloop_sensor::renderer::{Motion, View};
use ductloop_sensor::scenery::Scenery;
use ductloop_sensor::surface::Look;
use nalgebra::Vector3;

fn divided_with(network: &Network, looks: &[Look], motion: Motion, exposure_s: f64) -> Vec<Sweep> {
    let (rig, optics) = (wide(), Optics::default());
    let scenery = Scenery::new(network, looks).expect("sound looks");
    let mut geometry = FrameGeometry::new(&rig, &optics).expect("a pinhole");
    let view = View { motion, exposure_s, ..view(&rig, &base_at(1.5, 0.0, 0.0)) };
    geometry.build(&scenery, &whole(&view, &optics.lens), &view.laser_power).expect("the camera is in the duct");
    parts(&view, &optics.lens, &geometry).collect()
}

fn divided(network: &Network, motion: Motion, exposure_s: f64) -> Vec<Sweep> {
    divided_with(network, &LOOKS, motion, exposure_s)
}

fn driving(speed_m_s: f64) -> Motion {
    Motion { linear_m_s: Vector3::x() * speed_m_s, angular_rad_s: Vector3::zeros() }
}

fn turning(rate_rad_s: f64) -> Motion {
    Motion { linear_m_s: Vector3::zeros(), angular_rad_s: Vector3::z() * rate_rad_s }
}

#[test]
fn a_camera_at_rest_or_a_lens_without_motion_blur_sees_one_picture() {
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    let still = divided(&network, Motion::default(), 4e-3);
    assert_eq!(still.len(), 1);
    assert_eq!(still[0], Sweep::still(still[0].world_from_camera));
    let rig = wide();
    let view = View { motion: turning(10.0), ..view(&rig, &base_at(1.5, 0.0, 0.0)) };
    let lens = Lens { motion_blur: false, ..Lens::default() };
    assert_eq!(whole(&view, &lens), Sweep::still(view.world_from_camera));
}

#[test]
fn what_moves_along_itself_does_not_divide_the_exposure() {
    // At 1 m/s and 4 ms the floor at the image's lower edge, 0.16 m ahead, moves by 378.4 * 0.63 * 0.004 / 0.16 = 6 px.
    let one = duct(&[straight(6.0, 0.5, 0.3)]);
    assert_eq!(divided(&one, driving(1.0), 4e-3).len(), 1);
    let cut = duct(&[straight(1.9, 0.5, 0.3), straight(0.7, 0.5, 0.3), straight(3.4, 0.5, 0.3)]);
    assert_eq!(divided(&cut, driving(1.0), 4e-3).len(), 1);
    // Nor do seams and spangles: their motion is in their closed forms.
    let patterned = [Look { spangle: 0.1, seam_m: 2e-3, ..Look::matt(0.5) }; 2];
    assert_eq!(divided_with(&cut, &patterned, driving(1.0), 4e-3).len(), 1);
}

#[test]
fn turning_takes_a_part_for_each_pixel() {
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    // Turning by an angle a moves what is ahead by f a, and by f a (1 + x^2) at the image's side, x = 0.85 (0.87 with the margin).
    for (rate_rad_s, exposure_s) in [(1.0, 4e-3), (1.0, 20e-3), (3.0, 4e-3)] {
        let middle_px = 378.4 * rate_rad_s * exposure_s;
        let count = divided(&network, turning(rate_rad_s), exposure_s).len() as f64;
        assert!(count >= middle_px * 0.6 && count <= middle_px * 1.8 + 1.0, "{rate_rad_s} rad/s, {exposure_s} s: {count}");
    }
    assert_eq!(divided(&network, turning(20.0), 0.04).len(), PARTS_MAX);
    assert_eq!(divided(&network, turning(400.0), 0.04).len(), PARTS_MAX);
}

#[test]
fn a_post_that_is_passed_divides_it() {
    // A post whose edges are 10 cm beside the line of sight and 0.34 m ahead: at 1 m/s and 10 ms they move by
    // 378.4 * 0.10 * 0.01 / 0.34^2 = 3.3 px.
    let mut network = duct(&[straight(6.0, 0.5, 0.3)]);
    let stand = Transform::translation(1.98, 0.12, 0.0);
    network.add_solid(&Solid::cuboid(&stand, Vector3::new(0.04, 0.04, 0.29), SurfaceId(1)));
    let count = divided(&network, driving(1.0), 10e-3).len();
    assert!((4..=7).contains(&count), "{count}");
}

#[test]
fn the_parts_follow_each_other_and_are_the_whole() {
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    let motion = Motion { linear_m_s: Vector3::new(0.5, 0.1, 0.0), angular_rad_s: Vector3::new(0.0, 0.2, 2.0) };
    let parts = divided(&network, motion, 8e-3);
    assert!(parts.len() > 3);
    for pair in parts.windows(2) {
        assert_eq!(pair[0].world_from_last, pair[1].world_from_first);
    }
    let rig = wide();
    let view = View { motion, exposure_s: 8e-3, ..view(&rig, &base_at(1.5, 0.0, 0.0)) };
    let all = whole(&view, &Lens::default());
    assert_eq!(parts[0].world_from_first, all.world_from_first);
    assert_eq!(parts[parts.len() - 1].world_from_last, all.world_from_last);
    // Speed and turning rate, from the poses' difference.
    let moved = all.world_from_last.translation.vector - all.world_from_first.translation.vector;
    assert!((moved / 8e-3 - motion.linear_m_s).norm() < 1e-9);
    let turned = (all.world_from_last.rotation * all.world_from_first.rotation.inverse()).scaled_axis();
    assert!((turned / 8e-3 - motion.angular_rad_s).norm() < 1e-9);
}
