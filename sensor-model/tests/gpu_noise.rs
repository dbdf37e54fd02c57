//! Both renderers draw the same random numbers: their images agree pixel by pixel, noise and all, whatever the CCD does.
#![cfg(feature = "wgpu")]

mod common;

use common::{base_at, duct, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_sensor::optics::{Bits, Ccd, Lens, Optics};
use ductloop_sensor::renderer::{ImageMut, Motion, Renderer, View};
use ductloop_sensor::surface::Look;
use ductloop_sensor::{CpuRenderer, Transform, WgpuRenderer};
use nalgebra::Vector3;

const LOOKS: [Look; 2] =
    [Look { specular: 0.2, roughness: 0.4, ..Look::matt(0.35) }, Look { spangle: 0.15, seam_m: 2e-3, ..Look::matt(0.5) }];

/// Shares of the pixels that are more than `1 + near` levels apart.
fn apart(optics: &Optics, motion: Motion, power: f64, near: u16) -> Option<f64> {
    let gpu = common::gpu()?;
    let rig = wide();
    let mut network = duct(&[straight(1.9, 0.5, 0.3), straight(4.0, 0.5, 0.3)]);
    let stand = Transform::translation(2.0, 0.13, 0.0);
    network.add_solid(&Solid::cuboid(&stand, Vector3::new(0.08, 0.06, 0.2), SurfaceId(1)));
    let mut engines: [Box<dyn Renderer>; 2] = [
        Box::new(WgpuRenderer::new(gpu, &network, &rig, optics, &LOOKS, 9).expect("a sound scene")),
        Box::new(CpuRenderer::new(&network, &rig, optics, &LOOKS, 9, 1).expect("a sound scene")),
    ];
    let view = View { motion, frame: 5, laser_power: [power; 4], ..view(&rig, &base_at(1.5, 0.03, 4.0)) };
    let pixels = rig.camera.width_px * rig.camera.height_px;
    let [a, b] = [0, 1].map(|engine| {
        if optics.ccd.bits == Bits::Eight {
            let mut image = vec![0_u8; pixels];
            engines[engine].render(&view, ImageMut::Grey8(&mut image)).expect("a view inside the duct");
            image.into_iter().map(u16::from).collect()
        } else {
            let mut image = vec![0_u16; pixels];
            engines[engine].render(&view, ImageMut::Grey16(&mut image)).expect("a view inside the duct");
            image
        }
    });
    let count = a.iter().zip(&b).filter(|(a, b)| a.abs_diff(**b) > 1 + near).count();
    Some(count as f64 / pixels as f64)
}

/// One pixel in a thousand may be at a region's edge, where the renderers need not agree which side it is on.
fn check(name: &str, optics: &Optics, motion: Motion, power: f64, near: u16) {
    let Some(share) = apart(optics, motion, power, near) else { return };
    println!("{name}: {:.4} % of the pixels differ", 100.0 * share);
    assert!(share < 1e-3, "{name}: {share} of the pixels differ");
}

fn with(ccd: Ccd) -> Optics {
    Optics { headlamp_peak_dn: 40.0, ccd, ..Optics::default() }
}

#[test]
fn with_every_number_of_bits() {
    check("8 bits", &with(Ccd::default()), Motion::default(), 1.0, 0);
    // Half floats are 1 and 2 levels apart at 128 DN of 8 bits.
    check("10 bits", &with(Ccd { bits: Bits::Ten, ..Ccd::default() }), Motion::default(), 1.0, 1);
    check("12 bits", &with(Ccd { bits: Bits::Twelve, ..Ccd::default() }), Motion::default(), 1.0, 4);
}

#[test]
fn in_the_dark_and_far_beyond_the_full_well() {
    let dark = Ccd {
        dsnu_e: 60.0,
        dark_current_e_s: 2e4,
        hot_pixels: 0.01,
        hot_pixel_e_s: 5e5,
        full_well_e: 8000.0,
        prnu: 0.03,
        ..Ccd::default()
    };
    check("dark", &with(dark), Motion::default(), 0.0, 0);
    // A level apart in the light is a level apart in what runs over.
    check("blooming", &with(Ccd { blooming: 0.6, ..Ccd::default() }), Motion::default(), 20.0, 1);
}

#[test]
fn with_speckle_of_any_grain() {
    for grain in [1.0, 1.7, 4.0] {
        let optics = Optics { speckle_contrast: 0.4, speckle_grain_px: grain, ..with(Ccd::default()) };
        check(&format!("grain {grain}"), &optics, Motion::default(), 1.0, 1);
    }
}

#[test]
fn out_of_focus_and_in_motion() {
    let lens = Lens { aperture_m: 2e-3, focus_m: 0.4, ..Lens::default() };
    check("defocus", &Optics { lens, ..with(Ccd::default()) }, Motion::default(), 1.0, 1);
    let turning = Motion { linear_m_s: Vector3::new(0.3, 0.0, 0.0), angular_rad_s: Vector3::new(0.0, 0.0, 1.5) };
    check("motion", &with(Ccd::default()), turning, 1.0, 1);
}
