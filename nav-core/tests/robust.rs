//! The robust pipeline from image to errors, on images that plain geometry makes.

mod common;

use common::{Pose, image, wide};
use ductloop_nav::messages::Frame;
use ductloop_nav::perception::robust::{RobustParams, RobustPerception};
use ductloop_nav::perception::{Measurement, Perception, Wall};
use ductloop_nav::rig::{Distortion, Rig};
use proptest::prelude::*;

fn measure(rig: &Rig, pixels: &[u8]) -> (Measurement, RobustPerception) {
    let mut perception = RobustPerception::new(rig.clone(), RobustParams::default());
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

/// The images have no noise but rounding: a fifth of a millimetre is a hundredth of a pixel across a stripe half a metre ahead.
#[test]
fn both_walls_give_the_pose_and_the_width() {
    let rig = wide();
    for pose in &POSES {
        let (measured, _) = measure(&rig, &image(&rig, pose, [true; 2]));
        let [lateral, heading, width] = [measured.lateral_m, measured.heading_rad, measured.width_m].map(Option::unwrap);
        assert!((lateral - pose.lateral_m).abs() < 1e-3, "{pose:?}: {lateral}");
        assert!((heading - pose.heading_rad).abs() < 1e-3, "{pose:?}: {heading}");
        assert!((width - pose.width_m).abs() < 2e-3, "{pose:?}: {width}");
        let deviation = measured.deviation;
        for (error, sigma) in
            [(lateral - pose.lateral_m, deviation.lateral_m), (heading - pose.heading_rad, deviation.heading_rad)]
        {
            let sigma = sigma.expect("stated");
            assert!(error.abs() < 4.0 * sigma, "{pose:?}: {error} at a deviation of {sigma}");
        }
    }
}

#[test]
fn the_floor_is_below_the_robot() {
    let rig = wide();
    let (measured, perception) = measure(&rig, &image(&rig, &POSES[0], [true; 2]));
    let floor = measured.floor.expect("high meets the floor a metre ahead");
    assert!(floor.distance_m.abs() < 2e-3, "{floor:?}");
    let plane = perception.stages().planes.iter().find(|plane| plane.wall == Wall::Floor).expect("told as a plane too");
    assert!(plane.covariance.is_some() && plane.points == floor.points);
}

#[test]
fn every_assigned_line_lies_on_its_own_side_of_the_image() {
    let rig = wide();
    let (_, perception) = measure(&rig, &image(&rig, &POSES[0], [true; 2]));
    let mut sides = [0, 0];
    for line in perception.stages().lines {
        let Some((_, wall @ (Wall::Left | Wall::Right))) = line.assigned else { continue };
        assert!(line.ends_px.iter().all(|[u, _]| (*u < 320.0) == (wall == Wall::Left)), "{wall:?}: {line:?}");
        sides[usize::from(wall == Wall::Right)] += 1;
    }
    assert_eq!(sides, [2, 2], "two stripes a wall: {:?}", perception.stages().lines);
}

#[test]
fn sixteen_bits_say_the_same_as_eight() {
    let rig = wide();
    let pixels = image(&rig, &POSES[1], [true; 2]);
    let (from_8, _) = measure(&rig, &pixels);
    let deep: Vec<u16> = pixels.iter().map(|p| 16 * u16::from(*p)).collect();
    let frame = Frame::grey16(640, 480, &deep, 4080);
    let from_12 = RobustPerception::new(rig.clone(), RobustParams::default()).perceive(&frame, rig.mount.rest);
    // The deeper frame is believed to round less, so that its columns are weighted a little otherwise.
    let apart = |a: Option<f64>, b: Option<f64>| (a.expect("seen") - b.expect("seen")).abs();
    assert!(apart(from_12.lateral_m, from_8.lateral_m) < 2e-4 && apart(from_12.heading_rad, from_8.heading_rad) < 5e-4);
}

/// One laser off: the walls that are still claimed are right by their own deviations, which have grown.
#[test]
fn one_stripe_a_wall_is_right_or_not_claimed() {
    let rig = wide();
    for lit in [[true, false], [false, true]] {
        for pose in &POSES {
            let (measured, _) = measure(&rig, &image(&rig, pose, lit));
            for (wall, truth_m) in
                [(Wall::Left, pose.width_m / 2.0 - pose.lateral_m), (Wall::Right, pose.width_m / 2.0 + pose.lateral_m)]
            {
                let Some(seen) = measured.wall(wall) else { continue };
                let sigma = seen.deviation.expect("stated").distance_m;
                assert!((seen.distance_m - truth_m).abs() < 5.0 * sigma, "{pose:?} {lit:?} {wall:?}: {seen:?}, true {truth_m}");
            }
        }
    }
    let (dark, _) = measure(&rig, &image(&rig, &POSES[0], [false; 2]));
    assert_eq!(dark, Measurement::default());
}

/// A plane that is not where the navigator believes it makes two stripes that tell of two different walls: neither is believed.
#[test]
fn stripes_that_contradict_each_other_are_no_wall() {
    let rig = wide();
    for turn_deg in [-2.0_f64, 2.0] {
        let turned = rig.clone().with_plane_turned(0, turn_deg.to_radians());
        let (measured, _) = measure(&rig, &image(&turned, &POSES[0], [true; 2]));
        let sides = (measured.left.is_some(), measured.right.is_some());
        assert_eq!(sides, (false, false), "{turn_deg} degrees: {measured:?}");
    }
}

/// A lens that bends lines, known to the navigator: the stripes are curves in the image and planes all the same.
#[test]
fn a_known_distortion_is_taken_out() {
    let mut rig = wide();
    let straight = image(&rig, &POSES[1], [true; 2]);
    rig.camera.distortion = Distortion { k1: -0.12, k2: 0.02, p1: 1e-3, p2: -5e-4, k3: 0.0 };
    // The image as the lens shows it: each pixel looks along its own ray into the undistorted one, between four pixels.
    let lens = ductloop_nav::perception::lens::Lens::new(&rig.camera);
    let mut bent = vec![0u8; straight.len()];
    for v in 0..480 {
        for u in 0..640 {
            let ray = lens.ray(f64::from(u), f64::from(v));
            let (x, y) = (319.5 + 378.4 * ray.x, 239.5 + 378.4 * ray.y);
            if !(0.0..638.0).contains(&x) || !(0.0..478.0).contains(&y) {
                continue;
            }
            let (i, j, a, b) = (x as usize, y as usize, x.fract(), y.fract());
            let at = |i: usize, j: usize| f64::from(straight[j * 640 + i]);
            let above = at(i, j) * (1.0 - a) + at(i + 1, j) * a;
            let below = at(i, j + 1) * (1.0 - a) + at(i + 1, j + 1) * a;
            bent[v as usize * 640 + u as usize] = (above * (1.0 - b) + below * b).round() as u8;
        }
    }
    let (measured, _) = measure(&rig, &bent);
    let (lateral, heading) = (measured.lateral_m.expect("seen"), measured.heading_rad.expect("seen"));
    // Interpolating between pixels widens stripes of two pixels unevenly: a few hundredths of a pixel.
    assert!((lateral - POSES[1].lateral_m).abs() < 2e-3, "{lateral}");
    assert!((heading - POSES[1].heading_rad).abs() < 3e-3, "{heading}");
}

#[test]
fn frames_of_another_size_or_of_one_grey_say_nothing() {
    let rig = wide();
    let mut perception = RobustPerception::new(rig.clone(), RobustParams::default());
    for (width, height) in [(320, 240), (480, 640), (1, 1)] {
        let pixels = vec![100u8; width * height];
        assert_eq!(perception.perceive(&Frame::grey8(width, height, &pixels), rig.mount.rest), Measurement::default());
    }
    for grey in [0, 8, 255] {
        let (measured, perception) = measure(&rig, &vec![grey; 640 * 480]);
        assert_eq!(measured, Measurement::default(), "{grey}");
        assert!(perception.stages().centres.is_empty() && perception.stages().planes.is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Whatever the camera delivers, no panic and no number that is not finite.
    #[test]
    fn any_image_gives_finite_numbers_or_none(seed in any::<u64>(), kind in 0..5u8) {
        let rig = wide();
        let mut state = seed | 1;
        let mut next = move || { state ^= state << 13; state ^= state >> 7; state ^= state << 17; state };
        let mut pixels = vec![0u8; 640 * 480];
        match kind {
            0 => pixels.iter_mut().for_each(|p| *p = next() as u8),
            1 => pixels.iter_mut().for_each(|p| *p = if next() % 50 == 0 { 255 } else { 0 }),
            2 => for _ in 0..40 {
                let (y, x0, length, grey) = ((next() % 480) as usize, (next() % 640) as usize, (next() % 640) as usize, next() as u8);
                for x in x0..(x0 + length).min(640) {
                    for row in y..(y + 4).min(480) { pixels[row * 640 + x] = grey; }
                }
            },
            3 => {
                let pose = Pose { lateral_m: 0.02, heading_rad: 0.05, width_m: 0.5 };
                pixels = image(&rig, &pose, [true; 2]);
                for _ in 0..200 {
                    let (at, grey, length) = ((next() % 300_000) as usize, next() as u8, (next() % 2000) as usize);
                    pixels[at..at + length].fill(grey);
                }
            }
            _ => pixels.iter_mut().enumerate().for_each(|(i, p)| *p = ((i as u64 * seed) >> 5) as u8),
        }
        let (measured, perception) = measure(&rig, &pixels);
        let deviation = measured.deviation;
        let values = [measured.lateral_m, measured.heading_rad, measured.width_m, measured.height_m];
        let sigmas = [deviation.lateral_m, deviation.heading_rad, deviation.width_m, deviation.height_m];
        for (value, sigma) in values.into_iter().zip(sigmas) {
            prop_assert_eq!(value.is_some(), sigma.is_some());
            prop_assert!(value.is_none_or(f64::is_finite) && sigma.is_none_or(|s| s.is_finite() && s >= 0.0));
        }
        let stages = perception.stages();
        for line in stages.lines {
            prop_assert!(line.ends_px.iter().flatten().all(|v| v.is_finite()));
        }
        for centre in stages.centres {
            prop_assert!(centre.u_px.is_finite() && centre.v_px.is_finite() && centre.sigma_px > 0.0 && centre.sigma_px.is_finite());
        }
        for plane in stages.planes {
            prop_assert!(plane.plane.distance_m.is_finite() && plane.distance_sigma_m().is_some_and(f64::is_finite));
        }
    }
}
