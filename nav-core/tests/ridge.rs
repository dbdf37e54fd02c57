//! The rig-free extractor on images whose stripes are known.

use ductloop_nav::messages::Frame;
use ductloop_nav::perception::ridge::{Region, Ridge, RidgeCentre, RidgeParams};
use ductloop_nav::perception::scan::Across;
use proptest::prelude::*;

/// Sub-random numbers of their own: nothing here is shared with the simulator.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A normal one, nearly.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

const WIDTH: usize = 640;
const HEIGHT: usize = 480;

/// A stripe: y = y0 + slope x + bend x^2 in scan coordinates, with its Gaussian's standard deviation and height.
#[derive(Clone, Copy, Debug)]
struct Stripe {
    y0_px: f64,
    slope: f64,
    bend: f64,
    sigma_px: f64,
    height_dn: f64,
}

impl Stripe {
    fn at(&self, x: f64) -> f64 {
        self.y0_px + x * (self.slope + x * self.bend)
    }
}

/// An image of stripes that run along u or along v, in values of which 255 would be full in 8 bits, times `gain`.
fn image(stripes: &[Stripe], across: Across, speckle: f64, noise_dn: f64, gain: f64, full: f64) -> Vec<u16> {
    let mut noise = Noise(7);
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for v in 0..HEIGHT {
        for u in 0..WIDTH {
            let [x, y] = across.pixel(u as f64, v as f64);
            let light: f64 = stripes
                .iter()
                .map(|stripe| {
                    let off = (y - stripe.at(x)) / stripe.sigma_px;
                    stripe.height_dn * libm::exp(-off * off / 2.0)
                })
                .sum();
            let value = 12.0 + 0.02 * u as f64 + light * (1.0 + speckle * noise.normal()) + noise_dn * noise.normal();
            pixels.push((gain * value).round().clamp(0.0, full) as u16);
        }
    }
    pixels
}

fn eight(pixels: &[u16]) -> Vec<u8> {
    pixels.iter().map(|p| u8::try_from(*p).expect("8 bits")).collect()
}

/// RMS error across the stripe, in pixels; RMS of error over stated deviation; share of the stripe's columns with a centre.
fn score(centres: &[RidgeCentre], stripe: &Stripe, across: Across) -> [f64; 3] {
    let length = across.pixel(WIDTH as f64, HEIGHT as f64)[0];
    let errors: Vec<[f64; 2]> = centres
        .iter()
        .filter_map(|centre| {
            let [x, y] = across.pixel(centre.u_px, centre.v_px);
            let error = y - stripe.at(x);
            (error.abs() < 5.0).then_some([error, error / centre.sigma_px])
        })
        .collect();
    let rms = |k: usize| (errors.iter().map(|e| e[k] * e[k]).sum::<f64>() / errors.len() as f64).sqrt();
    [rms(0), rms(1), errors.len() as f64 / length]
}

/// Default noise: 12 % speckle, half a value of read noise. `reference.md`'s bound for such a column is 0.06 to 0.08 px for a stripe of
/// 4 px, and grows with the square root of the width.
#[test]
fn centres_are_as_exact_as_speckle_allows_and_say_so() {
    for across in [Across::V, Across::U] {
        for fwhm_px in [2.5, 4.0, 8.0, 16.0] {
            let stripe = Stripe { y0_px: 150.3, slope: 0.17, bend: 0.0, sigma_px: fwhm_px / 2.355, height_dn: 120.0 };
            let pixels = eight(&image(&[stripe], across, 0.12, 0.5, 1.0, 255.0));
            let mut ridge = Ridge::new(RidgeParams::default());
            let centres = ridge.extract(&Frame::grey8(WIDTH, HEIGHT, &pixels), None).to_vec();
            assert_eq!(ridge.across(), across);
            assert_eq!(ridge.lines().len(), 1, "{:?}", ridge.lines());
            let [rms, nees, share] = score(&centres, &stripe, across);
            let bound = 0.075 * (fwhm_px / 4.0_f64).sqrt();
            println!("{across:?} {fwhm_px} px: {rms:.4} px RMS, {nees:.2} of the stated, {:.1} % of columns", 100.0 * share);
            assert!(rms < 1.2 * bound, "{fwhm_px} px: {rms}");
            assert!((0.8..1.25).contains(&nees), "{fwhm_px} px: {nees}");
            assert!(share > 0.98 && share <= 1.0, "{fwhm_px} px: {share}");
            let fwhm = centres.iter().map(|c| c.fwhm_px).sum::<f64>() / centres.len() as f64;
            assert!((fwhm / fwhm_px - 1.0).abs() < 0.05, "{fwhm_px} px: {fwhm}");
        }
    }
}

