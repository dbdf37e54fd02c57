//! Spangles and seams as lens, pixel and motion leave them: against sums over many rays, and over many frames of a camera that stands
//! still.

mod common;

use common::{base_at, duct, straight, view, wide};
use ductloop_duct::network::Network;
use ductloop_sensor::CpuRenderer;
use ductloop_sensor::frame_geometry::{FrameGeometry, Sweep};
use ductloop_sensor::noise::{SPANGLE_SLOPE2, SPANGLE_STEP, finalise, spangle_node};
use ductloop_sensor::optics::{Bits, Ccd, Lens, Optics};
use ductloop_sensor::renderer::{ImageMut, MAX_LASERS, Motion, Renderer, View};
use ductloop_sensor::scenery::Scenery;
use ductloop_sensor::surface::Look;
use nalgebra::{Translation3, Vector2, Vector3};

/// Grey values of twelve bits are sixteenths of those of eight.
const BITS12: f64 = 4095.0 / 255.0;

/// Headlamp alone, such that nothing is full where the floor is nearest.
fn lamp() -> Optics {
    Optics {
        noise: false,
        headlamp_peak_dn: 50.0,
        lens: Lens { vignetting: false, ..Lens::default() },
        ccd: Ccd { bits: Bits::Twelve, ..Ccd::default() },
        ..Optics::default()
    }
}

/// The frame in grey values of eight bits, with the lasers off.
fn light(renderer: &mut CpuRenderer, view: &View) -> Vec<f64> {
    let mut image = vec![0_u16; 640 * 480];
    let view = View { laser_power: [0.0; MAX_LASERS], ..view.clone() };
    renderer.render(&view, ImageMut::Grey16(&mut image)).expect("an image");
    image.into_iter().map(|value| f64::from(value) / BITS12).collect()
}

fn renderer(network: &Network, look: Look, optics: &Optics) -> CpuRenderer {
    CpuRenderer::new(network, &wide(), optics, &[look], 1, 1).expect("a renderer")
}

/// The spangle noise of docs/sensor-model.md, section 5.
fn noise(at: Vector2<f64>, bits: u32) -> f64 {
    let low = at.map(f64::floor);
    let weights = |share: f64| {
        let next = share * share * (3.0 - 2.0 * share);
        let length = ((1.0 - next) * (1.0 - next) + next * next).sqrt();
        [(1.0 - next) / length, next / length]
    };
    let (along_s, along_t) = (weights(at.x - low.x), weights(at.y - low.y));
    let node = |i: usize, j: usize| {
        along_s[i] * along_t[j] * f64::from(spangle_node(low.x as i32 + i as i32, low.y as i32 + j as i32, bits)) / SPANGLE_STEP
    };
    node(0, 0) + node(0, 1) + node(1, 0) + node(1, 1)
}

/// Points of a normal distribution of this variance and of an even one over a pixel, drawn by a sequence that fills the plane evenly.
fn places_in_a_pixel(variance_px2: f64, count: u32) -> impl Iterator<Item = Vector2<f64>> {
    (0..count).map(move |i| {
        // Kronecker sequence of the fourth root of 1's neighbours (M. Roberts, R4).
        let share = |root: f64| (f64::from(i) * root + 0.5).fract();
        let [a, b, c, d] = [0.856_674_884, 0.733_891_857, 0.628_706_721, 0.538_597_256].map(share);
        let radius = (-2.0 * variance_px2 * libm::log(1.0 - a)).sqrt();
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * b);
        Vector2::new(radius * cos + c - 0.5, radius * sin + d - 0.5)
    })
}

#[test]
fn the_noise_has_the_slope_that_its_blur_is_computed_from() {
    const STEPS: u32 = 200_000;
    // The derivative of atan(q / (1 - q)) by p.
    let slope = |p: f64| {
        let q = p * p * (3.0 - 2.0 * p);
        6.0 * p * (1.0 - p) / ((1.0 - q) * (1.0 - q) + q * q)
    };
    let mean = (0..STEPS).map(|i| slope((f64::from(i) + 0.5) / f64::from(STEPS))).map(|slope| slope * slope).sum::<f64>()
        / f64::from(STEPS);
    assert!((mean - SPANGLE_SLOPE2).abs() < 1e-6, "{mean}");
}

