//! The paper's chain from image to errors, on images that plain geometry makes.

mod common;

use common::{Pose, image, wide};
use ductloop_nav::messages::Frame;
use ductloop_nav::perception::paper::{LineFit, PaperParams, PaperPerception, PlaneFit};
use ductloop_nav::perception::{Measurement, Perception, Wall};
use ductloop_nav::rig::Rig;
use proptest::prelude::*;

fn measure(rig: &Rig, params: PaperParams, pixels: &[u8]) -> (Measurement, PaperPerception) {
    let mut perception = PaperPerception::new(rig.clone(), params);
    let frame = Frame::grey8(rig.camera.width_px, rig.camera.height_px, pixels);
    let measured = perception.perceive(&frame, rig.mount.rest);
    (measured, perception)
}

const POSES: [Pose; 6] = [
    Pose { lateral_m: 0.0, heading_rad: 0.0, width_m: 0.5 },
    Pose { lateral_m: 0.06, heading_rad: 0.105, width_m: 0.5 },
    Pose { lateral_m: -0.06, heading_rad: -0.105, width_m: 0.5 },
    Pose { lateral_m: 0.05, heading_rad: -0.08, width_m: 0.5 },
    Pose { lateral_m: 0.01, heading_rad: 0.03, width_m: 0.35 },
    Pose { lateral_m: 0.1, heading_rad: 0.05, width_m: 0.8 },
];

#[test]
fn both_walls_give_the_pose_and_the_width() {
    let rig = wide();
    for pose in &POSES {
        let (measured, _) = measure(&rig, PaperParams::default(), &image(&rig, pose, [true; 2]));
        let [lateral, heading, width] = [measured.lateral_m, measured.heading_rad, measured.width_m].map(Option::unwrap);
        // Without noise, rounding to whole DN and the neighbouring stripe where the two cross are what remains. Two millimetres
        // and a fifth of a degree are less than a tenth of a pixel across a stripe at the walls' far end.
        assert!((lateral - pose.lateral_m).abs() < 2e-3, "{pose:?}: {lateral}");
        assert!((heading - pose.heading_rad).abs() < 3.5e-3, "{pose:?}: {heading}");
        assert!((width - pose.width_m).abs() < 4e-3, "{pose:?}: {width}");
    }
}

#[test]
fn every_assigned_line_lies_on_its_own_side_of_the_image() {
    let rig = wide();
    let (_, perception) = measure(&rig, PaperParams::default(), &image(&rig, &POSES[0], [true; 2]));
    let assigned: Vec<_> = perception.stages().lines.iter().filter_map(|line| Some((line.assigned?, line.ends_px))).collect();
    assert_eq!(assigned.len(), 4, "{:?}", perception.stages().lines);
    for ((_, wall), ends) in assigned {
        assert!(ends.iter().all(|[u, _]| (*u < 320.0) == (wall == Wall::Left)), "{wall:?}: {ends:?}");
    }
}

#[test]
fn sixteen_bits_say_the_same_as_eight() {
    let rig = wide();
    let pixels = image(&rig, &POSES[1], [true; 2]);
    let (from_8, _) = measure(&rig, PaperParams::default(), &pixels);
    let perceive = |factor: u16, max_dn: u16| {
        let wider: Vec<u16> = pixels.iter().map(|p| factor * u16::from(*p)).collect();
        let frame = Frame::grey16(640, 480, &wider, max_dn);
        PaperPerception::new(rig.clone(), PaperParams::default()).perceive(&frame, rig.mount.rest)
    };
    assert_eq!(perceive(1, 255), from_8);
    // With 17 = 4335/255 levels for one of 8 bits every grey value is a multiple: thresholds keep pace, and so do centroids, up
    // to rounding in the last places of a double.
    let deep = perceive(17, 4335);
    let apart = |a: Option<f64>, b: Option<f64>| (a.expect("seen") - b.expect("seen")).abs();
    assert!(apart(deep.lateral_m, from_8.lateral_m) < 1e-9 && apart(deep.heading_rad, from_8.heading_rad) < 1e-9);
}

#[test]
fn without_both_stripes_no_wall_is_claimed() {
    let rig = wide();
    for lit in [[true, false], [false, true], [false, false]] {
        for pose in &POSES {
            let (measured, _) = measure(&rig, PaperParams::default(), &image(&rig, pose, lit));
            assert_eq!(measured, Measurement::default(), "{pose:?} {lit:?}");
        }
    }
}

