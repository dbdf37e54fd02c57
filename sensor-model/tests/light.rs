//! How bright things are: stripe and headlamp against their definitions, exposure, and the statistics of the CCD's noise
//! against EMVA 1288.
#![cfg(feature = "wgpu")]

mod common;

use common::{LINE, LOOKS, base_at, duct, facing_wall, image, quiet, square_on, straight, view, wide};
use ductloop_nav::rig::Rig;
use ductloop_sensor::WgpuRenderer;
use ductloop_sensor::noise::{self, Stream};
use ductloop_sensor::optics::{Ccd, Lens, Optics};
use ductloop_sensor::renderer::View;

/// cos^4 of the angle between a pixel's ray and the axis.
fn falloff(column: f64, row: f64) -> f64 {
    let (x, y) = ((column - 319.5) / 378.4, (row - 239.5) / 378.4);
    1.0 / ((1.0 + x * x + y * y) * (1.0 + x * x + y * y))
}

/// Mean over a pixel, `off` from the middle, of a Gaussian of height 1 and standard deviation `sigma`.
fn pixel_mean(off: f64, sigma: f64) -> f64 {
    let below = |x: f64| libm::erf(x / (sigma * std::f64::consts::SQRT_2));
    sigma * (std::f64::consts::PI / 2.0).sqrt() * (below(off + 0.5) - below(off - 0.5))
}

#[test]
fn a_stripe_met_squarely_at_the_reference_has_the_peak_it_is_defined_by() {
    let Some(gpu) = common::gpu() else { return };
    let rig = square_on();
    for sigma_px in [0.0, 0.6, 1.1] {
        let optics = Optics { lens: Lens { psf_sigma_px: sigma_px, ..Lens::default() }, ..quiet() };
        let mut renderer = WgpuRenderer::new(gpu, &facing_wall(), &rig, &optics, &LOOKS, 1).unwrap();
        let mut view = view(&rig, &base_at(1.0, 0.0, 0.0));
        view.headlamp_power = 0.0;
        let pixels = image(&mut renderer, &rig, &view);
        // The stripe is level: its middle is at row 239.5 + f 0.02 / 0.3 = 264.73, and a pixel of column 319.5 +- 0.5 is square on.
        let middle = 239.5 + 378.4 * 0.02 / 0.3;
        let sigma_line_px = LINE.at(0.3) / 2.354_820_045 * 378.4 / 0.3;
        // A Gaussian spread by the lens, then integrated over the pixel. Half a grey value for rounding, the rest for half floats.
        let spread_px = (sigma_line_px * sigma_line_px + sigma_px * sigma_px).sqrt();
        for row in 262..268_usize {
            let light = 180.0 * sigma_line_px / spread_px * pixel_mean(row as f64 - middle, spread_px);
            let expected = 8.0 + light * falloff(320.0, row as f64);
            let found = f64::from(pixels[row * 640 + 320]);
            assert!((found - expected).abs() < 0.7, "sigma {sigma_px}, row {row}: {found} against {expected}");
        }
    }
}

#[test]
fn the_fan_keeps_its_share_at_the_edge_and_ends_there() {
    let Some(gpu) = common::gpu() else { return };
    let rig = square_on();
    let mut renderer = WgpuRenderer::new(
        gpu,
        &facing_wall(),
        &rig,
        &Optics { lens: Lens { psf_sigma_px: 0.0, ..Lens::default() }, ..quiet() },
        &LOOKS,
        1,
    )
    .unwrap();
    let mut view = view(&rig, &base_at(1.0, 0.0, 0.0));
    view.headlamp_power = 0.0;
    let pixels = image(&mut renderer, &rig, &view);
    // Row 265 is 0.27 px off the stripe's middle. Along it, at the angle a from the fan's middle, r = 0.3 / cos(a), and the wall
    // is met at a: P / (r w(r)) exp(..) fan cos(a). The source is 2 cm beside the camera, in the same plane z = 0.
    let offset_m = (265.0 - 239.5) / 378.4 * 0.3 - 0.02;
    // The fan ends at 0.5 rad, column 319.5 + 378.4 tan(0.5) = 526.2; over half a degree from there, to column 530.5, it fades.
    let fade_rad = 0.5 * std::f64::consts::PI / 180.0;
    for column in [320_usize, 400, 480, 515, 526, 527, 528, 529, 530, 531, 532] {
        let across_m = (column as f64 - 319.5) / 378.4 * 0.3;
        let angle = libm::atan2(across_m, 0.3);
        let r = (0.3 * 0.3 + across_m * across_m + offset_m * offset_m).sqrt();
        let sigma = LINE.at(r) / 2.354_820_045;
        let across = pixel_mean(offset_m * 378.4 / 0.3, sigma * 378.4 / 0.3);
        let share = libm::exp(libm::log(0.8) * (angle / 0.5) * (angle / 0.5)) * across;
        let fade = (1.0 - (angle - 0.5) / fade_rad).clamp(0.0, 1.0);
        let light = 180.0 * 0.3 * LINE.at(0.3) / (r * LINE.at(r)) * share * fade * 0.3 / r;
        let expected = 8.0 + light * falloff(column as f64, 265.0);
        let found = f64::from(pixels[265 * 640 + column]);
        // Half for rounding, the rest for half floats.
        assert!((found - expected).abs() < 0.7, "column {column}: {found} against {expected}");
    }
}

