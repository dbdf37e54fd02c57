//! Automatic exposure: what the meter reads off images, and that the law closes in on its target and stays there.

mod common;

use common::{Pose, image, wide};
use ductloop_nav::exposure::{AutoExposure, Brightness, ExposureParams, Light, Meter, Seen};
use ductloop_nav::messages::Frame;

const PARAMS: ExposureParams =
    ExposureParams { target_dn: 150.0, exposure_s: [1e-4, 1e-2], laser_power: [0.1, 1.0], first_exposure_s: 4e-3 };

const POSE: Pose = Pose { lateral_m: 0.03, heading_rad: 0.05, width_m: 0.5 };

/// The image with its light above black scaled, as another exposure or power would.
fn scaled(pixels: &[u8], factor: f64, max_dn: f64) -> Vec<u16> {
    let black = 8.0 * max_dn / 255.0;
    pixels.iter().map(|p| (black + (f64::from(*p) - 8.0) * factor * max_dn / 255.0).round().clamp(0.0, max_dn) as u16).collect()
}

fn read(pixels: &[u16], max_dn: u16) -> Option<Brightness> {
    Meter::new(&wide()).read(&Frame::grey16(640, 480, pixels, max_dn))
}

fn stripes(peak_dn: f64) -> Seen {
    Seen::Stripes(Brightness { peak_dn, saturated: 0.0 })
}

const NOTHING: Seen = Seen::Nothing { full: 0.0 };

/// Follows a scene that shows `per_ms` DN for a millisecond at full power, clipped at 240 above the background; frames come
/// `late` frames after they were asked for. Returns the brightness, unclipped, of each.
fn follow(per_ms: f64, late: usize, frames: usize) -> Vec<f64> {
    let wide_range = ExposureParams { exposure_s: [1e-5, 0.1], ..PARAMS };
    let mut auto = AutoExposure::new(wide_range, &wide());
    let mut asked = vec![Light { exposure_s: PARAMS.first_exposure_s, laser_power: 1.0 }; late + 1];
    let mut seen = Vec::new();
    for _ in 0..frames {
        let light = asked.remove(0);
        let shown = per_ms * light.exposure_s * 1e3 * light.laser_power;
        seen.push(shown);
        let peak_dn = if shown > 240.0 { f64::INFINITY } else { shown };
        asked.push(auto.follow(stripes(peak_dn)));
    }
    seen
}

#[test]
fn the_meter_reads_light_in_proportion_and_the_same_at_any_depth() {
    let pixels = image(&wide(), &POSE, [true; 2]);
    let full = read(&scaled(&pixels, 1.0, 255.0), 255).expect("stripes").peak_dn;
    assert!((20.0..240.0).contains(&full), "{full}");
    for factor in [0.25, 0.5, 1.3] {
        let one = read(&scaled(&pixels, factor, 255.0), 255).expect("stripes").peak_dn;
        // The dimmest columns are lost when it gets darker, so a little less than in proportion: 3 % for each halving that loses
        // a tenth of the columns. The input is rounded to whole grey values before it is scaled, and after it: half a DN each.
        assert!((one - factor * full).abs() < 0.06 * one + 1.0 + factor, "{one} {full} {factor}");
        let deep = read(&scaled(&pixels, factor, 4095.0), 4095).expect("stripes").peak_dn;
        assert!((one - deep).abs() < 1.0, "{one} {deep}");
    }
}

#[test]
fn the_meter_sees_what_saturates_and_is_not_taken_in_by_darkness_or_hot_pixels() {
    let pixels = image(&wide(), &POSE, [true; 2]);
    let burnt = read(&scaled(&pixels, 20.0, 255.0), 255).expect("stripes");
    assert!(burnt.peak_dn == f64::INFINITY && burnt.saturated > 0.5, "{burnt:?}");
    // Walls lit by the headlamp alone, and a black image with a hot pixel in every column.
    let dark = image(&wide(), &POSE, [false; 2]);
    assert_eq!(read(&scaled(&dark, 1.0, 255.0), 255), None);
    let mut hot = vec![8; 640 * 480];
    hot[200 * 640..201 * 640].fill(255);
    assert_eq!(read(&hot, 255), None);
}

