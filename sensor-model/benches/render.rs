//! What a frame of each rig costs, on the CPU with one thread and, read-back included, on wgpu.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{LOOKS, base_at, duct, elbow, incra1, straight, view, wide};
use criterion::{Criterion, criterion_group, criterion_main};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::fitting::{Fitting, Shape};
use ductloop_duct::network::Network;
use ductloop_nav::rig::Rig;
use ductloop_sensor::optics::{Lens, Optics};
use ductloop_sensor::renderer::{Motion, Renderer, View};
use ductloop_sensor::surface::Look;
use ductloop_sensor::{CpuRenderer, Transform};
use nalgebra::Vector3;

/// Rough zinc under dust.
const ZINC: Look = Look { albedo: 0.35, specular: 0.2, roughness: 0.45, ..Look::matt(0.35) };

struct Case {
    name: &'static str,
    rig: Rig,
    network: Network,
    optics: Optics,
    looks: [Look; 2],
    view: View,
}

/// A staircase of five fittings each: a straight, a slope up or down, an elbow to the left, a straight, an elbow to the right.
fn stairs(times: usize) -> Network {
    let slope = |i: usize| {
        let angle_rad = if i.is_multiple_of(2) { 0.1 } else { -0.1 };
        Fitting { shape: Shape::Slope { length_m: 1.0, angle_rad }, ..straight(1.0, 0.5, 0.3) }
    };
    let (ahead, turn) = (straight(1.5, 0.5, 0.3), |angle_deg| elbow(angle_deg, 0.375, 0.5, 0.3));
    let all: Vec<Fitting> = (0..times).flat_map(|i| [ahead, slope(i), turn(90.0), ahead, turn(-90.0)]).collect();
    duct(&all)
}

fn cases() -> Vec<Case> {
    let plain = duct(&[straight(6.0, 0.5, 0.3)]);
    let mut boxes = plain.clone();
    for i in 0..8 {
        let stand = Transform::translation(2.2 + 0.3 * f64::from(i), if i % 2 == 0 { 0.15 } else { -0.15 }, 0.0);
        boxes.add_solid(&Solid::cuboid(&stand, Vector3::new(0.05, 0.05, 0.2), SurfaceId(0)));
    }
    let bend = duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    // Cost must not grow with the network: the same view, 1000 fittings around it.
    let long = duct(&vec![straight(1.0, 0.5, 0.3); 1000]);
    // As far as elbows let one see, the two are the same: the first five of 5 fittings, and five in the middle of 500.
    let (few, many) = (stairs(1), stairs(100));
    let on_stairs = |name, network: &Network, first: usize| {
        let rig = wide();
        let view = view(&rig, &(network.world_from_fitting[first] * base_at(0.8, 0.0, 0.0)));
        Case { name, rig, network: network.clone(), optics: Optics::default(), looks: LOOKS, view }
    };
    let case = |name, rig: Rig, network: &Network, x: f64| {
        let view = view(&rig, &base_at(x, 0.0, 0.0));
        Case { name, rig, network: network.clone(), optics: Optics::default(), looks: LOOKS, view }
    };
    let full = Optics { ghosts: true, bounce: true, ..Optics::default() };
    let mut moving = case("wide/straight, turning", wide(), &plain, 1.5);
    moving.view.motion = Motion { linear_m_s: Vector3::new(0.3, 0.0, 0.0), angular_rad_s: Vector3::new(0.0, 0.0, 1.0) };
    let lens = Lens { aperture_m: 1e-3, ..Lens::default() };
    vec![
        case("wide/straight", wide(), &plain, 1.5),
        Case { looks: [ZINC; 2], ..case("wide/straight, zinc", wide(), &plain, 1.5) },
        Case { looks: [ZINC; 2], optics: full, ..case("wide/straight, zinc, ghosts and bounce", wide(), &plain, 1.5) },
        Case { optics: Optics { lens, ..Optics::default() }, ..case("wide/straight, out of focus", wide(), &plain, 1.5) },
        moving,
        case("wide/1000 fittings", wide(), &long, 501.5),
        on_stairs("wide/stairs of 5 fittings", &few, 0),
        on_stairs("wide/stairs of 500 fittings", &many, 250),
        case("wide/8 boxes", wide(), &boxes, 1.5),
        case("wide/elbow", wide(), &bend, 2.0),
        case("incra1/straight", incra1(), &plain, 1.5),
    ]
}

fn measure(criterion: &mut Criterion, engine: &str, make: impl Fn(&Case) -> Box<dyn Renderer>) {
    for case in cases() {
        let mut renderer = make(&case);
        let mut image = vec![0_u8; case.rig.camera.width_px * case.rig.camera.height_px];
        let mut view = case.view.clone();
        criterion.bench_function(&format!("{engine}/{}", case.name), |b| {
            b.iter(|| {
                view.frame += 1;
                renderer.render(&view, image.as_mut_slice().into()).expect("the camera is in the duct");
            });
        });
    }
}

fn cpu(criterion: &mut Criterion) {
    measure(criterion, "cpu", |case| {
        let renderer = CpuRenderer::new(&case.network, &case.rig, &case.optics, &case.looks, 1, 1);
        Box::new(renderer.expect("the rig and the optics are sound"))
    });
}

#[cfg(feature = "wgpu")]
fn wgpu(criterion: &mut Criterion) {
    let Some(gpu) = common::gpu() else { return };
    measure(criterion, "wgpu", |case| {
        let renderer = ductloop_sensor::WgpuRenderer::new(gpu, &case.network, &case.rig, &case.optics, &case.looks, 1);
        Box::new(renderer.expect("the rig and the optics are sound"))
    });
}

#[cfg(feature = "wgpu")]
criterion_group!(benches, cpu, wgpu);
#[cfg(not(feature = "wgpu"))]
criterion_group!(benches, cpu);
criterion_main!(benches);
