//! A slanted stripe in each pixel, against the integral of its blurred Gaussian over the pixel's square, taken numerically.
//!
//! The closed form integrates the larger of the square's two extents across the stripe exactly and counts the smaller as a variance
//! (`strip.rs`): at 45 degrees, where both are the same, nearly a fifth of a thin stripe's variance comes from the smaller one.

mod common;
mod ray_cast;

use common::{LOOKS, base_at, facing_wall, square_on, view};
use ductloop_nav::rig::{LineWidth, Rig};
use ductloop_sensor::CpuRenderer;
#[cfg(feature = "wgpu")]
use ductloop_sensor::WgpuRenderer;
use ductloop_sensor::light::FWHM_PER_SIGMA;
use ductloop_sensor::optics::{Bits, Ccd, Lens, Optics};
use ductloop_sensor::renderer::Renderer;
use nalgebra::{Point3, Unit, Vector3};
use ray_cast::{View, of_strips};

const WALL_M: f64 = 0.3;
const FOCAL_PX: f64 = 378.4;
const MIDDLE_PX: [f64; 2] = [319.5, 239.5];
/// DN of 8 bits for one of 12.
const FINE: f64 = 255.0 / 4095.0;
/// Brightest pixel, nearly.
const PEAK_DN: f64 = 200.0;
/// A fifth of a pixel on the wall.
const SIGMA_PX: f64 = 0.2;
const PSF_PX: f64 = 0.6;

/// A thin stripe on the wall, `off_px` from the image's middle, whose normal is at an angle to the columns.
struct Slanted {
    normal: [f64; 2],
    off_px: f64,
    rig: Rig,
    optics: Optics,
}

impl Slanted {
    fn new(angle_deg: f64, off_px: f64) -> Self {
        let (sin, cos) = libm::sincos(angle_deg.to_radians());
        let offset_m = off_px / FOCAL_PX * WALL_M;
        let width_m = SIGMA_PX / FOCAL_PX * WALL_M * FWHM_PER_SIGMA;
        let mut rig = Rig { line: LineWidth { width_m, growth_rad: 0.0 }, ..square_on() };
        // In a plane parallel to the line of sight: it meets the wall squarely, and its middle is the stripe's point next to the
        // image's.
        rig.lasers[0].normal_in_camera = Unit::new_normalize(Vector3::new(sin, cos, 0.0));
        rig.lasers[0].source_in_camera = Point3::new(sin * offset_m, cos * offset_m, 0.0);
        rig.lasers[0].offset_m = offset_m;
        let lens = Lens { vignetting: false, psf_sigma_px: PSF_PX, ..Lens::default() };
        let ccd = Ccd { black_level_dn: 0.0, bits: Bits::Twelve, ..Ccd::default() };
        // On the wall; what arrives is spread by lens and pixel.
        let stripe_peak_dn = PEAK_DN * (SIGMA_PX * SIGMA_PX + PSF_PX * PSF_PX + 1.0 / 12.0).sqrt() / SIGMA_PX;
        let optics = Optics { noise: false, headlamp_peak_dn: 0.0, stripe_peak_dn, lens, ccd, ..Optics::default() };
        Self { normal: [sin, cos], off_px, rig, optics }
    }

    /// Pixels about the middle of the stripe: over a few pixels its brightness is even.
    fn pixels(&self) -> impl Iterator<Item = [usize; 2]> {
        const REACH: usize = 5;
        let [u, v] = [0, 1].map(|axis| (MIDDLE_PX[axis] + self.off_px * self.normal[axis]).round() as usize - REACH);
        (0..=2 * REACH).flat_map(move |j| (0..=2 * REACH).map(move |i| [u + i, v + j]))
    }

    /// The mean over the pixel's square of the Gaussian that the lens makes of the stripe's.
    fn expected(&self, pixel: [usize; 2]) -> f64 {
        const STEPS: usize = 40;
        let variance = SIGMA_PX * SIGMA_PX + PSF_PX * PSF_PX;
        let place = |n: usize, i: usize| n as f64 - 0.5 + (i as f64 + 0.5) / STEPS as f64;
        let mut sum = 0.0;
        for i in 0..STEPS {
            for j in 0..STEPS {
                let at = [place(pixel[0], i) - MIDDLE_PX[0], place(pixel[1], j) - MIDDLE_PX[1]];
                let off_px = self.normal[0] * at[0] + self.normal[1] * at[1] - self.off_px;
                sum += libm::exp(-off_px * off_px / (2.0 * variance));
            }
        }
        self.optics.stripe_peak_dn * SIGMA_PX / variance.sqrt() * sum / (STEPS * STEPS) as f64
    }

    /// Every pixel is right: the smaller extent, a box that is counted as a Gaussian, has a fourth moment of its own, which is 2 in
    /// 1000 of the peak at 45 degrees; 12 bits are rounded to half of 0.06 DN. Half floats of the graphics engine are within that.
    #[track_caller]
    fn assert_found(&self, what: &str, found: impl Fn([usize; 2]) -> f64) {
        let (mut worst, mut peak) = (0.0_f64, 0.0_f64);
        for pixel in self.pixels() {
            let expected = self.expected(pixel);
            worst = worst.max((found(pixel) - expected).abs());
            peak = peak.max(expected);
        }
        println!("{what}, normal {:.2?}, {} px from the middle: {worst:.3} DN of {peak:.1}", self.normal, self.off_px);
        assert!(peak > 0.7 * PEAK_DN, "there is something to compare: {peak}");
        assert!(worst < 0.003 * peak, "{what}, normal {:.2?}, {} px off: {worst} DN of {peak}", self.normal, self.off_px);
    }
}

#[test]
fn a_slanted_stripe_is_integrated_over_each_pixels_square() {
    let network = facing_wall();
    let base = base_at(1.0, 0.0, 0.0);
    for angle_deg in [0.0, 20.0, 45.0, 62.0, -45.0] {
        for off_px in [25.0, 25.37, 25.8] {
            let slanted = Slanted::new(angle_deg, off_px);
            let Slanted { rig, optics, .. } = &slanted;
            let view = view(rig, &base);
            let model = View { network: &network, rig, optics, looks: &LOOKS, world_from_camera: view.world_from_camera };
            let geometry = model.geometry(0);
            slanted.assert_found("model", |pixel| of_strips(&model, &geometry, pixel.map(|n| n as f64), |_| true));

            let cpu = CpuRenderer::new(&network, rig, optics, &LOOKS, 1, 1).expect("a sound scene");
            let mut renderers: Vec<(&str, Box<dyn Renderer>)> = vec![("cpu", Box::new(cpu))];
            #[cfg(feature = "wgpu")]
            if let Some(gpu) = common::gpu() {
                let wgpu = WgpuRenderer::new(gpu, &network, rig, optics, &LOOKS, 1).expect("a sound scene");
                renderers.push(("wgpu", Box::new(wgpu)));
            }
            for (name, renderer) in &mut renderers {
                let mut image = vec![0_u16; 640 * 480];
                renderer.render(&view, image.as_mut_slice().into()).expect("a frame");
                slanted.assert_found(name, |[u, v]| f64::from(image[v * 640 + u]) * FINE);
            }
        }
    }
}