/// A plane that is not where the navigator believes it makes two stripes that tell of two different walls: neither is believed.
#[test]
fn stripes_that_contradict_each_other_are_no_wall() {
    let rig = wide();
    for turn_deg in [-2.0_f64, 2.0] {
        let turned = rig.clone().with_plane_turned(0, turn_deg.to_radians());
        let (measured, _) = measure(&rig, PaperParams::default(), &image(&turned, &POSES[0], [true; 2]));
        assert_eq!(measured, Measurement::default(), "{turn_deg} degrees");
    }
}

/// Bright bars that are straight but far thicker, or far thinner, than a stripe can be there are no stripes.
#[test]
fn thickness_tells_a_stripe_from_a_bright_bar() {
    let rig = wide();
    let bar = |thickness: usize| {
        let mut pixels = vec![8u8; 640 * 480];
        for x in 20..300 {
            let top = 300 - x / 4;
            for y in top..top + thickness {
                pixels[y * 640 + x] = 60;
            }
        }
        let open = PaperParams { opening_px: [1, 1], closing_px: [1, 1], ..PaperParams::default() };
        measure(&rig, open, &pixels).1.points().len()
    };
    // At a third of the light's peak a stripe of either laser is 3 to 8 pixels thick over this part of the image.
    assert!(bar(5) > 200, "{}", bar(5));
    for thickness in [1, 20] {
        assert!(bar(thickness) < 20, "{thickness} px: {} points", bar(thickness));
    }
}

/// The paper's own steps: Hough's bins and the cross product. For crossed slits they still steer; coarser by the bins.
#[test]
fn the_papers_own_steps_find_the_walls_within_their_bins() {
    let rig = wide();
    let params = PaperParams { line_fit: LineFit::HoughPeak, plane_fit: PlaneFit::CrossProduct, ..PaperParams::default() };
    for pose in &POSES[..4] {
        let (measured, _) = measure(&rig, params.clone(), &image(&rig, pose, [true; 2]));
        let [lateral, heading] = [measured.lateral_m, measured.heading_rad].map(Option::unwrap);
        // A bin of 1 px and 1 degree turns a stripe by half a degree in the image, which is 1 to 2 degrees of a wall here.
        assert!((lateral - pose.lateral_m).abs() < 0.015, "{pose:?}: {lateral}");
        assert!((heading - pose.heading_rad).abs() < 2.5_f64.to_radians(), "{pose:?}: {heading}");
    }
}

/// Refitting is what makes the chain fine: against the paper's own steps it must win by a factor, over all poses together.
#[test]
fn refitted_lines_and_joint_planes_beat_the_papers_own_steps() {
    let rig = wide();
    let own = PaperParams { line_fit: LineFit::HoughPeak, plane_fit: PlaneFit::CrossProduct, ..PaperParams::default() };
    let heading_rms = |params: &PaperParams| {
        let square = |pose: &Pose| {
            let (measured, _) = measure(&rig, params.clone(), &image(&rig, pose, [true; 2]));
            let error = measured.heading_rad.unwrap() - pose.heading_rad;
            error * error
        };
        (POSES.iter().map(square).sum::<f64>() / POSES.len() as f64).sqrt()
    };
    let (refitted, paper) = (heading_rms(&PaperParams::default()), heading_rms(&own));
    assert!(refitted < paper / 3.0, "refitted {refitted} rad, the paper's own {paper} rad");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Whatever the camera delivers, no panic and no number that is not finite.
    #[test]
    fn any_image_gives_finite_numbers_or_none(seed in any::<u64>(), kind in 0..4u8) {
        let rig = wide();
        let mut state = seed | 1;
        let mut next = move || { state ^= state << 13; state ^= state >> 7; state ^= state << 17; state };
        let mut pixels = vec![0u8; 640 * 480];
        match kind {
            0 => pixels.iter_mut().for_each(|p| *p = next() as u8),
            1 => pixels.fill(next() as u8),
            2 => for _ in 0..40 {
                let (y, x0, length, grey) = ((next() % 480) as usize, (next() % 640) as usize, (next() % 640) as usize, next() as u8);
                for x in x0..(x0 + length).min(640) {
                    for row in y..(y + 4).min(480) { pixels[row * 640 + x] = grey; }
                }
            },
            _ => pixels.iter_mut().enumerate().for_each(|(i, p)| *p = ((i as u64 * seed) >> 5) as u8),
        }
        let (measured, perception) = measure(&rig, PaperParams::default(), &pixels);
        for value in [measured.lateral_m, measured.heading_rad, measured.width_m].into_iter().flatten() {
            prop_assert!(value.is_finite());
        }
        for line in perception.stages().lines {
            prop_assert!(line.ends_px.iter().flatten().all(|v| v.is_finite()));
        }
    }
}
