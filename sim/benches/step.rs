//! What a physics tick costs, in a straight duct and in networks of many fittings, and what it costs to make those.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use ductloop_duct::Transform;
use ductloop_duct::cell::SurfaceId;
use ductloop_duct::fitting::{Fitting, Shape};
use ductloop_duct::network::{End, Network};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, RobotSpec, World};
use nalgebra::Translation3;

fn fitting(shape: Shape) -> Fitting {
    Fitting { shape, width_m: 0.5, height_m: 0.3, surface: SurfaceId(0) }
}

fn straight() -> Vec<Fitting> {
    vec![fitting(Shape::Straight { length_m: 1000.0 })]
}

/// 10 000 short ducts, one after the other.
fn many() -> Vec<Fitting> {
    vec![fitting(Shape::Straight { length_m: 0.5 }); 10_000]
}

/// Zigzags of radius elbows and straights, a cell or a gore every few centimetres: 100 fittings, 650 cells.
fn winding() -> Vec<Fitting> {
    let elbow = |turn: f64| fitting(Shape::RadiusElbow { angle_rad: turn * std::f64::consts::FRAC_PI_2, throat_radius_m: 0.375 });
    let turns = [1.0, -1.0, -1.0, 1.0].into_iter().cycle();
    turns.take(50).flat_map(|turn| [fitting(Shape::Straight { length_m: 1.0 }), elbow(turn)]).collect()
}

/// A staircase of five fittings each: a straight, a slope up or down, an elbow to the left, a straight, an elbow to the right.
fn stairs(times: usize) -> Vec<Fitting> {
    let elbow = |angle_rad: f64| fitting(Shape::RadiusElbow { angle_rad, throat_radius_m: 0.375 });
    let quarter = std::f64::consts::FRAC_PI_2;
    let straight = fitting(Shape::Straight { length_m: 1.5 });
    let slope = |i: usize| fitting(Shape::Slope { length_m: 1.0, angle_rad: if i.is_multiple_of(2) { 0.1 } else { -0.1 } });
    (0..times).flat_map(|i| [straight, slope(i), elbow(quarter), straight, elbow(-quarter)]).collect()
}

/// What a tick costs where the floors are not one plane, in a network of 5 fittings and at the same place in the middle of one of 500.
/// The robot turns slowly on the spot where the slope begins, on both planes.
fn growth(c: &mut Criterion) {
    for (name, times) in [("5 fittings", 1), ("500 fittings", 100)] {
        let network = Network::from_run(&stairs(times), End::Cap, End::Cap).expect("a duct");
        let first = times / 2 / 2 * 2 * 5;
        let start = network.world_from_fitting[first] * Translation3::new(1.45, 0.0, 0.0);
        let ground = Ground::uniform(0.7);
        let mut world =
            World::new(&network, &RobotSpec::incra1(), &ground, &start, MountAngles::default(), 1200).expect("a world");
        c.bench_function(&format!("step/stairs of {name}"), |b| b.iter(|| world.step(Sides { left: -0.06, right: 0.06 })));
        c.bench_function(&format!("truth/stairs of {name}"), |b| b.iter(|| world.truth()));
    }
}

fn step(c: &mut Criterion) {
    // In the winding duct the robot stands and turns slowly on the spot, so that it stays there however long it is measured.
    for (name, fittings, duty) in [
        ("straight", straight(), Sides { left: 0.2, right: 0.2 }),
        ("10000 fittings", many(), Sides { left: 0.2, right: 0.2 }),
        ("winding", winding(), Sides { left: -0.06, right: 0.06 }),
    ] {
        let network = Network::from_run(&fittings, End::Cap, End::Cap).expect("a duct");
        let start = Transform::from_parts(Translation3::new(0.5, 0.0, 0.0), nalgebra::UnitQuaternion::identity());
        let make = || {
            let ground = Ground::uniform(0.7);
            World::new(&network, &RobotSpec::incra1(), &ground, &start, MountAngles::default(), 1200).expect("a world")
        };
        c.bench_function(&format!("network/{name}"), |b| b.iter(|| Network::from_run(&fittings, End::Cap, End::Cap)));
        c.bench_function(&format!("world/{name}"), |b| b.iter(make));
        let mut world = make();
        c.bench_function(&format!("step/{name}"), |b| b.iter(|| world.step(duty)));
        c.bench_function(&format!("truth/{name}"), |b| b.iter(|| world.truth()));
    }
}

criterion_group!(benches, step, growth);
criterion_main!(benches);
