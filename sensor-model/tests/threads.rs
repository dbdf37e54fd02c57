//! One device, several renderers, each on a thread of its own: what a program that runs several scenarios at once does.

mod common;

use common::{base_at, duct, gpu, image, straight, view, wide};
use ductloop_sensor::WgpuRenderer;
use ductloop_sensor::optics::Optics;
use ductloop_sensor::surface::Look;

#[test]
fn renderers_of_one_device_do_not_disturb_each_other() {
    let Some(gpu) = gpu() else { return };
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    let frames = |lateral_m: f64| {
        let (rig, looks) = (wide(), [Look::matt(0.5)]);
        let mut renderer = WgpuRenderer::new(gpu, &network, &rig, &Optics::default(), &looks, 1).expect("a renderer");
        let mut view = view(&rig, &base_at(1.5, lateral_m, 0.0));
        (0..60)
            .map(|frame| {
                view.frame = frame;
                image(&mut renderer, &rig, &view)
            })
            .collect::<Vec<_>>()
    };
    let offsets = [0.0, 0.03, -0.05];
    let alone: Vec<_> = offsets.iter().map(|y| frames(*y)).collect();
    let together: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = offsets.iter().map(|y| scope.spawn(|| frames(*y))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert!(alone == together, "an image depends on what other threads render");
}