#[test]
fn the_headlamp_falls_off_with_distance_and_incidence() {
    let Some(gpu) = common::gpu() else { return };
    let rig = square_on();
    let optics = Optics { headlamp_peak_dn: 150.0, ..quiet() };
    let mut renderer = WgpuRenderer::new(gpu, &facing_wall(), &rig, &optics, &LOOKS, 1).unwrap();
    let mut view = view(&rig, &base_at(1.0, 0.0, 0.0));
    view.laser_power = [0.0; 4];
    let pixels = image(&mut renderer, &rig, &view);
    for (column, row) in [(320_u32, 240_u32), (400, 240), (320, 330), (200, 150)] {
        let (x, y) = ((f64::from(column) - 319.5) / 378.4, (f64::from(row) - 239.5) / 378.4);
        let stretch = 1.0 + x * x + y * y;
        let expected = 8.0 + 150.0 / (stretch * stretch.sqrt()) * falloff(f64::from(column), f64::from(row));
        let found = f64::from(pixels[(row * 640 + column) as usize]);
        assert!((found - expected).abs() < 0.6, "({column}, {row}): {found} against {expected}");
    }
}

#[test]
fn twice_the_exposure_or_the_power_is_twice_the_light() {
    let Some(gpu) = common::gpu() else { return };
    let rig = wide();
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    let mut renderer = WgpuRenderer::new(gpu, &network, &rig, &quiet(), &LOOKS, 1).unwrap();
    let once = View { exposure_s: 12e-3, ..view(&rig, &base_at(1.5, 0.0, 0.0)) };
    let longer = View { exposure_s: 24e-3, ..once.clone() };
    let brighter = View { laser_power: [2.0; 4], headlamp_power: 2.0, ..once.clone() };
    let single = image(&mut renderer, &rig, &once);
    let double = image(&mut renderer, &rig, &longer);
    assert_eq!(double, image(&mut renderer, &rig, &brighter));
    let mut brightest = 0;
    for (a, b) in single.iter().zip(&double).filter(|(_, b)| **b < 255) {
        // Each is rounded by half a grey value, the single one counting twice.
        let difference = (i32::from(*b) - 8) - 2 * (i32::from(*a) - 8);
        assert!(difference.abs() <= 1, "{a} and {b}");
        brightest = brightest.max(*b);
    }
    assert!(brightest > 100, "only {brightest} DN was compared");
}

/// Camera against a cap lit by the headlamp: over 40 x 40 pixels in its middle the light varies by less than 1 %.
fn flat_region(optics: &Optics, frames: u64) -> Option<(Vec<Vec<u8>>, Rig)> {
    let gpu = common::gpu()?;
    let rig = square_on();
    let mut renderer = WgpuRenderer::new(gpu, &facing_wall(), &rig, optics, &LOOKS, 5).expect("the rig and the optics are sound");
    let mut view = view(&rig, &base_at(1.0, 0.0, 0.0));
    view.laser_power = [0.0; 4];
    let images = (0..frames)
        .map(|frame| {
            view.frame = frame;
            image(&mut renderer, &rig, &view)
        })
        .collect();
    Some((images, rig))
}

