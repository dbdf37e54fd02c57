//! What a frame of each rig costs, read-back included.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{LOOKS, base_at, duct, elbow, incra1, straight, view, wide};
use criterion::{Criterion, criterion_group, criterion_main};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_sensor::optics::Optics;
use ductloop_sensor::renderer::Renderer;
use ductloop_sensor::{Transform, WgpuRenderer};
use nalgebra::Vector3;

fn render(criterion: &mut Criterion) {
    let Some(gpu) = common::gpu() else { return };
    let plain = duct(&[straight(6.0, 0.5, 0.3)]);
    let mut boxes = plain.clone();
    for i in 0..8 {
        let stand = Transform::translation(2.2 + 0.3 * f64::from(i), if i % 2 == 0 { 0.15 } else { -0.15 }, 0.0);
        boxes.add_solid(&Solid::cuboid(&stand, Vector3::new(0.05, 0.05, 0.2), SurfaceId(0)));
    }
    let bend = duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    // Cost must not grow with the network: the same view, 1000 fittings around it.
    let long = duct(&vec![straight(1.0, 0.5, 0.3); 1000]);
    let cases = [
        ("wide/1000 fittings", wide(), &long, 501.5),
        ("wide/straight", wide(), &plain, 1.5),
        ("wide/8 boxes", wide(), &boxes, 1.5),
        ("wide/elbow", wide(), &bend, 2.0),
        ("incra1/straight", incra1(), &plain, 1.5),
    ];
    for (name, rig, network, x) in cases {
        let mut renderer =
            WgpuRenderer::new(gpu, network, &rig, &Optics::default(), &LOOKS, 1).expect("the rig and the optics are sound");
        let mut image = vec![0_u8; rig.camera.width_px * rig.camera.height_px];
        let mut view = view(&rig, &base_at(x, 0.0, 0.0));
        criterion.bench_function(name, |b| {
            b.iter(|| {
                view.frame += 1;
                renderer.render(&view, image.as_mut_slice().into()).expect("the camera is in the duct");
            });
        });
    }
}

criterion_group!(benches, render);
criterion_main!(benches);
