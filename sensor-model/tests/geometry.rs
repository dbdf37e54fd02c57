//! What is in view and what is in shadow: solids, seams, bends, and places far from the world's origin.
#![cfg(feature = "wgpu")]

mod common;

use common::{LOOKS, base_at, duct, elbow, image, quiet, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::fitting::{Fitting, Shape};
use ductloop_duct::network::Network;
use ductloop_nav::rig::Rig;
use ductloop_sensor::optics::Optics;
use ductloop_sensor::renderer::View;
use ductloop_sensor::{Transform, WgpuRenderer};
use nalgebra::{Point3, Translation3, Unit, Vector3};

fn rendered(network: &Network, rig: &Rig, optics: &Optics, view: &View) -> Option<Vec<u8>> {
    let gpu = common::gpu()?;
    let mut renderer = WgpuRenderer::new(gpu, network, rig, optics, &LOOKS, 3).expect("the rig and the optics are sound");
    Some(image(&mut renderer, rig, view))
}

fn largest_difference(a: &[u8], b: &[u8]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().expect("pixels")
}

#[test]
fn a_box_throws_its_shadow_where_the_source_does_not_see_past_it() {
    // A post from floor to ceiling beside the lens' line to the left wall. Seen from above, the source of `low` is at the
    // camera's place, so a source moved 10 cm to the right shows light and shadow apart.
    let mut rig = wide();
    rig.lasers.truncate(1);
    let laser = &mut rig.lasers[0];
    let along_plane = Vector3::x() - laser.normal_in_camera.into_inner() * laser.normal_in_camera.x;
    laser.source_in_camera += along_plane.normalize() * 0.10;
    let source = laser.source_in_camera;
    let normal = laser.normal_in_camera;
    let mut network = duct(&[straight(6.0, 0.5, 0.3)]);
    let size = Vector3::new(0.04, 0.04, 0.29);
    let (post_x, post_y) = (1.96, 0.13);
    network.add_solid(&Solid::cuboid(&Transform::translation(post_x, post_y, 0.0), size, SurfaceId(1)));
    let mut view = view(&rig, &base_at(1.5, 0.0, 0.0));
    view.headlamp_power = 0.0;
    view.exposure_s *= 4.0;
    let Some(pixels) = rendered(&network, &rig, &quiet(), &view) else { return };
    let Some(empty) = rendered(&duct(&[straight(6.0, 0.5, 0.3)]), &rig, &quiet(), &view) else { return };

    // For each column in which the stripe lies on the left wall y = 0.25: the point, and whether the segment from the source
    // passes the post, in plan (the post is as high as matters).
    let (mut lit, mut dark) = (0, 0);
    for column in 0..320_usize {
        let slope = (column as f64 - 319.5) / 378.4;
        // Camera at (1.62, 0, 0.1) looking along x: world = (1.62 + z, -x, 0.1 - y). The wall is x = -0.25.
        let (x, z) = (-0.25, -0.25 / slope);
        let y = (normal.dot(&source.coords) - normal.x * x - normal.z * z) / normal.y;
        let row = 239.5 + 378.4 * y / z;
        let point = [1.62 + z, 0.25];
        let from = [1.62 + source.z, -source.x];
        let passes = |a: [f64; 2], b: [f64; 2], grow_m: f64| {
            let half = 0.02 + grow_m;
            // Slabs of the post along x and y.
            let slab = |axis: usize, middle: f64| {
                let step = b[axis] - a[axis];
                let (t1, t2) = ((middle - half - a[axis]) / step, (middle + half - a[axis]) / step);
                (t1.min(t2), t1.max(t2))
            };
            let ((x1, x2), (y1, y2)) = (slab(0, post_x), slab(1, post_y));
            x1.max(y1).max(0.0) < x2.min(y2).min(1.0)
        };
        let row = row.round() as usize;
        // Faint, or not on this wall.
        if empty[row * 640 + column] < 40 {
            continue;
        }
        let camera = [1.62, 0.0];
        let value = pixels[row * 640 + column];
        // A millimetre to either side of an edge is left to the point spread.
        if !passes(from, point, 2e-3) && !passes(camera, point, 2e-3) {
            assert!(value.abs_diff(empty[row * 640 + column]) <= 1, "column {column} should be lit as without the post");
            lit += 1;
        } else if passes(from, point, -2e-3) && !passes(camera, point, 4e-3) {
            assert!(value <= 10, "column {column} should be in shadow, is {value}");
            dark += 1;
        }
    }
    assert!(lit > 50 && dark > 20, "{lit} lit and {dark} dark columns were looked at");
}

#[test]
fn a_straight_cut_in_three_looks_like_one() {
    let rig = wide();
    let whole = duct(&[straight(6.0, 0.5, 0.3)]);
    let cut = duct(&[straight(1.9, 0.5, 0.3), straight(0.7, 0.5, 0.3), straight(3.4, 0.5, 0.3)]);
    for (x, y, heading_deg) in [(1.5, 0.0, 0.0), (1.5, 0.06, 6.0), (1.7, -0.08, -20.0), (1.78, 0.0, 0.0)] {
        let view = view(&rig, &base_at(x, y, heading_deg));
        let Some(a) = rendered(&whole, &rig, &quiet(), &view) else { return };
        let Some(b) = rendered(&cut, &rig, &quiet(), &view) else { return };
        assert!(largest_difference(&a, &b) <= 1, "at ({x}, {y}, {heading_deg})");
    }
}

#[test]
fn far_from_the_origin_nothing_changes() {
    let rig = wide();
    let near = duct(&[straight(1.0, 0.5, 0.3), straight(6.0, 0.5, 0.3)]);
    let far = duct(&[straight(88.5, 0.5, 0.3), straight(6.0, 0.5, 0.3)]);
    let optics = Optics::default();
    let Some(a) = rendered(&near, &rig, &optics, &view(&rig, &base_at(2.5, 0.03, 3.0))) else { return };
    let Some(b) = rendered(&far, &rig, &optics, &view(&rig, &base_at(90.0, 0.03, 3.0))) else { return };
    // Geometry is the same to 1e-14 m; a value on the edge between two grey values may fall either way.
    assert!(largest_difference(&a, &b) <= 1);
    assert!(a.iter().zip(&b).filter(|(a, b)| a != b).count() < 30);
}

#[test]
fn no_pixel_of_a_closed_duct_is_dark() {
    let mut rig = wide();
    rig.lasers.truncate(1);
    // Bright enough that the farthest wall, 4 m away and met at a slant, is well above black.
    let optics = Optics { headlamp_peak_dn: 60_000.0, ..quiet() };
    let mitre = Fitting { shape: Shape::MitredElbow { angle_rad: -1.0 }, width_m: 0.5, height_m: 0.3, surface: SurfaceId(0) };
    let network =
        duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(0.6, 0.5, 0.3), mitre, straight(2.0, 0.5, 0.3)]);
    for step in 0..20 {
        let pose = network.centreline.pose_at(1.0 + 0.131 * f64::from(step));
        let turn = base_at(0.0, 0.004 * f64::from(step) - 0.04, 7.3 * f64::from(step % 7) - 20.0);
        let Some(pixels) = rendered(&network, &rig, &optics, &view(&rig, &(pose * turn))) else { return };
        let darkest = pixels.iter().min().unwrap();
        assert!(*darkest > 8 + 10, "step {step}: a pixel of {darkest} DN");
    }
}

