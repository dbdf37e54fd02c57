//! A stripe's light against closed forms: its power, its width under defocus and motion, its centre wherever it falls between pixels.

mod common;

use common::{LINE, base_at, facing_wall, square_on, view};
use ductloop_nav::rig::{LineWidth, Rig};
use ductloop_sensor::CpuRenderer;
use ductloop_sensor::optics::{Bits, Ccd, Lens, Optics};
use ductloop_sensor::renderer::Renderer;
use ductloop_sensor::surface::Look;
use nalgebra::{Point3, Vector3};

/// DN of 8 bits for one of 12.
const FINE: f64 = 255.0 / 4095.0;
/// Distance of the wall from the camera.
const WALL_M: f64 = 0.3;

/// The level slit at this height below the camera, parallel to its axis: on the wall at `height / 0.3 * 378.4` px below the middle.
fn level(height_m: f64, line: LineWidth) -> Rig {
    let mut rig = Rig { line, ..square_on() };
    rig.lasers[0].source_in_camera = Point3::new(0.0, height_m, 0.0);
    rig.lasers[0].offset_m = height_m;
    rig
}

fn bright(lens: Lens) -> Optics {
    let ccd = Ccd { black_level_dn: 0.0, bits: Bits::Twelve, ..Ccd::default() };
    Optics { noise: false, headlamp_peak_dn: 0.0, lens, ccd, ..Optics::default() }
}

/// Zeroth, first and second moment along the column of the image's middle: light in DN px, centre in px, variance in px^2.
fn moments(rig: &Rig, optics: &Optics, speed_m_s: f64) -> [f64; 3] {
    let mut renderer = CpuRenderer::new(&facing_wall(), rig, optics, &[Look::matt(0.5)], 1, 1).expect("a sound scene");
    let mut view = view(rig, &base_at(1.0, 0.0, 0.0));
    view.motion.linear_m_s = Vector3::new(speed_m_s, 0.0, 0.0);
    let mut image = vec![0_u16; 640 * 480];
    renderer.render(&view, image.as_mut_slice().into()).expect("a frame");
    let light = |row: usize| f64::from(image[row * 640 + 320]) * FINE;
    let sum: f64 = (0..480).map(light).sum();
    let centre = (0..480).map(|row| light(row) * row as f64).sum::<f64>() / sum;
    let variance = (0..480).map(|row| light(row) * (row as f64 - centre) * (row as f64 - centre)).sum::<f64>() / sum;
    [sum, centre, variance]
}

/// Light of a stripe of peak 1 DN on a wall met squarely at the reference: the area under a Gaussian of its width, in DN px.
fn whole_light(line: &LineWidth) -> f64 {
    let sigma_px = line.at(WALL_M) / 2.354_820_045 / WALL_M * 378.4;
    (std::f64::consts::TAU).sqrt() * sigma_px
}

fn flat() -> Lens {
    Lens { vignetting: false, ..Lens::default() }
}

#[test]
fn a_stripe_has_its_light_and_its_place_wherever_it_falls_between_pixels() {
    // From ten pixels wide to a tenth of a pixel, 0.6 um on the sensor.
    for width_m in [8e-3, 2e-3, 5e-4, 8e-5] {
        let line = LineWidth { width_m, growth_rad: 0.0 };
        // Thin ones brighter, so that all are seen well above the rounding.
        let stripe_peak_dn = 180.0 * (1.5e-3 / width_m).max(1.0);
        for phase in 0..10 {
            let offset_px = 25.0 + f64::from(phase) / 10.0;
            let rig = level(offset_px / 378.4 * WALL_M, line);
            let optics = Optics { stripe_peak_dn, ..bright(flat()) };
            let [light, centre, _] = moments(&rig, &optics, 0.0);
            // Rounding to 12 bits: 0.03 DN in each of some tens of pixels; and the way to the wall is longer than 0.3 m by up to
            // 0.3 % for a laser in the camera's own plane, none for one that looks straight ahead.
            let expected = stripe_peak_dn * whole_light(&line);
            assert!((light / expected - 1.0).abs() < 0.003, "{width_m} m at {offset_px}: {light} for {expected}");
            // A point spread of 0.6 px sampled at whole pixels keeps its centre to 2e-3 px.
            let place = 239.5 + offset_px;
            assert!((centre - place).abs() < 0.006, "{width_m} m: {centre} for {place}");
        }
    }
}

#[test]
fn defocus_spreads_the_light_and_keeps_it() {
    let rig = level(0.02, LINE);
    let [sharp, _, narrow] = moments(&rig, &bright(flat()), 0.0);
    for (aperture_m, focus_m) in [(5e-4, 0.15), (1e-3, 1e9), (2e-3, 1.0), (1e-3, 0.1)] {
        let [light, _, wide] = moments(&rig, &bright(Lens { aperture_m, focus_m, ..flat() }), 0.0);
        assert!((light / sharp - 1.0).abs() < 0.003, "{light} of {sharp}");
        let radius_px = aperture_m * 378.4 * (1.0 / WALL_M - 1.0 / focus_m) / 2.0;
        // A disc's variance along an axis is a quarter of its radius' square.
        let expected = narrow + radius_px * radius_px / 4.0;
        assert!((wide / expected - 1.0).abs() < 0.01, "aperture {aperture_m}: variance {wide} for {expected}");
    }
}

