//! Where stripes are, all over the field, through a distorting lens too: centroids of the CPU renderer's images against the exact
//! truth, which casts rays and shares nothing with the renderer but the duct.
//!
//! The stripe is thin (0.4 mm), the wall matt and the lens even: a thick stripe's centroid is where its light is, and that is not
//! its middle where the wall is met at a grazing angle, shines, or lies where the lens falls off. That share is printed for the
//! rigs' own stripes.

mod common;

use common::{base_at, duct, elbow, incra1, straight, view, wide};
use ductloop_duct::network::Network;
use ductloop_nav::rig::{Distortion, LineWidth, Rig};
use ductloop_sensor::optics::{Bits, Ccd, Lens, Optics};
use ductloop_sensor::renderer::{Renderer, View};
use ductloop_sensor::surface::Look;
use ductloop_sensor::truth::{CentrePoint, SceneTruth};
use ductloop_sensor::{CpuRenderer, Transform};

/// Half the window of a centroid, in pixels: a stripe as thin as here is nothing at its ends.
const HALF: i64 = 7;

/// (squares summed, largest, number) of the centroids' differences from the truth.
fn differences(rig: &Rig, network: &Network, base: &Transform, half: i64) -> (f64, f64, usize) {
    differences_of(rig, network, &view(rig, base), half)
}

fn differences_of(rig: &Rig, network: &Network, view: &View, half: i64) -> (f64, f64, usize) {
    let ccd = Ccd { black_level_dn: 0.0, bits: Bits::Twelve, ..Ccd::default() };
    let lens = Lens { vignetting: false, ..Lens::default() };
    let optics = Optics { noise: false, headlamp_peak_dn: 0.0, stripe_peak_dn: 600.0, lens, ccd, ..Optics::default() };
    let mut renderer = CpuRenderer::new(network, rig, &optics, &[Look::matt(0.5); 7], 1, 1).expect("a sound scene");
    let (width, height) = (rig.camera.width_px as i64, rig.camera.height_px as i64);
    let mut image = vec![0_u16; (width * height) as usize];
    renderer.render(view, image.as_mut_slice().into()).expect("a frame");
    let truth = SceneTruth::new(network, rig).of(&view.world_from_camera).expect("a camera in the duct");
    let crowded = |point: &CentrePoint, down: bool| {
        truth.centres.iter().any(|other| {
            let (line, along) = if down {
                (other.u_px - point.u_px, other.v_px - point.v_px)
            } else {
                (other.v_px - point.v_px, other.u_px - point.u_px)
            };
            other.laser != point.laser && line.abs() < 1.0 && along.abs() < 2.5 * half as f64
        })
    };
    let (mut squares, mut largest, mut count) = (0.0, 0.0_f64, 0);
    for point in &truth.centres {
        let down = (point.u_px - point.u_px.round()).abs() < 1e-6;
        let (line, along, length) = if down { (point.u_px, point.v_px, height) } else { (point.v_px, point.u_px, width) };
        let (line, middle) = (line.round() as i64, along.round() as i64);
        let at = |line: i64, k: i64| f64::from(image[if down { k * width + line } else { line * width + k } as usize]);
        let lines = if down { width } else { height };
        if middle < half || middle + half >= length || line < 3 || line + 3 >= lines || crowded(point, down) {
            continue;
        }
        let sum_of = |line: i64| (middle - half..=middle + half).map(|k| at(line, k)).sum::<f64>();
        let light = sum_of(line);
        // Faint, saturated, or near an end of the lit piece, where the lines beside it have another light.
        let peak = (middle - half..=middle + half).map(|k| at(line, k)).fold(0.0, f64::max);
        let uneven = (-3..=3).any(|off| (sum_of(line + off) / light - 1.0).abs() > 0.05);
        if !(300.0..=4090.0).contains(&peak) || uneven {
            continue;
        }
        let centroid = (middle - half..=middle + half).map(|k| at(line, k) * (k - middle) as f64).sum::<f64>() / light;
        let off = middle as f64 + centroid - along;
        squares += off * off;
        largest = largest.max(off.abs());
        count += 1;
    }
    (squares, largest, count)
}

#[test]
fn stripes_are_where_the_truth_says_all_over_the_field() {
    let thin = |rig: Rig| Rig { line: LineWidth { width_m: 4e-4, growth_rad: 5e-4 }, ..rig };
    let bent = |mut rig: Rig, k1: f64| {
        rig.camera.distortion = Distortion { k1, k2: -0.1 * k1, p1: 8e-4, p2: -5e-4, k3: 0.0 };
        rig
    };
    let plain = duct(&[straight(6.0, 0.5, 0.3)]);
    let narrow = duct(&[straight(3.0, 0.35, 0.25)]);
    let bend = duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    let rigs = [
        ("wide", wide()),
        ("wide, barrel", bent(wide(), -0.2)),
        ("wide, pincushion", bent(wide(), 0.08)),
        ("incra1", incra1()),
        ("incra1, barrel", bent(incra1(), -0.3)),
    ];
    for (name, rig) in rigs {
        let (mut squares, mut largest, mut count) = (0.0, 0.0_f64, 0);
        for (network, x, y, heading) in [
            (&plain, 1.5, 0.0, 0.0),
            (&plain, 1.5, 0.08, 7.0),
            (&plain, 5.3, -0.05, -9.0),
            (&narrow, 1.0, 0.02, 3.0),
            (&narrow, 2.4, 0.0, -5.0),
            (&bend, 1.8, 0.0, 0.0),
            (&bend, 2.3, 0.03, 4.0),
        ] {
            let found = differences(&thin(rig.clone()), network, &base_at(x, y, heading), HALF);
            squares += found.0;
            largest = largest.max(found.1);
            count += found.2;
        }
        let rms = (squares / count.max(1) as f64).sqrt();
        println!("{name}: centres {rms:.4} px RMS, {largest:.3} px at most, of {count}");
        assert!(count > 1000, "{name}: only {count} places were compared");
        assert!(rms < 0.01, "{name}: {rms} px RMS");
    }
    for (name, rig, half) in [("wide", wide(), 12), ("incra1", incra1(), 30)] {
        let (squares, largest, count) = differences(&rig, &plain, &base_at(1.5, 0.0, 0.0), half);
        println!(
            "{name}, its own stripe: centres {:.4} px RMS, {largest:.3} px at most, of {count}",
            (squares / count as f64).sqrt()
        );
    }
}

#[test]
fn stripes_are_where_the_truth_says_in_every_fitting() {
    let (mut squares, mut largest, mut count) = (0.0, 0.0_f64, 0);
    for scene in common::scenes::fittings() {
        let rig = Rig { line: LineWidth { width_m: 4e-4, growth_rad: 5e-4 }, ..scene.rig };
        let found = differences_of(&rig, &scene.network, &scene.view, HALF);
        println!(
            "{:20} {:.4} px RMS, {:.3} px at most, of {}",
            scene.name,
            (found.0 / found.2.max(1) as f64).sqrt(),
            found.1,
            found.2
        );
        squares += found.0;
        largest = largest.max(found.1);
        count += found.2;
    }
    let rms = (squares / count.max(1) as f64).sqrt();
    println!("centres {rms:.4} px RMS, {largest:.3} px at most, of {count}");
    assert!(count > 5000, "only {count} places were compared");
    assert!(rms < 0.01, "{rms} px RMS");
}
