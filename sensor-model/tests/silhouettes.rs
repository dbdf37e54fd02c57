//! Edges between regions: where they are between pixels, by the light of the columns that they cross, against geometry.

mod common;

use common::{duct, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::network::{End, Network};
use ductloop_nav::rig::{Distortion, Rig};
use ductloop_sensor::optics::{Bits, Ccd, Lens, Optics};
use ductloop_sensor::renderer::{ImageMut, MAX_LASERS, Renderer, View};
use ductloop_sensor::surface::Look;
use ductloop_sensor::{CpuRenderer, Transform};
use nalgebra::{Point3, Vector3};

const BITS12: f64 = 4095.0 / 255.0;

/// Headlamp alone, nothing random, no fall-off toward the corners.
fn lamp() -> Optics {
    Optics {
        noise: false,
        headlamp_peak_dn: 200.0,
        lens: Lens { vignetting: false, ..Lens::default() },
        ccd: Ccd { bits: Bits::Twelve, ..Ccd::default() },
        ..Optics::default()
    }
}

/// The renderers to be tested.
fn renderers(network: &Network, rig: &Rig, optics: &Optics, looks: &[Look]) -> Vec<(&'static str, Box<dyn Renderer>)> {
    let cpu = CpuRenderer::new(network, rig, optics, looks, 1, 1).expect("a renderer");
    #[allow(unused_mut)] // without wgpu there is one
    let mut all: Vec<(&'static str, Box<dyn Renderer>)> = vec![("cpu", Box::new(cpu))];
    #[cfg(feature = "wgpu")]
    if let Some(gpu) = common::gpu() {
        let wgpu = ductloop_sensor::WgpuRenderer::new(gpu, network, rig, optics, looks, 1).expect("a renderer");
        all.push(("wgpu", Box::new(wgpu)));
    }
    all
}

/// Light above black, in DN of 8 bits.
fn light(renderer: &mut dyn Renderer, view: &View) -> Vec<f64> {
    let mut image = vec![0_u16; 640 * 480];
    renderer.render(view, ImageMut::Grey16(&mut image)).expect("an image");
    // Black is 8, of which twelve bits make a whole number.
    let black = (8.0 * BITS12).round();
    image.into_iter().map(|value| (f64::from(value) - black) / BITS12).collect()
}

/// A camera at (x, y, z) that looks along the duct, with the lasers off.
fn at(rig: &Rig, x: f64, y: f64, z: f64) -> View {
    let mut view = View { laser_power: [0.0; MAX_LASERS], ..view(rig, &Transform::identity()) };
    view.world_from_camera.translation = Vector3::new(x, y, z).into();
    view
}

/// Where in a row the step between two plateaus is: the light between them shared out between the levels beside it.
fn step(row: &[f64], from: usize, to: usize) -> f64 {
    // Straight lines through both sides, carried on to the step, since the lamp's light slopes.
    let level =
        |near: usize, far: usize, at: f64| row[near] + (row[far] - row[near]) * (at - near as f64) / (far as f64 - near as f64);
    let sum: f64 = row[from..=to].iter().sum();
    let mut edge = (from + to) as f64 / 2.0;
    for _ in 0..8 {
        // Pixels on the left of the edge have the left level, the others the right one.
        let mean = |a: f64, b: f64, near: usize, far: usize| level(near, far, (a + b) / 2.0);
        let (left, right) = (mean(from as f64, edge, from, from - 6), mean(edge, to as f64, to, to + 6));
        let whole = (to - from + 1) as f64;
        let share = (sum - whole * right) / (left - right);
        edge = from as f64 - 0.5 + share;
    }
    edge
}

/// A box stands still while the camera moves in steps of a tenth of a pixel: its edge moves with it, not by whole pixels.
#[test]
fn the_edge_of_a_body_moves_with_it_between_pixels() {
    let rig = wide();
    let mut network = duct(&[straight(6.0, 0.5, 0.3)]);
    network.add_solid(&Solid::cuboid(&Transform::translation(1.7, 0.0, 0.0), Vector3::new(0.05, 0.1, 0.2), SurfaceId(1)));
    for (name, mut renderer) in renderers(&network, &rig, &lamp(), &[Look::matt(0.5), Look::matt(0.8)]) {
        let mut worst = 0.0_f64;
        for i in 0..21 {
            let y = 2e-4 * f64::from(i);
            let image = light(renderer.as_mut(), &at(&rig, 1.2, y, 0.1));
            // The front face is at x = 1.675, its edges at y = -0.05 and 0.05; the right one is seen to the right.
            let expected = 319.5 + 378.4 * (y + 0.05) / (1.675 - 1.2);
            let row = &image[200 * 640..201 * 640];
            let middle = expected.round() as usize;
            let found = step(row, middle - 5, middle + 5);
            worst = worst.max((found - expected).abs());
        }
        println!("{name}: within {worst:.4} px");
        assert!(worst < 0.02, "{name}: {worst} px");
    }
}

/// The pixels of an open end carry its light by their area, whatever way its edges run.
#[test]
fn an_open_end_has_the_light_of_its_area() {
    let rig = wide();
    let optics = Optics { headlamp_peak_dn: 0.0, ambient_dn: 100.0, ..lamp() };
    let straights = [straight(3.0, 0.5, 0.3)];
    let network = Network::from_run(&straights, End::Open, End::Open).expect("a duct");
    // Black walls send nothing on.
    for (name, mut renderer) in renderers(&network, &rig, &optics, &[Look::matt(0.0)]) {
        for i in 0..12 {
            let mut view = at(&rig, 1.5 + 0.003 * f64::from(i), 0.01, 0.12);
            // Turned about the line of sight too.
            let roll = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.11 * f64::from(i));
            view.world_from_camera.rotation *= roll;
            let image = light(renderer.as_mut(), &view);
            let sum: f64 = image.iter().sum();
            let corners = [[-0.25, 0.0], [0.25, 0.0], [0.25, 0.3], [-0.25, 0.3]].map(|[y, z]| {
                let point = view.world_from_camera.inverse_transform_point(&Point3::new(3.0, y, z));
                [378.4 * point.x / point.z, 378.4 * point.y / point.z]
            });
            let area =
                (0..4).map(|i| (corners[i], corners[(i + 1) % 4])).map(|([x, y], [u, v])| x * v - u * y).sum::<f64>().abs() / 2.0;
            // Half a pixel's error all along its rim, 680 px, would be 340 px^2.
            assert!((sum / 100.0 - area).abs() < 3.0, "{name}, {i}: {} px^2 for {area}", sum / 100.0);
        }
    }
}

/// The same behind a lens that bends the edges, and out of focus.
#[test]
fn bent_and_blurred_edges_keep_the_light() {
    let mut rig = wide();
    rig.camera.distortion = Distortion { k1: -0.2, k2: 0.03, p1: 5e-4, p2: -5e-4, k3: 0.0 };
    let lens = Lens { aperture_m: 1e-3, focus_m: 0.5, vignetting: false, ..Lens::default() };
    let straights = [straight(3.0, 0.5, 0.3)];
    let network = Network::from_run(&straights, End::Open, End::Open).expect("a duct");
    for lens in [Lens { vignetting: false, ..Lens::default() }, lens] {
        let optics = Optics { headlamp_peak_dn: 0.0, ambient_dn: 100.0, lens, ..lamp() };
        for (name, mut renderer) in renderers(&network, &rig, &optics, &[Look::matt(0.0)]) {
            let mut sums = Vec::new();
            for i in 0..8 {
                // Aside by a tenth of a pixel at a time: the end's outline keeps its size but for the lens' bending.
                let image = light(renderer.as_mut(), &at(&rig, 1.5, 4e-4 * f64::from(i), 0.15));
                sums.push(image.iter().sum::<f64>() / 100.0);
            }
            let (least, most) = (sums.iter().copied().fold(f64::INFINITY, f64::min), sums.iter().copied().fold(0.0, f64::max));
            println!("{name}: {least:.2} to {most:.2} px^2");
            // wgpu draws polygons larger by 1/128 px, so that of 400 pixels along the rim some three see what is beside their centre.
            assert!(most - least < 8.0, "{name}: {sums:?}");
        }
    }
}
