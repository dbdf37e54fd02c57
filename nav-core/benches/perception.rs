//! What reading a frame costs, as a whole: both pipelines, and the extractor that knows no rig.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{Pose, image, wide};
use criterion::{Criterion, criterion_group, criterion_main};
use ductloop_nav::messages::Frame;
use ductloop_nav::perception::Perception;
use ductloop_nav::perception::paper::{PaperParams, PaperPerception};
use ductloop_nav::perception::ridge::{Ridge, RidgeParams};
use ductloop_nav::perception::robust::{RobustParams, RobustPerception};
use ductloop_nav::perception::scan::Across;

const POSE: Pose = Pose { lateral_m: 0.02, heading_rad: 0.03, width_m: 0.5 };

fn pipelines(criterion: &mut Criterion) {
    let rig = wide();
    let pixels = image(&rig, &POSE, [true; 2]);
    let frame = Frame::grey8(640, 480, &pixels);
    let paper = |hough_r_px, hough_deg: f64| {
        let params = PaperParams { hough_r_px, hough_theta_rad: hough_deg.to_radians(), ..PaperParams::default() };
        Box::new(PaperPerception::new(rig.clone(), params)) as Box<dyn Perception>
    };
    let robust = Box::new(RobustPerception::new(rig.clone(), RobustParams::default())) as Box<dyn Perception>;
    let mut group = criterion.benchmark_group("perceive");
    for (name, mut perception) in [("robust", robust), ("paper", paper(1.0, 1.0)), ("paper, fine Hough", paper(0.5, 0.25))] {
        group.bench_function(name, |b| b.iter(|| perception.perceive(black_box(&frame), rig.mount.rest)));
    }
    group.finish();
}

fn ridge(criterion: &mut Criterion) {
    let pixels = image(&wide(), &POSE, [true; 2]);
    let frame = Frame::grey8(640, 480, &pixels);
    let mut group = criterion.benchmark_group("ridge");
    for (name, across) in [("stripes along u", Some(Across::V)), ("either way", None)] {
        let mut ridge = Ridge::new(RidgeParams { across, ..RidgeParams::default() });
        group.bench_function(name, |b| b.iter(|| ridge.extract(black_box(&frame), None).len()));
    }
    group.finish();
}

criterion_group!(benches, pipelines, ridge);
criterion_main!(benches);