fn flat_pixels() -> impl Iterator<Item = usize> {
    (220..260).flat_map(|row| (300..340).map(move |column| row * 640 + column))
}

#[test]
fn mean_and_variance_follow_emva_1288() {
    const FRAMES: u64 = 60;
    for (peak_dn, ccd) in [
        (0.0, Ccd { read_noise_e: 200.0, ..Ccd::default() }),
        // Small wells, so that the noise is above 0.6 DN: below, rounding's variance is not 1/12.
        (20.0, Ccd { full_well_e: 6_000.0, ..Ccd::default() }),
        (120.0, Ccd { full_well_e: 3_000.0, ..Ccd::default() }),
        (120.0, Ccd { prnu: 0.05, ..Ccd::default() }),
    ] {
        let optics = Optics { headlamp_peak_dn: peak_dn, ccd: ccd.clone(), ..Optics::default() };
        let Some((images, _)) = flat_region(&optics, FRAMES) else { return };
        let still = |pixel: usize| {
            let (column, row) = ((pixel % 640) as f64, (pixel / 640) as f64);
            let (x, y) = ((column - 319.5) / 378.4, (row - 239.5) / 378.4);
            let stretch = 1.0 + x * x + y * y;
            8.0 + peak_dn / (stretch * stretch.sqrt()) * falloff(column, row)
        };
        let (n, frames) = (1600.0, FRAMES as f64);
        let gain = ccd.dn_per_electron();
        let (mut mean, mut mean_still, mut in_time) = (0.0, 0.0, 0.0);
        let mut means = Vec::new();
        for pixel in flat_pixels() {
            let values = images.iter().map(|image| f64::from(image[pixel]));
            let average = values.clone().sum::<f64>() / frames;
            in_time += values.map(|v| (v - average) * (v - average)).sum::<f64>() / (frames - 1.0);
            mean += average / n;
            mean_still += still(pixel) / n;
            means.push(average / still(pixel));
        }
        in_time /= n;
        let electrons = (mean_still - 8.0) / gain;
        let expected = gain * gain * (ccd.read_noise_e * ccd.read_noise_e + electrons) + 1.0 / 12.0;
        // Standard error of a variance from n frames (1600 * 59 values): 0.5 %; four of them, and 1 % for the light's own
        // variation over the region and single precision.
        assert!((in_time / expected - 1.0).abs() < 0.03, "{peak_dn} DN: variance {in_time} against {expected}");
        // The mean's error: the pixels' gains (prnu / 40) and noise (sqrt(v / 96000)), four times, and half floats.
        let bound = 4.0 * (ccd.prnu * peak_dn / 40.0 + (expected / (n * frames)).sqrt()) + 0.05;
        assert!((mean - mean_still).abs() < bound, "{peak_dn} DN: mean {mean} against {mean_still}");
        if ccd.prnu > 0.02 {
            // Fixed pattern: what stays from frame to frame, less the noise left in an average of 60 frames.
            let average = means.iter().sum::<f64>() / n;
            let fixed = means.iter().map(|m| (m - average) * (m - average)).sum::<f64>() / n;
            let left = in_time / frames / (mean * mean);
            let share = (mean - 8.0) / mean;
            let found = (fixed - left).sqrt() / share;
            // 1600 gains tell a standard deviation to 1.8 %; four of them.
            assert!((found / ccd.prnu - 1.0).abs() < 0.08, "fixed pattern {found} against {}", ccd.prnu);
        }
    }
}

