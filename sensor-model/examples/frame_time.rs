//! Times frames of the `wide` rig in a straight duct: minimum, median and first frame, in milliseconds, for the default model and
//! with more and more of it switched on. An argument chooses the cases whose names contain it.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{LOOKS, base_at, duct, elbow, quiet, straight, view, wide};
use ductloop_nav::rig::Distortion;
use ductloop_sensor::WgpuRenderer;
use ductloop_sensor::optics::{Ccd, Lens, Optics};
use ductloop_sensor::renderer::{Motion, Renderer, View};
use ductloop_sensor::surface::Look;
use nalgebra::Vector3;

fn main() {
    let chosen = std::env::args().nth(1).unwrap_or_default();
    let gpu = common::gpu().expect("an adapter");
    let plain = duct(&[straight(6.0, 0.5, 0.3)]);
    let bend = duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    let galvanised = [Look { specular: 0.2, roughness: 0.45, ..Look::matt(0.35) }; 2];
    let spangled = [Look { spangle: 0.15, spangle_m: 8e-3, seam_m: 1.5e-3, ..galvanised[0] }; 2];
    let all_light = Optics { ghosts: true, bounce: true, ambient_dn: 20.0, ..Optics::default() };
    let all = Optics {
        speckle_grain_px: 1.5,
        lens: Lens { aperture_m: 2e-3, ..Lens::default() },
        ccd: Ccd { dsnu_e: 20.0, dark_current_e_s: 50.0, hot_pixels: 1e-4, hot_pixel_e_s: 1e4, blooming: 0.5, ..Ccd::default() },
        ..all_light.clone()
    };
    let bent = Distortion { k1: -0.2, k2: 0.04, p1: 0.001, p2: -0.0005, k3: -0.002 };
    let turning = Motion { linear_m_s: Vector3::x() * 0.3, angular_rad_s: Vector3::z() };
    let still = Motion::default();
    let none = Distortion::NONE;
    let default = Optics::default();
    let cases = [
        ("default", &plain, &default, LOOKS, none, still),
        ("without noise", &plain, &quiet(), LOOKS, none, still),
        ("galvanised", &plain, &default, galvanised, none, still),
        ("galvanised, elbow", &bend, &default, galvanised, none, still),
        ("ghosts, bounce, daylight", &plain, &all_light, galvanised, none, still),
        ("ghosts, bounce, daylight, elbow", &bend, &all_light, galvanised, none, still),
        ("and spangle, seams", &plain, &all_light, spangled, none, still),
        ("distortion", &plain, &default, galvanised, bent, still),
        ("turning at 1 rad/s", &plain, &default, galvanised, none, turning),
        ("all but motion", &plain, &all, spangled, bent, still),
        ("all", &plain, &all, spangled, bent, turning),
    ];
    for (name, network, optics, looks, distortion, motion) in cases {
        if !name.contains(&chosen) {
            continue;
        }
        let mut rig = wide();
        rig.camera.distortion = distortion;
        let mut view = View { motion, ..view(&rig, &base_at(1.5, 0.0, 0.0)) };
        let mut image = vec![0_u8; rig.camera.width_px * rig.camera.height_px];
        let opened = Instant::now();
        let mut renderer = WgpuRenderer::new(gpu, network, &rig, optics, &looks, 1).expect("rig and optics are sound");
        renderer.render(&view, image.as_mut_slice().into()).expect("the camera is in the duct");
        let first_ms = opened.elapsed().as_secs_f64() * 1e3;
        let mut times_ms: Vec<f64> = (0..300)
            .map(|frame| {
                view.frame = frame;
                let start = Instant::now();
                renderer.render(&view, image.as_mut_slice().into()).expect("the camera is in the duct");
                start.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times_ms.sort_by(f64::total_cmp);
        println!("{name}: first {first_ms:.0} ms, minimum {:.2}, median {:.2}", times_ms[0], times_ms[150]);
    }
}
