//! The CCD measured as a camera on a bench would be: EMVA Standard 1288, release 4.0, gives back what was put in.
//!
//! The even field that the standard asks for is daylight: the camera looks out of an open end that fills its view, with a lens that
//! does not fall off. Grey values are of 12 bits.

mod common;

use common::{base_at, straight, view, wide};
use ductloop_duct::network::{End, Network};
use ductloop_sensor::CpuRenderer;
use ductloop_sensor::optics::{Bits, Ccd, Lens, Optics};
use ductloop_sensor::renderer::{Renderer, View};
use ductloop_sensor::surface::Look;

const PIXELS: usize = 640 * 480;
/// DN of 12 bits for one of 8.
const FINE: f64 = 4095.0 / 255.0;

/// A camera in front of daylight that gives half a full well in 4 ms.
struct Bench {
    renderer: CpuRenderer,
    view: View,
    ccd: Ccd,
}

impl Bench {
    fn new(ccd: Ccd) -> Self {
        Self::before(ccd, 123.5)
    }

    /// The same camera with its lens covered.
    fn covered(ccd: Ccd) -> Self {
        Self::before(ccd, 0.0)
    }

    fn before(ccd: Ccd, ambient_dn: f64) -> Self {
        let lens = Lens { vignetting: false, ..Lens::default() };
        let ccd = Ccd { bits: Bits::Twelve, ..ccd };
        let optics = Optics { ambient_dn, lens, ccd: ccd.clone(), ..Optics::default() };
        let network = Network::from_run(&[straight(1.0, 0.5, 0.3)], End::Cap, End::Open).expect("a duct");
        let rig = wide();
        let renderer = CpuRenderer::new(&network, &rig, &optics, &[Look::matt(0.5)], 11, 1).expect("a bench");
        // 2 cm before the end: rays of up to 68 degrees leave through it.
        let mut view = view(&rig, &base_at(1.0 - 0.12 - 0.02, 0.0, 0.0));
        view.laser_power = [0.0; 4];
        view.headlamp_power = 0.0;
        Self { renderer, view, ccd }
    }

    /// Electrons for a grey value of 12 bits above black.
    fn electrons(&self, dn: f64) -> f64 {
        dn / FINE / self.ccd.dn_per_electron()
    }

    fn black_dn(&self) -> f64 {
        self.ccd.black_level_dn * FINE
    }

    fn frame(&mut self, exposure_s: f64, frame: u64) -> Vec<f64> {
        self.view.exposure_s = exposure_s;
        self.view.frame = frame;
        let mut image = vec![0_u16; PIXELS];
        self.renderer.render(&self.view, image.as_mut_slice().into()).expect("a frame");
        image.into_iter().map(f64::from).collect()
    }

    /// EMVA 1288, section 6.5: mean and temporal variance from a pair of frames.
    fn pair(&mut self, exposure_s: f64, frame: u64) -> (f64, f64) {
        let (a, b) = (self.frame(exposure_s, frame), self.frame(exposure_s, frame + 1));
        let n = PIXELS as f64;
        let means = [&a, &b].map(|image| image.iter().sum::<f64>() / n);
        let squares = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / n;
        let off = means[0] - means[1];
        ((means[0] + means[1]) / 2.0, (squares - off * off) / 2.0)
    }

    /// Mean over the frames of each pixel (EMVA 1288, section 8), and the mean temporal variance that is left in it.
    fn averaged(&mut self, exposure_s: f64, frames: u64) -> (Vec<f64>, f64) {
        let mut sum = vec![0.0; PIXELS];
        let mut squares = vec![0.0; PIXELS];
        for frame in 0..frames {
            for ((sum, square), value) in sum.iter_mut().zip(&mut squares).zip(self.frame(exposure_s, frame)) {
                *sum += value;
                *square += value * value;
            }
        }
        let n = frames as f64;
        let temporal: f64 = sum.iter().zip(&squares).map(|(s, q)| (q - s * s / n) / (n - 1.0)).sum::<f64>() / PIXELS as f64;
        (sum.into_iter().map(|s| s / n).collect(), temporal / n)
    }
}

fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n)
}

fn within(what: &str, found: f64, expected: f64, share: f64) {
    println!("{what}: {found:.4} for {expected:.4}");
    assert!((found / expected - 1.0).abs() < share, "{what}: {found} instead of {expected}");
}