/// A stripe whose middle is full, at a third of its height: the flanks still have its centre.
#[test]
fn saturated_stripes_are_fitted_by_their_flanks() {
    let stripe = Stripe { y0_px: 200.4, slope: -0.1, bend: 0.0, sigma_px: 3.0, height_dn: 700.0 };
    let pixels = eight(&image(&[stripe], Across::V, 0.05, 1.0, 1.0, 255.0));
    let mut ridge = Ridge::new(RidgeParams::default());
    let centres = ridge.extract(&Frame::grey8(WIDTH, HEIGHT, &pixels), None);
    let [rms, nees, share] = score(centres, &stripe, Across::V);
    // A third of the light and its steepest part is gone: half the exactness is left.
    assert!(rms < 0.2 && (0.7..1.4).contains(&nees) && share > 0.98, "{rms} {nees} {share}");
}

/// A stripe across a chessboard: on its white squares a halo half as high as the stripe, as wide as a square, ends beside it at the
/// square's edges, off the stripe's middle. The stripe's core decides.
#[test]
fn halos_on_white_squares_do_not_move_the_stripe() {
    let stripe = Stripe { y0_px: 200.3, slope: 0.03, bend: 0.0, sigma_px: 1.8, height_dn: 90.0 };
    let mut pixels = image(&[stripe], Across::V, 0.1, 0.7, 1.0, 255.0);
    for v in 192..226 {
        for u in (0..WIDTH).filter(|u| u / 40 % 2 == 0) {
            let from_edge = (v - 191).min(226 - v).min(8) as f64 / 8.0;
            pixels[v * WIDTH + u] += (45.0 * from_edge) as u16;
        }
    }
    let mut ridge = Ridge::new(RidgeParams::default());
    let centres = ridge.extract(&Frame::grey8(WIDTH, HEIGHT, &eight(&pixels)), None);
    let [rms, _, share] = score(centres, &stripe, Across::V);
    println!("{rms:.3} px RMS, {:.1} % of columns", 100.0 * share);
    // Without the halo it is 0.05 px; the halo's own slopes, a fifth of the stripe's, are what remains.
    // Where the filter takes the middle of a whole square for the stripe's, there is no centre: at most a fifth of the columns.
    assert!(rms < 0.15 && share > 0.8, "{rms} px, {share}");
}

/// Two stripes, one bent: each has its centres, and lines follow the bend in pieces.
#[test]
fn several_stripes_and_bent_ones_are_told_apart() {
    let straight = Stripe { y0_px: 100.0, slope: 0.05, bend: 0.0, sigma_px: 1.5, height_dn: 60.0 };
    let bent = Stripe { y0_px: 250.0, slope: 0.3, bend: -3e-4, sigma_px: 2.5, height_dn: 150.0 };
    let pixels = image(&[straight, bent], Across::V, 0.1, 1.0, 16.0, 4095.0);
    let mut ridge = Ridge::new(RidgeParams::default());
    let centres = ridge.extract(&Frame::grey16(WIDTH, HEIGHT, &pixels, 4095), None).to_vec();
    for stripe in [straight, bent] {
        let [rms, _, share] = score(&centres, &stripe, Across::V);
        assert!(rms < 0.12 && share > 0.98, "{stripe:?}: {rms} {share}");
    }
    assert!(centres.len() <= 2 * WIDTH, "{}", centres.len());
    let worst = ridge.lines().iter().map(|line| line.residual_px).fold(0.0, f64::max);
    assert!((3..=9).contains(&ridge.lines().len()) && worst < 0.6, "{:?}", ridge.lines());
    for centre in &centres {
        assert!(centre.line < ridge.lines().len());
    }
}

