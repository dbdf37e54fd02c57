//! Koh and Cho's law on a unicycle with what a real robot has: commands once a frame, one frame of latency, wheels that lag.

mod unicycle;

use ductloop_nav::control::koh_cho::{KohCho, KohChoParams};
use ductloop_nav::control::limits::Limits;
use unicycle::{PERIOD_S, Run, Unicycle};

/// From `lateral_m` and `heading_rad`, for `duration_s`.
fn run(speed_m_s: f64, limits: Limits, lateral_m: f64, heading_rad: f64, lag_s: f64, turn_ratio: f64, duration_s: f64) -> Run {
    let unicycle = Unicycle { lag_s, turn_ratio, ..Unicycle::at(lateral_m, heading_rad) };
    unicycle.drive(&mut KohCho::new(speed_m_s, limits, KohChoParams::default()), duration_s)
}

#[test]
fn from_60_mm_and_6_degrees_it_settles_without_overshoot() {
    for (lag_s, turn_ratio) in [(0.03, 1.0), (0.06, 1.0), (0.03, 0.85), (0.03, 1.15)] {
        let run = run(0.3, Limits::default(), 0.06, 6.0_f64.to_radians(), lag_s, turn_ratio, 20.0);
        let told = || format!("lag {lag_s} s, turns {turn_ratio}");
        for (x, y, heading) in &run.trace {
            // The figures that the law's form was chosen by: inside 5 mm within 0.8 m, no overshoot; then still.
            assert!(*x < 0.8 || y.abs() < 5e-3, "{}: {y} m at {x} m", told());
            assert!(*y > -1e-3, "{}: overshoot to {y} m at {x} m", told());
            assert!(
                *x < 2.0 || (y.abs() < 2e-4 && heading.abs() < 0.1_f64.to_radians()),
                "{}: {y} m, {heading} rad at {x} m",
                told()
            );
        }
    }
}

#[test]
fn at_0_8_m_s_it_still_settles() {
    let run = run(0.8, Limits::default(), 0.06, 6.0_f64.to_radians(), 0.03, 1.0, 10.0);
    let last = &run.trace[run.trace.len() / 2..];
    assert!(last.iter().all(|(_, y, _)| y.abs() < 5e-3), "{last:?}");
}

#[test]
fn left_and_right_are_mirror_images_to_the_bit() {
    let left = run(0.3, Limits::default(), 0.04, -0.1, 0.03, 1.0, 10.0);
    let right = run(0.3, Limits::default(), -0.04, 0.1, 0.03, 1.0, 10.0);
    for (a, b) in left.trace.iter().zip(&right.trace) {
        assert_eq!((a.0, a.1, a.2), (b.0, -b.1, -b.2));
    }
}

#[test]
fn accelerations_stay_within_what_the_wheels_can_do() {
    // A wheel that can give little: with the full yaw acceleration a fifth of it is left for the speed.
    let limits = Limits { max_wheel_acceleration_m_s2: 0.4, ..Limits::default() };
    let run = run(0.3, limits, 0.1, -0.3, 0.03, 1.0, 10.0);
    let mut most: f64 = 0.0;
    for pair in run.commands.windows(2) {
        let a = (pair[1].speed_m_s - pair[0].speed_m_s) / PERIOD_S;
        let alpha = (pair[1].yaw_rate_rad_s - pair[0].yaw_rate_rad_s) / PERIOD_S;
        let rim = a.abs() + limits.effective_track_m / 2.0 * alpha.abs();
        // Rounding only: both limits are clamps.
        assert!(alpha.abs() <= limits.max_yaw_acceleration_rad_s2 * (1.0 + 1e-9), "{alpha}");
        assert!(rim <= limits.max_wheel_acceleration_m_s2 * (1.0 + 1e-9), "{a} {alpha}");
        most = most.max(rim);
    }
    assert!(most > 0.99 * limits.max_wheel_acceleration_m_s2, "the bound was never met: {most}");
}

#[test]
fn the_robot_catches_up_with_its_target() {
    let run = run(0.3, Limits::default(), 0.0, 0.0, 0.03, 1.0, 20.0);
    let last = run.commands.last().expect("a command");
    assert!((last.speed_m_s - 0.3).abs() < 1e-4, "{last:?}");
    // The target ramps at half of a_max: it loses v^2 / a_max = 0.18 m on 20 s at full speed.
    let (x, ..) = run.trace.last().expect("a frame");
    assert!((x - (0.3 * 20.0 - 0.18)).abs() < 0.03, "{x}");
}