#[test]
fn ten_times_too_dark_and_ten_times_too_bright_are_put_right_in_twelve_frames_without_swinging() {
    for per_ms in [3.75, 375.0] {
        for late in [0, 1] {
            let seen = follow(per_ms, late, 60);
            let off: Vec<f64> = seen.iter().map(|s| libm::log(s / PARAMS.target_dn)).collect();
            // One late frame costs three more: z = 1/2 twice instead of 3/4 once, and twelve saturated ones at first.
            let settled = if late == 0 { 12 } else { 16 };
            assert!(off[settled..].iter().all(|e| e.abs() < libm::log(1.15)), "{per_ms} {late}: {seen:?}");
            assert!(off[59].abs() < 1e-3, "{seen:?}");
            if late == 0 || per_ms < 100.0 {
                // It comes from one side and never crosses.
                assert!(off.iter().all(|e| e * off[0] > -1e-9), "{per_ms} {late}: {seen:?}");
            } else {
                // What saturates is overestimated, once more while the answer is awaited: a tenth at most.
                assert!(off.iter().all(|e| *e > -0.1), "{per_ms} {late}: {seen:?}");
            }
            let turns = off.windows(3).filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < -1e-9).count();
            assert!(turns <= late, "{per_ms} {late}: {seen:?}");
        }
    }
}

#[test]
fn a_blank_frame_changes_nothing_and_no_step_is_more_than_twofold() {
    let mut auto = AutoExposure::new(PARAMS, &wide());
    assert_eq!(auto.follow(NOTHING), Light { exposure_s: 4e-3, laser_power: 1.0 });
    let before = auto.follow(stripes(100.0)).exposure_s;
    assert!(before > 4e-3);
    // Nor do as many as may come in a row, again and again, whatever is in them.
    for _ in 0..5 {
        for _ in 0..14 {
            assert_eq!(auto.clone().follow(Seen::Nothing { full: 1.0 }).exposure_s, before);
            assert_eq!(auto.follow(NOTHING).exposure_s, before);
        }
        assert_eq!(auto.follow(stripes(PARAMS.target_dn)).exposure_s, before);
    }
    let longer = auto.follow(stripes(1e-6)).exposure_s;
    assert!((longer / before - 2.0).abs() < 1e-12, "{longer} {before}");
}

/// A dose of a hundred times, or a hundredth of, the first one would be right, and stripes show only from half to twice that. A
/// frame that is too bright has no stripes either: it is full of light, or it merely shows none. Frames come `late` frames after
/// they were asked for.
#[test]
fn stripes_a_hundred_times_too_dark_or_too_bright_are_found_and_put_right() {
    const WIDE_RANGE: ExposureParams = ExposureParams { exposure_s: [1e-5, 0.5], ..PARAMS };
    for (wanted, full, late) in [100.0, 0.01]
        .into_iter()
        .flat_map(|wanted| [0.0, 0.6].map(|full| (wanted, full)))
        .flat_map(|(wanted, full)| [0, 1].map(|late| (wanted, full, late)))
    {
        let mut auto = AutoExposure::new(WIDE_RANGE, &wide());
        let mut asked = vec![Light { exposure_s: PARAMS.first_exposure_s, laser_power: 1.0 }; late + 1];
        let mut shown = Vec::new();
        for frame in 0..120 {
            let light = asked.remove(0);
            let peak_dn = PARAMS.target_dn * light.exposure_s * light.laser_power / (PARAMS.first_exposure_s * wanted);
            shown.push(peak_dn);
            // Frame 100 is blank.
            let seen = match peak_dn / PARAMS.target_dn {
                _ if frame == 100 => NOTHING,
                share if share < 0.5 => NOTHING,
                share if share > 2.0 => Seen::Nothing { full },
                _ => stripes(peak_dn),
            };
            asked.push(auto.follow(seen));
        }
        // Fifteen frames of patience; at most 7 doublings and 9 halvings of the range, each held for two frames; 14 for the law.
        let settled = 15 + 2 * (7 + 9) + 14;
        let off = |peak_dn: &f64| libm::log(peak_dn / PARAMS.target_dn).abs();
        assert!(shown[settled..].iter().all(|peak| off(peak) < libm::log(1.15)), "{wanted} {full} {late}: {shown:?}");
        // It knows the way: the wrong one first would take 14 or more frames longer.
        if wanted > 1.0 || full > 0.0 {
            assert!(shown[15 + 2 * 7 + 14..].iter().all(|peak| off(peak) < libm::log(1.15)), "{wanted} {full} {late}: {shown:?}");
        }
    }
}