/// The same scene in 8 bits and in 12 gives the same centres, up to rounding to a whole grey value: 0.3 of one in a slope of 30 a pixel.
#[test]
fn bits_do_not_matter() {
    let stripe = Stripe { y0_px: 150.3, slope: 0.17, bend: 0.0, sigma_px: 2.0, height_dn: 90.0 };
    let [small, large] =
        [(1.0, 255.0), (4095.0 / 255.0, 4095.0)].map(|(gain, full)| image(&[stripe], Across::V, 0.1, 1.0, gain, full));
    let mut ridge = Ridge::new(RidgeParams::default());
    let from_8 = ridge.extract(&Frame::grey8(WIDTH, HEIGHT, &eight(&small)), None).to_vec();
    let from_12 = ridge.extract(&Frame::grey16(WIDTH, HEIGHT, &large, 4095), None);
    assert_eq!(from_8.len(), from_12.len());
    let square = |(a, b): (&RidgeCentre, &RidgeCentre)| (a.v_px - b.v_px).powi(2);
    let rms = (from_8.iter().zip(from_12).map(square).sum::<f64>() / from_8.len() as f64).sqrt();
    assert!(rms < 0.02, "{rms}");
    for (a, b) in from_8.iter().zip(from_12) {
        assert!((a.height_dn - b.height_dn).abs() < 2.0 && (a.fwhm_px - b.fwhm_px).abs() < 0.2, "{a:?} {b:?}");
    }
}

#[test]
fn nothing_is_seen_outside_the_region() {
    let stripes = [90.0, 300.0].map(|y0_px| Stripe { y0_px, slope: 0.02, bend: 0.0, sigma_px: 2.0, height_dn: 90.0 });
    let pixels = eight(&image(&stripes, Across::V, 0.1, 1.0, 1.0, 255.0));
    let region = Region::polygon(&[[100.0, 250.0], [400.0, 270.0], [500.0, 400.0], [90.0, 420.0]]).expect("finite");
    let mut ridge = Ridge::new(RidgeParams::default());
    let centres = ridge.extract(&Frame::grey8(WIDTH, HEIGHT, &pixels), Some(&region));
    assert!(centres.len() > 300, "{}", centres.len());
    assert!(centres.iter().all(|centre| region.contains(centre.u_px, centre.v_px)));
}

/// Images without a stripe: black, white, a pixel, a step, a single bright pixel, nothing but noise.
#[test]
fn where_there_is_no_stripe_none_is_seen() {
    let mut ridge = Ridge::new(RidgeParams::default());
    let mut noise = Noise(3);
    let mut noisy =
        |sigma: f64| (0..WIDTH * HEIGHT).map(|_| (100.0 + sigma * noise.normal()).clamp(0.0, 255.0) as u8).collect::<Vec<_>>();
    let step: Vec<u8> = (0..WIDTH * HEIGHT).map(|i| if i % WIDTH < 300 { 20 } else { 200 }).collect();
    let mut speck = vec![10_u8; WIDTH * HEIGHT];
    speck[200 * WIDTH + 300] = 255;
    for pixels in [vec![0; WIDTH * HEIGHT], vec![255; WIDTH * HEIGHT], step, speck, noisy(3.0), noisy(40.0)] {
        assert_eq!(ridge.extract(&Frame::grey8(WIDTH, HEIGHT, &pixels), None), []);
        assert!(ridge.lines().is_empty() && ridge.stages().centres.is_empty());
    }
    for (width, height) in [(0, 0), (1, 1), (1, 480), (640, 1), (2, 3)] {
        let pixels = vec![200_u8; width * height];
        assert_eq!(ridge.extract(&Frame::grey8(width, height, &pixels), None), []);
    }
}

