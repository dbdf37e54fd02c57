//! Times frames of the `wide` rig in a straight duct: minimum, median and first frame, in milliseconds.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{LOOKS, base_at, duct, straight, view, wide};
use ductloop_sensor::WgpuRenderer;
use ductloop_sensor::optics::Optics;
use ductloop_sensor::renderer::Renderer;

fn main() {
    let gpu = common::gpu().expect("an adapter");
    let rig = wide();
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    let mut view = view(&rig, &base_at(1.5, 0.0, 0.0));
    let mut image = vec![0_u8; rig.camera.width_px * rig.camera.height_px];
    for noise in [true, false] {
        let optics = Optics { noise, ..Optics::default() };
        let opened = Instant::now();
        let mut renderer = WgpuRenderer::new(gpu, &network, &rig, &optics, &LOOKS, 1).expect("the rig and the optics are sound");
        renderer.render(&view, image.as_mut_slice().into()).expect("the camera is in the duct");
        let first_ms = opened.elapsed().as_secs_f64() * 1e3;
        let mut times_ms: Vec<f64> = (0..300)
            .map(|frame| {
                view.frame = frame;
                let start = Instant::now();
                renderer.render(&view, image.as_mut_slice().into()).expect("the camera is in the duct");
                start.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times_ms.sort_by(f64::total_cmp);
        println!("noise {noise}: first {first_ms:.0} ms, minimum {:.2}, median {:.2}", times_ms[0], times_ms[150]);
    }
}
