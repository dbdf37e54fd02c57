//! What a surface's albedo does to the lasers' light and to the headlamp's.
#![cfg(feature = "wgpu")]

mod common;

use common::{base_at, duct, image, quiet, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::fitting::Fitting;
use ductloop_duct::network::Network;
use ductloop_sensor::optics::{Lens, Optics};
use ductloop_sensor::surface::Look;
use ductloop_sensor::{Transform, WgpuRenderer};
use nalgebra::Vector3;

/// One image by the lasers alone and one by the headlamp alone, without point spread, in a network of these albedos.
fn by_laser_and_by_lamp(network: &Network, albedos: &[f64]) -> Option<[Vec<u8>; 2]> {
    let gpu = common::gpu()?;
    let rig = wide();
    let looks: Vec<_> = albedos.iter().map(|albedo| Look::matt(*albedo)).collect();
    // Bright enough that what the lens leaves at the image's sides, a third, is well above black.
    let optics =
        Optics { lens: Lens { psf_sigma_px: 0.0, ..Lens::default() }, stripe_peak_dn: 540.0, headlamp_peak_dn: 300.0, ..quiet() };
    let mut renderer = WgpuRenderer::new(gpu, network, &rig, &optics, &looks, 1).expect("the rig and the optics are sound");
    Some([[1.0, 0.0], [0.0, 1.0]].map(|[lasers, lamp]| {
        let mut view = view(&rig, &base_at(1.5, 0.0, 0.0));
        view.laser_power = [lasers; 4];
        view.headlamp_power = lamp;
        image(&mut renderer, &rig, &view)
    }))
}

#[test]
fn twice_the_albedo_is_twice_the_light() {
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    let Some(single) = by_laser_and_by_lamp(&network, &[0.2]) else { return };
    let Some(double) = by_laser_and_by_lamp(&network, &[0.4]) else { return };
    for (light, single, double) in [("lasers", &single[0], &double[0]), ("headlamp", &single[1], &double[1])] {
        let mut compared = 0;
        for (a, b) in single.iter().zip(double).filter(|(_, b)| **b < 255) {
            // Each is rounded by half a grey value, the single one counting twice.
            let difference = (i32::from(*b) - 8) - 2 * (i32::from(*a) - 8);
            assert!(difference.abs() <= 1, "{light}: {a} and {b}");
            compared += u32::from(*b > 40);
        }
        assert!(compared > 1000, "{light}: only {compared} pixels were bright enough to tell");
    }
}

#[test]
fn two_surfaces_in_one_duct_differ_as_their_albedos() {
    // The duct's second straight, from 0.38 m ahead of the camera on, has a surface of its own.
    const SEAM_M: f64 = 0.38;
    let rest = Fitting { surface: SurfaceId(1), ..straight(4.0, 0.5, 0.3) };
    let network = duct(&[straight(1.5 + 0.12 + SEAM_M, 0.5, 0.3), rest]);
    let Some(alike) = by_laser_and_by_lamp(&network, &[0.5, 0.5]) else { return };
    let Some(unlike) = by_laser_and_by_lamp(&network, &[0.5, 0.3]) else { return };
    for (light, alike, unlike) in [("lasers", &alike[0], &unlike[0]), ("headlamp", &alike[1], &unlike[1])] {
        let mut compared = [0, 0];
        for pixel in 0..640 * 480 {
            let (a, b) = (f64::from(alike[pixel]), f64::from(unlike[pixel]));
            // Where this pixel's ray leaves the duct: walls 0.25 m to either side, floor 0.1 m below, ceiling 0.2 m above.
            let x = ((pixel % 640) as f64 - 319.5) / 378.4;
            let y = ((pixel / 640) as f64 - 239.5) / 378.4;
            let ahead_m = (0.25 / x.abs()).min(if y > 0.0 { 0.1 / y } else { -0.2 / y });
            // A millimetre about the seam is left out: there, rounding decides.
            if a == 255.0 || (ahead_m - SEAM_M).abs() < 1e-3 {
                continue;
            }
            let beyond = ahead_m > SEAM_M;
            let expected = if beyond { 0.6 * (a - 8.0) } else { a - 8.0 };
            // Both are rounded by half a grey value, `a` counting 0.6; the rest is half floats.
            assert!((b - 8.0 - expected).abs() < 0.9, "{light}, pixel {pixel}: {b} where equal albedos give {a}");
            compared[usize::from(beyond)] += u32::from(a > 30.0);
        }
        assert!(compared.iter().all(|n| *n > 500), "{light}: only {compared:?} pixels were bright enough to tell");
    }
}

#[test]
fn a_box_has_the_albedo_of_its_own_surface() {
    // A post whose front is 0.28 m ahead of the camera and 54 px wide there, from below the image's middle to above it.
    let mut network = duct(&[straight(6.0, 0.5, 0.3)]);
    let post = Solid::cuboid(&Transform::translation(1.92, 0.0, 0.0), Vector3::new(0.04, 0.04, 0.29), SurfaceId(1));
    network.add_solid(&post);
    let Some(alike) = by_laser_and_by_lamp(&network, &[0.5, 0.5]) else { return };
    let Some(unlike) = by_laser_and_by_lamp(&network, &[0.5, 0.3]) else { return };
    for (light, alike, unlike) in [("lasers", &alike[0], &unlike[0]), ("headlamp", &alike[1], &unlike[1])] {
        let mut compared = 0;
        for pixel in (100..350).flat_map(|row| (300..340).map(move |column| row * 640 + column)) {
            let (a, b) = (f64::from(alike[pixel]), f64::from(unlike[pixel]));
            // Rounding as above.
            assert!(a == 255.0 || (b - 8.0 - 0.6 * (a - 8.0)).abs() < 0.9, "{light}, pixel {pixel}: {b} and {a}");
            compared += u32::from(a > 30.0 && a < 255.0);
        }
        assert!(compared > 100, "{light}: only {compared} pixels were bright enough to tell");
    }
}