#[test]
fn a_search_in_vain_goes_through_the_whole_range_both_ways_and_begins_again_where_it_began() {
    let mut auto = AutoExposure::new(PARAMS, &wide());
    let mut next = || {
        let light = auto.follow(NOTHING);
        light.exposure_s * light.laser_power
    };
    for _ in 0..3 {
        for _ in 0..14 {
            assert_eq!(next(), 4e-3);
        }
        // Up to 10 ms, then from 2 ms down to 0.1 ms at a tenth of the power.
        for dose_s in [8e-3, 1e-2, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5, 3.125e-5, 1.5625e-5, 1e-5] {
            for _ in 0..2 {
                let is = next();
                assert!((is / dose_s - 1.0).abs() < 1e-12, "{is} {dose_s}");
            }
        }
        assert_eq!(next(), 4e-3);
    }
}

/// From images: a frame that is full of light says so, and so does one of 12 bits; walls in the dark do not.
#[test]
fn a_look_at_a_frame_without_stripes_says_how_much_of_it_is_full() {
    let rig = wide();
    let dark = image(&rig, &POSE, [false; 2]);
    assert_eq!(Meter::new(&rig).look(&Frame::grey8(640, 480, &dark)), Seen::Nothing { full: 0.0 });
    // Ten columns full of light are too few for stripes: 1/64 of the frame.
    for max_dn in [255, 4095] {
        let mut lamp = scaled(&dark, 1.0, f64::from(max_dn));
        lamp.chunks_mut(640).for_each(|row| row[100..110].fill(max_dn));
        assert_eq!(Meter::new(&rig).look(&Frame::grey16(640, 480, &lamp, max_dn)), Seen::Nothing { full: 1.0 / 64.0 });
    }
    let lit = image(&rig, &POSE, [true; 2]);
    assert!(matches!(Meter::new(&rig).look(&Frame::grey8(640, 480, &lit)), Seen::Stripes(_)));
}

/// Full power until the shortest exposure is too long, then less; where more than nominal power is allowed, only when the longest
/// exposure is too short.
#[test]
fn exposure_goes_first_and_power_after_it() {
    let light = |dose_s, laser_power| {
        let Light { exposure_s, laser_power } = ExposureParams { laser_power, ..PARAMS }.light(dose_s);
        (exposure_s, laser_power)
    };
    assert_eq!(light(3e-3, [0.1, 1.0]), (3e-3, 1.0));
    assert_eq!(light(5e-5, [0.1, 1.0]), (1e-4, 0.5));
    assert_eq!(light(1e-6, [0.1, 1.0]), (1e-4, 0.1));
    assert_eq!(light(1e-1, [0.1, 1.0]), (1e-2, 1.0));
    assert_eq!(light(2e-2, [0.1, 4.0]), (1e-2, 2.0));
    assert_eq!(light(4e-3, [0.1, 0.5]), (8e-3, 0.5));
}