#[test]
fn a_stripe_runs_on_through_the_gores_of_an_elbow() {
    // Along the outer wall of the bend the stripe crosses a seam every 7.5 degrees: where it is bright, no column may lack it.
    let rig = wide();
    let network = duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    let mut view = view(&rig, &base_at(2.3, 0.0, 0.0));
    view.headlamp_power = 0.0;
    view.laser_power = [0.0, 1.0, 0.0, 0.0];
    view.exposure_s *= 4.0;
    let Some(pixels) = rendered(&network, &rig, &quiet(), &view) else { return };
    let light: Vec<f64> = (0..640).map(|u| (0..480).map(|v| f64::from(pixels[v * 640 + u]) - 8.0).sum::<f64>()).collect();
    for u in 321..639 {
        // Gores meet at 7.5 degrees, so the light a column gets steps at a seam, by cos(i) and by the stripe's slant: at most
        // 20 % here; a seam without light would take half of it or more.
        let neighbours = (light[u - 1] + light[u + 1]) / 2.0;
        assert!(light[u] > 0.8 * neighbours && neighbours > 100.0, "column {u}: {} against {neighbours}", light[u]);
    }
}

#[test]
fn a_source_outside_the_duct_lights_nothing() {
    let mut rig = wide();
    rig.lasers.truncate(1);
    let laser = &mut rig.lasers[0];
    laser.normal_in_camera = Unit::new_normalize(Vector3::y());
    laser.source_in_camera = Point3::new(-0.3, 0.05, 0.0);
    laser.offset_m = 0.05;
    let mut view = view(&rig, &base_at(1.5, 0.0, 0.0));
    view.headlamp_power = 0.0;
    let Some(pixels) = rendered(&duct(&[straight(6.0, 0.5, 0.3)]), &rig, &quiet(), &view) else { return };
    assert!(pixels.iter().all(|dn| *dn == 8));
}

#[test]
fn the_same_seed_and_frame_give_the_same_bytes_and_others_do_not() {
    let Some(gpu) = common::gpu() else { return };
    let rig = wide();
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    let at = |seed: u64, frame: u64| {
        let mut renderer = WgpuRenderer::new(gpu, &network, &rig, &Optics::default(), &LOOKS, seed).unwrap();
        let view = View { frame, ..view(&rig, &base_at(1.5, 0.0, 0.0)) };
        image(&mut renderer, &rig, &view)
    };
    let first = at(1, 7);
    assert_eq!(first, at(1, 7));
    let changed = |other: &[u8]| first.iter().zip(other).filter(|(a, b)| a != b).count();
    // Read noise alone is 0.12 DN: most of a dark image keeps its grey values, some 15 000 pixels do not.
    assert!(changed(&at(1, 8)) > 3_000);
    assert!(changed(&at(2, 7)) > 3_000);
}

#[test]
fn many_bodies_outgrow_the_first_buffers() {
    // 64 KiB hold 4096 planes: 700 boxes of six do not fit, and must still all be there. The last one is seen to cast.
    let rig = wide();
    let mut network = duct(&[straight(6.0, 0.5, 0.3)]);
    for i in 0..700 {
        let at = Translation3::new(3.0 + 0.004 * f64::from(i), if i % 2 == 0 { 0.2 } else { -0.2 }, 0.0);
        network.add_solid(&Solid::cuboid(&Transform::from(at), Vector3::new(0.002, 0.002, 0.2), SurfaceId(1)));
    }
    let view = view(&rig, &base_at(1.5, 0.0, 0.0));
    let Some(without) = rendered(&duct(&[straight(6.0, 0.5, 0.3)]), &rig, &quiet(), &view) else { return };
    let Some(with) = rendered(&network, &rig, &quiet(), &view) else { return };
    assert!(largest_difference(&with, &without) > 5);
}