#[test]
fn spangles_fade_with_distance_as_a_lens_blurs_them() {
    // A wall 4 m wide and high across the view, so near that a spangle is 8 px and so far that it is 0.4 px.
    let look = Look { spangle: 0.1, spangle_m: 0.01, ..Look::matt(0.5) };
    for distance_m in [0.4, 1.0, 2.0, 4.0, 8.0] {
        let network = duct(&[straight(12.0, 4.0, 4.0)]);
        let base = base_at(12.0 - 0.12 - distance_m, 0.0, 0.0);
        let mut view = view(&wide(), &base);
        view.world_from_camera.translation.z = 2.0;
        // As bright everywhere, so that rounding does not show.
        let optics = Optics { headlamp_peak_dn: 100.0 * distance_m * distance_m / 0.09, ..lamp() };
        let [spangled, plain] = [look, Look::matt(0.5)].map(|look| light(&mut renderer(&network, look, &optics), &view));
        let scenery = Scenery::new(&network, &[look]).expect("sound looks");
        let mut geometry = FrameGeometry::new(&wide(), &lamp()).expect("a pinhole");
        geometry.build(&scenery, &Sweep::still(view.world_from_camera), &[0.0; MAX_LASERS]).expect("a clear camera");
        let cap = geometry.regions.iter().find(|region| region.plane.normal.z > 0.999).expect("the wall ahead");
        let (texture, bits) = (cap.texture.expect("spangles"), finalise(cap.sheet as u32));
        let reach = (0.45 * 4.0 / distance_m * 378.4).min(200.0) as usize;
        let black = lamp().ccd.black_level_dn;
        let (mut seen, mut expected, mut count) = (0.0, 0.0, 0.0);
        for v in (240 - reach..240 + reach).step_by(3) {
            for u in (320 - reach..320 + reach).step_by(3) {
                let [spangled, plain] = [&spangled, &plain].map(|image| image[v * 640 + u] - black);
                let here = |at: Vector2<f64>| {
                    let [x, y] = geometry.projection().ray([u as f64 + at.x, v as f64 + at.y]);
                    noise(texture.at(&Vector3::new(x, y, 1.0), &cap.plane), bits)
                };
                let mean = places_in_a_pixel(0.36, 400).map(here).sum::<f64>() / 400.0;
                let contrast = spangled / plain - 1.0;
                seen += contrast * contrast;
                expected += 0.01 * mean * mean;
                count += 1.0;
            }
        }
        let (seen, expected) = ((seen / count).sqrt(), (expected / count).sqrt());
        println!("{distance_m} m: contrast {seen:.4} for {expected:.4} of 0.1");
        assert!((seen / expected - 1.0).abs() < 0.06, "{distance_m} m: {seen} for {expected}");
    }
}

/// Greatest and root mean square difference, in DN, between a frame of a moving camera and the mean of frames along its way.
fn moving_against_still(look: Look, motion: Motion) -> (f64, f64) {
    const STILL: u32 = 96;
    let pieces: &[f64] = if look.seam_m > 0.0 { &[1.4, 0.4, 0.6, 2.0] } else { &[6.0] };
    let network = duct(&pieces.iter().map(|length_m| straight(*length_m, 0.5, 0.3)).collect::<Vec<_>>());
    let mut renderer = renderer(&network, look, &lamp());
    let view = View { motion, ..view(&wide(), &base_at(1.0, 0.03, 4.0)) };
    let moving = light(&mut renderer, &view);
    let mut mean = vec![0.0; moving.len()];
    for i in 0..STILL {
        let time_s = view.exposure_s * ((f64::from(i) + 0.5) / f64::from(STILL) - 0.5);
        let mut still = View { motion: Motion::default(), ..view.clone() };
        let moved = still.world_from_camera.translation.vector + motion.linear_m_s * time_s;
        still.world_from_camera.translation = Translation3::from(moved);
        still
            .world_from_camera
            .append_rotation_wrt_center_mut(&nalgebra::UnitQuaternion::from_scaled_axis(motion.angular_rad_s * time_s));
        light(&mut renderer, &still).into_iter().zip(&mut mean).for_each(|(light, mean)| *mean += light / f64::from(STILL));
    }
    let off = |(a, b): (&f64, &f64)| (a - b).abs();
    let worst = moving.iter().zip(&mean).map(off).fold(0.0, f64::max);
    let squares: f64 = moving.iter().zip(&mean).map(off).map(|off| off * off).sum();
    (worst, (squares / moving.len() as f64).sqrt())
}

fn driving(speed_m_s: f64) -> Motion {
    Motion { linear_m_s: Vector3::x() * speed_m_s, angular_rad_s: Vector3::zeros() }
}

#[test]
fn seams_that_pass_by_are_the_mean_of_where_they_were() {
    let look = Look { seam_m: 2e-3, ..Look::matt(0.5) };
    for speed_m_s in [0.1, 0.5, 2.0] {
        let (worst, rms) = moving_against_still(look, driving(speed_m_s));
        println!("{speed_m_s} m/s: worst {worst:.3} DN, RMS {rms:.4} DN");
        // A frame's rounding is up to 0.03 DN. Where a seam meets the edge of two walls, a pixel has the seam of the wall that its
        // middle sees.
        assert!(worst < 1.0 && rms < 0.02, "{speed_m_s} m/s: {worst} and {rms}");
    }
}

#[test]
fn spangles_that_pass_by_are_the_mean_of_where_they_were() {
    let look = Look { spangle: 0.15, spangle_m: 0.008, ..Look::matt(0.5) };
    // Up to three spangles.
    for speed_m_s in [0.1, 0.5, 2.0, 6.0] {
        let (worst, rms) = moving_against_still(look, driving(speed_m_s));
        println!("{speed_m_s} m/s: worst {worst:.3} DN, RMS {rms:.4} DN");
        // Of a contrast of 12 DN near the camera, where Gauss' rule crosses a node, at which the noise's second derivative jumps.
        assert!(worst < 1.0 && rms < 0.1, "{speed_m_s} m/s: {worst} and {rms}");
    }
}