#[test]
fn motion_blurs_by_image_speed_times_exposure() {
    // Toward the wall at v, a stripe at height h moves down by f h v t / z^2.
    let height_m = 0.1;
    let rig = level(height_m, LINE);
    let [still, _, narrow] = moments(&rig, &bright(flat()), 0.0);
    for moved_px in [1.0, 2.0, 5.0, 12.0] {
        let speed_m_s = moved_px * WALL_M * WALL_M / (378.4 * height_m) / 4e-3;
        let [light, _, wide] = moments(&rig, &bright(flat()), speed_m_s);
        let moved = (12.0 * (wide - narrow)).max(0.0).sqrt();
        println!("moved by {moved:.3} px for {moved_px}; light {:.4}", light / still);
        // The stripe becomes thicker as the wall comes nearer, by a share of 0.2 % a pixel of motion, and its variance in step.
        assert!((moved / moved_px - 1.0).abs() < 0.03, "{moved} px for {moved_px}");
        assert!((light / still - 1.0).abs() < 0.01);
    }
    let optics = bright(Lens { motion_blur: false, ..flat() });
    let [_, _, frozen] = moments(&rig, &optics, 5.0);
    assert!((frozen - narrow).abs() < 1e-9, "without motion blur nothing moves");
}

#[test]
fn the_lens_falls_off_with_the_fourth_power_of_the_cosine() {
    let rig = level(0.02, LINE);
    let column = |vignetting: bool| {
        let optics = bright(Lens { vignetting, ..Lens::default() });
        let mut renderer = CpuRenderer::new(&facing_wall(), &rig, &optics, &[Look::matt(0.5)], 1, 1).expect("a sound scene");
        let mut image = vec![0_u16; 640 * 480];
        renderer.render(&view(&rig, &base_at(1.0, 0.0, 0.0)), image.as_mut_slice().into()).expect("a frame");
        move |u: usize| (240..300).map(|row| f64::from(image[row * 640 + u])).sum::<f64>()
    };
    let (dimmed, even) = (column(true), column(false));
    for u in [150, 250, 320, 420, 500] {
        let tangent = (u as f64 - 319.5) / 378.4;
        let height = 0.02 / WALL_M;
        let square = 1.0 / (1.0 + tangent * tangent + height * height);
        // The stripe is some ten rows thick: cos^4 varies over it.
        assert!((dimmed(u) / even(u) / (square * square) - 1.0).abs() < 0.004, "column {u}");
    }
}

/// Goodman, Speckle Phenomena in Optics: contrast is standard deviation over mean.
#[test]
fn speckle_has_the_contrast_and_the_grain_that_were_put_in() {
    // Light 300 mm thick: over the middle of the image it is even within a few percent, which the ratio to the quiet image removes.
    let rig = level(0.0201, LineWidth { width_m: 0.3, growth_rad: 0.0 });
    let ccd = Ccd { full_well_e: 1e9, read_noise_e: 0.0, prnu: 0.0, bits: Bits::Twelve, ..Ccd::default() };
    let shot = |contrast: f64, grain_px: f64, noise: bool| {
        let optics = Optics {
            speckle_contrast: contrast,
            speckle_grain_px: grain_px,
            stripe_peak_dn: 90.0,
            headlamp_peak_dn: 0.0,
            noise,
            ccd: ccd.clone(),
            ..Optics::default()
        };
        let mut renderer = CpuRenderer::new(&facing_wall(), &rig, &optics, &[Look::matt(0.5)], 1, 1).expect("a sound scene");
        let mut image = vec![0_u16; 640 * 480];
        renderer.render(&view(&rig, &base_at(1.0, 0.0, 0.0)), image.as_mut_slice().into()).expect("a frame");
        image.into_iter().map(|v| f64::from(v) * FINE - 8.0).collect::<Vec<f64>>()
    };
    for (contrast, grain_px) in [(0.12, 1.0), (0.3, 1.0), (0.3, 3.0)] {
        let (noisy, quiet) = (shot(contrast, grain_px, true), shot(contrast, grain_px, false));
        let ratio = |row: usize, column: usize| noisy[row * 640 + column] / quiet[row * 640 + column];
        let (mut n, mut first, mut second, mut product) = (0.0, 0.0, 0.0, [0.0; 7]);
        for row in 160..320 {
            for column in 220..420 {
                let off = ratio(row, column) - 1.0;
                n += 1.0;
                first += off;
                second += off * off;
                for (lag, sum) in product.iter_mut().enumerate() {
                    *sum += off * (ratio(row, column + lag) - 1.0);
                }
            }
        }
        let deviation = (second / n - (first / n) * (first / n)).sqrt();
        println!(
            "contrast {deviation:.4} for {contrast}, correlation at 1, 2, 3 px {:.2?}",
            [1, 2, 3].map(|lag| product[lag] / second)
        );
        // Grains of 3 px: a ninth as many independent values, 3500: 1.2 % scatter.
        assert!((deviation / contrast - 1.0).abs() < 0.04, "contrast {deviation} for {contrast}");
        // Grains are as far apart as they are wide: nothing is left at twice their size, half or more is within half of it.
        let correlation = |lag: usize| product[lag] / second;
        assert!(correlation((2.0 * grain_px) as usize).abs() < 0.1, "beyond two grains");
        assert!(grain_px == 1.0 || correlation((grain_px / 2.0) as usize) > 0.5, "within half a grain");
    }
}
