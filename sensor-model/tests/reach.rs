//! The limits of the light that is followed: how far it goes, and how bright it may be.
#![cfg(feature = "wgpu")]

mod common;

use common::{LINE, LOOKS, base_at, duct, facing_wall, image, quiet, square_on, straight, view};
use ductloop_sensor::WgpuRenderer;
use ductloop_sensor::light::FWHM_PER_SIGMA;
use ductloop_sensor::optics::{Lens, Optics};
use ductloop_sensor::renderer::View;

/// The four images' pixels about the principal point at which an end cap is compared: it spans 7.7 x 4.6 px at 24.5 m.
fn middle_pixels() -> impl Iterator<Item = (usize, usize)> {
    (238..=240).flat_map(|row| (317..=322).map(move |column| (column, row)))
}

/// The images by the slit alone and by the headlamp alone of a cap half a metre behind an opening `opening_m` ahead, exposed so
/// that by the law of the fall-off the light met squarely would be 150 DN there.
fn cap_behind_an_opening(opening_m: f64) -> Option<[Vec<u8>; 2]> {
    let gpu = common::gpu()?;
    let rig = square_on();
    let network = duct(&[straight(1.0 + 0.12 + opening_m, 0.5, 0.3), straight(0.5, 0.5, 0.3)]);
    // No point spread: it would bring in the light of the nearer walls, hundreds of times brighter.
    let optics =
        Optics { lens: Lens { psf_sigma_px: 0.0, ..Lens::default() }, stripe_peak_dn: 150.0, headlamp_peak_dn: 150.0, ..quiet() };
    let mut renderer = WgpuRenderer::new(gpu, &network, &rig, &optics, &LOOKS, 1).expect("the rig and the optics are sound");
    let dark = View { laser_power: [0.0; 4], headlamp_power: 0.0, ..view(&rig, &base_at(1.0, 0.0, 0.0)) };
    let r = opening_m + 0.5;
    let by_laser = View { laser_power: [r * LINE.at(r) / (0.3 * LINE.at(0.3)); 4], ..dark.clone() };
    let by_lamp = View { headlamp_power: r * r / (0.3 * 0.3), ..dark };
    Some([by_laser, by_lamp].map(|view| image(&mut renderer, &rig, &view)))
}

#[test]
fn a_wall_far_away_is_lit_by_the_law_of_the_fall_off() {
    // Beyond a few metres and just short of `RANGE_M`, which counts to the opening.
    for opening_m in [6.5, 14.0, 24.0] {
        let Some([by_laser, by_lamp]) = cap_behind_an_opening(opening_m) else { return };
        let ahead_m = opening_m + 0.5;
        for (column, row) in middle_pixels() {
            let at_px = |pixel: usize, centre: f64| (pixel as f64 - centre) / 378.4 * ahead_m;
            // The slit's plane is y = 0.02 in the camera's axes, its source 2 cm below the lens.
            let (x, y) = (at_px(column, 319.5), at_px(row, 239.5));
            let off = y - 0.02;

            let r = (ahead_m * ahead_m + x * x + off * off).sqrt();
            let angle = libm::atan2(x, ahead_m);
            // The Gaussian's mean over the pixel, whose rows are `ahead_m / 378.4` apart at the cap.
            let sigma_px = LINE.at(r) / FWHM_PER_SIGMA * 378.4 / ahead_m;
            let off_px = off * 378.4 / ahead_m;
            let below = |at: f64| libm::erf(at / (sigma_px * std::f64::consts::SQRT_2));
            let across = sigma_px * (std::f64::consts::PI / 2.0).sqrt() * (below(off_px + 0.5) - below(off_px - 0.5));
            let profile = libm::exp(libm::log(0.8) * (angle / 0.5) * (angle / 0.5)) * across;
            let expected = 8.0 + 150.0 * ahead_m * LINE.at(ahead_m) / (r * LINE.at(r)) * profile * ahead_m / r;
            let found = f64::from(by_laser[row * 640 + column]);
            // Half for rounding to grey values; half floats are 0.13 DN apart at 150 DN.
            assert!((found - expected).abs() < 0.7, "slit, {ahead_m} m, ({column}, {row}): {found} against {expected}");

            let stretch = 1.0 + (x * x + y * y) / (ahead_m * ahead_m);
            let expected = 8.0 + 150.0 / (stretch * stretch.sqrt());
            let found = f64::from(by_lamp[row * 640 + column]);
            assert!((found - expected).abs() < 0.7, "headlamp, {ahead_m} m, ({column}, {row}): {found} against {expected}");
        }
    }
}

#[test]
fn light_is_not_followed_beyond_its_range() {
    let Some(images) = cap_behind_an_opening(26.0) else { return };
    for pixels in &images {
        assert!(middle_pixels().all(|(column, row)| pixels[row * 640 + column] == 8));
    }
}

#[test]
fn the_skirts_of_a_stripe_far_beyond_saturation_are_those_of_its_full_light() {
    // Fifty times the peak of 180 DN: what the point spread puts beside the stripe comes from pixels of thousands of grey values.
    const PEAK_DN: f64 = 50.0 * 180.0;
    let Some(gpu) = common::gpu() else { return };
    let rig = square_on();
    let optics = Optics { lens: Lens { psf_sigma_px: 1.1, ..Lens::default() }, ..quiet() };
    let mut renderer = WgpuRenderer::new(gpu, &facing_wall(), &rig, &optics, &LOOKS, 1).unwrap();
    let mut view = view(&rig, &base_at(1.0, 0.0, 0.0));
    (view.headlamp_power, view.laser_power) = (0.0, [50.0; 4]);
    let pixels = image(&mut renderer, &rig, &view);

    // In the column met squarely: the Gaussian spread by the lens, integrated over each pixel, and cos^4.
    let middle = 239.5 + 378.4 * 0.02 / 0.3;
    let sigma_px = LINE.at(0.3) / FWHM_PER_SIGMA * 378.4 / 0.3;
    let spread_px = (sigma_px * sigma_px + 1.1 * 1.1).sqrt();
    let below = |at: f64| 0.5 * libm::erfc(-at / (spread_px * std::f64::consts::SQRT_2));
    let mut compared = 0;
    for row in 250..280_i32 {
        let off = f64::from(row) - middle;
        let light = PEAK_DN * sigma_px * (2.0 * std::f64::consts::PI).sqrt() * (below(off + 0.5) - below(off - 0.5));
        let y = (f64::from(row) - 239.5) / 378.4;
        let expected = 8.0 + light / ((1.0 + y * y) * (1.0 + y * y));
        if !(20.0..250.0).contains(&expected) {
            continue;
        }
        let found = f64::from(pixels[row as usize * 640 + 320]);
        // Half for rounding; the rest is half floats, good to 5e-4, and the distribution function, good to 1e-6 of 40 000 DN px.
        assert!((found - expected).abs() < 0.7, "row {row}: {found} against {expected}");
        compared += 1;
    }
    assert!(compared >= 3, "only {compared} rows were between black and white");
}