/// The photon transfer curve: gain from the slope of variance over mean, read noise from the dark, full well from saturation.
#[test]
fn the_photon_transfer_curve_gives_back_gain_read_noise_and_full_well() {
    let mut bench = Bench::new(Ccd { prnu: 0.0, ..Ccd::default() });
    let gain = bench.ccd.dn_per_electron() * FINE;
    // Up to 70 % of saturation, as the standard has it.
    let points: Vec<_> = (1..=14).map(|step| bench.pair(0.4e-3 * f64::from(step), 2 * u64::from(step as u32))).collect();
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let slope =
        points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / points.iter().map(|p| (p.0 - mx) * (p.0 - mx)).sum::<f64>();
    // A variance of 3e5 values scatters by 0.26 %; a line through fourteen of them by half of that.
    within("gain, DN per electron", slope, gain, 0.006);

    let mut dark = Bench::covered(Ccd { prnu: 0.0, ..Ccd::default() });
    let (mean, variance) = dark.pair(1e-5, 0);
    within("black level, DN", mean, dark.black_dn(), 0.001);
    within("read noise, electrons", (variance - 1.0 / 12.0).sqrt() / gain, 15.0, 0.01);

    let (saturated, variance) = bench.pair(12e-3, 100);
    within("full well, electrons", bench.electrons(saturated - bench.black_dn()), 30_000.0, 0.002);
    assert!(variance < 1.0, "a full well is full: its variance is {variance} DN^2");
}

#[test]
fn the_spatial_variances_give_back_prnu_and_dsnu() {
    let ccd = Ccd { prnu: 0.015, dsnu_e: 40.0, ..Ccd::default() };
    let mut bench = Bench::new(ccd.clone());
    let (lit, left_lit) = bench.averaged(4e-3, 24);
    let (dark, left_dark) = Bench::covered(ccd).averaged(4e-3, 24);
    let (mean_lit, variance_lit) = mean_and_variance(&lit);
    let (mean_dark, variance_dark) = mean_and_variance(&dark);
    let (spatial_lit, spatial_dark) = (variance_lit - left_lit, variance_dark - left_dark);
    // EMVA 1288, equations 45 and 46.
    within("DSNU, electrons", bench.electrons(spatial_dark.sqrt()), 40.0, 0.01);
    within("PRNU", (spatial_lit - spatial_dark).sqrt() / (mean_lit - mean_dark), 0.015, 0.01);
}

#[test]
fn the_dark_current_is_the_slope_of_the_dark_signal_over_exposure() {
    let mut bench = Bench::covered(Ccd { prnu: 0.0, dark_current_e_s: 5e4, ..Ccd::default() });
    let (short, _) = bench.pair(10e-3, 0);
    let (long, variance) = bench.pair(110e-3, 2);
    within("dark current, electrons/s", bench.electrons(long - short) / 0.1, 5e4, 0.005);
    // It has shot noise: 5500 electrons have a variance of 5500, beside the read noise's 225.
    let gain = bench.ccd.dn_per_electron() * FINE;
    within("dark variance, electrons^2", (variance - 1.0 / 12.0) / (gain * gain), 5500.0 + 225.0, 0.02);
}

#[test]
fn hot_pixels_are_as_many_and_as_hot_as_asked_for() {
    let mut bench = Bench::covered(Ccd { prnu: 0.0, hot_pixels: 0.01, hot_pixel_e_s: 1e5, ..Ccd::default() });
    let (pixels, _) = bench.averaged(50e-3, 8);
    // 5000 electrons on the mean, exponentially distributed; of those above t the mean exceeds t by 5000 again.
    let limit_e = 200.0;
    let hot: Vec<f64> = pixels.iter().map(|p| bench.electrons(p - bench.black_dn())).filter(|e| *e > limit_e).collect();
    // Three thousand of them: their number scatters by 1.8 %, their mean by as much. Some exceed the full well (e^-6) and are cut.
    within("share of hot pixels", hot.len() as f64 / PIXELS as f64, 0.01 * libm::exp(-limit_e / 5000.0), 0.06);
    within("their mean, electrons", hot.iter().sum::<f64>() / hot.len() as f64 - limit_e, 5000.0, 0.06);
}

/// Every camera of the same seed is the same camera; another seed is another.
#[test]
fn fixed_patterns_belong_to_the_seed() {
    let mut bench = Bench::covered(Ccd { read_noise_e: 0.0, dsnu_e: 100.0, ..Ccd::default() });
    assert_eq!(bench.frame(1e-5, 0), bench.frame(1e-5, 1), "without read noise or light every frame shows the pattern alone");
}
