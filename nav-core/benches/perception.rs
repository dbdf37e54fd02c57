//! What reading a frame costs, as a whole.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{Pose, image, wide};
use criterion::{Criterion, criterion_group, criterion_main};
use ductloop_nav::messages::Frame;
use ductloop_nav::perception::Perception;
use ductloop_nav::perception::paper::{PaperParams, PaperPerception};
use ductloop_nav::perception::robust::{RobustParams, RobustPerception};

fn perceive(criterion: &mut Criterion) {
    let rig = wide();
    let pixels = image(&rig, &Pose { lateral_m: 0.02, heading_rad: 0.03, width_m: 0.5 }, [true; 2]);
    let frame = Frame::grey8(640, 480, &pixels);
    let mut group = criterion.benchmark_group("perceive");
    let mut robust = RobustPerception::new(rig.clone(), RobustParams::default());
    group.bench_function("robust", |b| b.iter(|| robust.perceive(black_box(&frame), rig.mount.rest)));
    for (name, hough_r_px, hough_deg) in [("paper", 1.0, 1.0_f64), ("paper, fine Hough", 0.5, 0.25)] {
        let params = PaperParams { hough_r_px, hough_theta_rad: hough_deg.to_radians(), ..PaperParams::default() };
        let mut perception = PaperPerception::new(rig.clone(), params);
        group.bench_function(name, |b| b.iter(|| perception.perceive(black_box(&frame), rig.mount.rest)));
    }
    group.finish();
}

criterion_group!(benches, perceive);
criterion_main!(benches);