#[test]
fn the_graphics_device_draws_the_numbers_of_the_noise_module() {
    let optics = Optics { headlamp_peak_dn: 100.0, ..Optics::default() };
    let Some((images, _)) = flat_region(&optics, 3) else { return };
    let gains: Vec<f64> = noise::gains(5, optics.ccd.prnu, 640, 480).collect();
    let per_electron = optics.ccd.dn_per_electron();
    for (frame, image) in images.iter().enumerate() {
        let key = noise::key(5, Stream::Shot, frame as u64);
        let mut apart = 0;
        for pixel in flat_pixels() {
            let (column, row) = (pixel % 640, pixel / 640);
            let (x, y) = ((column as f64 - 319.5) / 378.4, (row as f64 - 239.5) / 378.4);
            let stretch = 1.0 + x * x + y * y;
            let mean = 100.0 / (stretch * stretch.sqrt()) * falloff(column as f64, row as f64) * gains[pixel];
            let shot = noise::normal(noise::place(column as u32, row as u32), key);
            let deviation = (mean / per_electron + optics.ccd.read_noise_e * optics.ccd.read_noise_e).sqrt() * per_electron;
            let expected = (8.0 + mean + deviation * shot).round();
            apart += u32::from((f64::from(image[pixel]) - expected).abs() > 0.5);
            assert!((f64::from(image[pixel]) - expected).abs() < 1.5, "frame {frame}, pixel {pixel}");
        }
        // Half floats are 0.06 DN apart at 100 DN: up to so many of the pixels round the other way.
        assert!(apart < 1600 / 10, "frame {frame}: {apart} of 1600 pixels differ");
    }
}

#[test]
fn a_pixel_that_is_blind_is_black_however_much_light_it_gets() {
    // The seed is one for which a pixel of the first row, at the widest spread of gains, has none.
    let (seed, pixel) = (7834, 58);
    let ccd = Ccd { prnu: 0.2, ..Ccd::default() };
    assert_eq!(noise::gains(seed, ccd.prnu, pixel + 1, 1).last(), Some(0.0));
    let Some(gpu) = common::gpu() else { return };
    let rig = square_on();
    // In the image's corner a tenth of the peak is left.
    let optics = Optics { headlamp_peak_dn: 1000.0, ccd, ..Optics::default() };
    let mut renderer = WgpuRenderer::new(gpu, &facing_wall(), &rig, &optics, &LOOKS, seed).unwrap();
    let mut view = view(&rig, &base_at(1.0, 0.0, 0.0));
    for frame in 0..5 {
        view.frame = frame;
        let pixels = image(&mut renderer, &rig, &view);
        // Read noise is 0.12 DN: four of its standard deviations are still rounded away.
        assert_eq!(pixels[pixel], 8, "frame {frame}");
        assert!(pixels[pixel - 1] > 40 && pixels[pixel + 1] > 40, "frame {frame}: the pixels beside it are lit");
    }
}

#[test]
fn speckle_has_its_contrast_in_the_lasers_light_only() {
    let Some(gpu) = common::gpu() else { return };
    let rig = square_on();
    let silent = Ccd { read_noise_e: 0.0, prnu: 0.0, full_well_e: 1e8, ..Ccd::default() };
    let optics = Optics { speckle_contrast: 0.2, stripe_peak_dn: 120.0, ccd: silent, ..Optics::default() };
    let mut renderer =
        WgpuRenderer::new(gpu, &facing_wall(), &rig, &optics, &LOOKS, 5).expect("the rig and the optics are sound");
    let mut quiet = WgpuRenderer::new(gpu, &facing_wall(), &rig, &Optics { noise: false, ..optics }, &LOOKS, 5)
        .expect("the rig and the optics are sound");
    let mut view = view(&rig, &base_at(1.0, 0.0, 0.0));
    view.headlamp_power = 0.0;
    let still = image(&mut quiet, &rig, &view);
    let (mut squares, mut count) = (0.0, 0.0);
    for frame in 0..20 {
        view.frame = frame;
        let speckled = image(&mut renderer, &rig, &view);
        for pixel in (264..266).flat_map(|row| (220..420).map(move |column| row * 640 + column)) {
            let ratio = (f64::from(speckled[pixel]) - 8.0) / (f64::from(still[pixel]) - 8.0);
            squares += (ratio - 1.0) * (ratio - 1.0);
            count += 1.0;
        }
    }
    let contrast: f64 = f64::sqrt(squares / count);
    // 8000 values tell a standard deviation to 0.8 %; rounding to grey values of 100 adds 0.003 in quadrature.
    assert!((contrast - 0.2).abs() < 0.008, "{contrast}");

    (view.headlamp_power, view.laser_power) = (1.0, [0.0; 4]);
    let (lamp, still) = (image(&mut renderer, &rig, &view), image(&mut quiet, &rig, &view));
    assert!(lamp.iter().zip(&still).all(|(a, b)| a.abs_diff(*b) <= 1), "the headlamp's light has speckle");
}
