//! What reading a frame costs, as a whole.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{Pose, image, wide};
use criterion::{Criterion, criterion_group, criterion_main};
use ductloop_nav::messages::Frame;
use ductloop_nav::perception::Perception;
use ductloop_nav::perception::paper::{PaperParams, PaperPerception};

fn paper(criterion: &mut Criterion) {
    let rig = wide();
    let mut group = criterion.benchmark_group("perceive");
    for (name, hough_r_px, hough_deg) in [("paper", 1.0, 1.0_f64), ("paper, fine Hough", 0.5, 0.25)] {
        let pixels = image(&rig, &Pose { lateral_m: 0.02, heading_rad: 0.03, width_m: 0.5 }, [true; 2]);
        let params = PaperParams { hough_r_px, hough_theta_rad: hough_deg.to_radians(), ..PaperParams::default() };
        let mut perception = PaperPerception::new(rig.clone(), params);
        let frame = Frame::grey8(640, 480, &pixels);
        group.bench_function(name, |b| b.iter(|| perception.perceive(black_box(&frame), rig.mount.rest)));
    }
    group.finish();
}

criterion_group!(benches, paper);
criterion_main!(benches);