/// The steady state allocates nothing, whatever the frame.
#[test]
fn no_allocation_after_the_first_frames() {
    let stripe = Stripe { y0_px: 150.3, slope: 0.17, bend: -1e-4, sigma_px: 2.0, height_dn: 90.0 };
    let mut frames = [Across::V, Across::U].map(|across| eight(&image(&[stripe], across, 0.1, 1.0, 1.0, 255.0))).to_vec();
    frames.push(vec![0; WIDTH * HEIGHT]);
    frames.push(vec![255; WIDTH * HEIGHT]);
    let region = Region::rectangle([20.0, 20.0], [500.0, 400.0]).expect("finite");
    let mut ridge = Ridge::new(RidgeParams::default());
    let mut step = |index: usize| {
        let region = index.is_multiple_of(3).then_some(&region);
        ridge.extract(&Frame::grey8(WIDTH, HEIGHT, &frames[index % frames.len()]), region).len()
    };
    let seen: usize = (0..12).map(&mut step).sum();
    assert!(seen > 1000, "{seen}");
    let counted = allocation_counter::measure(|| {
        (12..36).for_each(|index| {
            step(index);
        });
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Whatever the bytes, of 8 bits or 16, no panic and nothing that is not finite.
    #[test]
    fn any_image_gives_finite_numbers(
        width in 0..200usize, height in 0..150usize, deep in any::<bool>(), max_dn in any::<u16>(), seed in any::<u64>(), kind in 0..4u8,
        corners in prop::collection::vec([-50.0..250.0f64, -50.0..250.0f64], 0..6),
    ) {
        let mut noise = Noise(seed);
        let mut pixels = vec![0_u16; width * height];
        match kind {
            0 => pixels.iter_mut().for_each(|p| *p = (noise.uniform() * 65_536.0) as u16),
            1 => pixels.fill((noise.uniform() * 65_536.0) as u16),
            2 => for _ in 0..30 {
                if width * height == 0 { break }
                let (x, y) = ((noise.uniform() * width as f64) as usize, (noise.uniform() * height as f64) as usize);
                let value = (noise.uniform() * 65_536.0) as u16;
                for row in y..(y + 5).min(height) { pixels[row * width + x..(row + 1) * width].fill(value); }
            },
            _ => pixels.iter_mut().enumerate().for_each(|(i, p)| *p = ((i as u64).wrapping_mul(seed) >> 7) as u16),
        }
        let small: Vec<u8> = pixels.iter().map(|p| *p as u8).collect();
        let frame = if deep { Frame::grey16(width, height, &pixels, max_dn) } else { Frame::grey8(width, height, &small) };
        let region = Region::polygon(&corners);
        let mut ridge = Ridge::new(RidgeParams { min_points: 5, ..RidgeParams::default() });
        for centre in ridge.extract(&frame, region.as_ref()) {
            let numbers = [centre.u_px, centre.v_px, centre.sigma_px, centre.fwhm_px, centre.height_dn];
            prop_assert!(numbers.iter().all(|x| x.is_finite()), "{centre:?}");
            prop_assert!(centre.sigma_px > 0.0);
            prop_assert!((-0.5..width as f64).contains(&centre.u_px) && (-0.5..height as f64).contains(&centre.v_px));
        }
        for line in ridge.lines() {
            prop_assert!(line.ends_px.iter().flatten().chain([&line.residual_px]).all(|x| x.is_finite()), "{line:?}");
        }
    }
}
