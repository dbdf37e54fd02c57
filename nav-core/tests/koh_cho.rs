//! Koh and Cho's law on a unicycle with what a real robot has: commands once a frame, one frame of latency, wheels that lag.

use ductloop_nav::control::koh_cho::{KohCho, KohChoParams};
use ductloop_nav::control::{ControlLaw, PathState, Twist};
use ductloop_nav::odometry::advance;

const PERIOD_S: f64 = 1.0 / 30.0;

struct Run {
    /// (distance along the path, lateral, heading) at each frame.
    trace: Vec<(f64, f64, f64)>,
    commands: Vec<Twist>,
}

/// From `lateral_m` and `heading_rad`, for `duration_s`. `lag_s` is the wheels' time constant, `turn_ratio` true over believed
/// yaw rate. The law is told where the robot will stand when its command takes effect, as the navigator tells it.
fn run(params: KohChoParams, lateral_m: f64, heading_rad: f64, lag_s: f64, turn_ratio: f64, duration_s: f64) -> Run {
    const SUBSTEPS: usize = 40;
    let mut law = KohCho::new(params);
    let (mut y, mut heading, mut x) = (lateral_m, heading_rad, 0.0);
    let (mut true_twist, mut commanded) = (Twist::default(), Twist::default());
    let (mut trace, mut commands) = (Vec::new(), Vec::new());
    let decay = libm::exp(-PERIOD_S / SUBSTEPS as f64 / lag_s);
    let approach = |now: f64, to: f64, keep: f64| to + (now - to) * keep;
    for _ in 0..(duration_s / PERIOD_S) as usize {
        trace.push((x, y, heading));
        // Prediction over the latency with the believed lag and turn ratio of the nominal robot.
        let share = 0.03 / PERIOD_S * (1.0 - libm::exp(-PERIOD_S / 0.03));
        let mean = Twist {
            speed_m_s: approach(true_twist.speed_m_s, commanded.speed_m_s, share),
            yaw_rate_rad_s: approach(true_twist.yaw_rate_rad_s / turn_ratio, commanded.yaw_rate_rad_s, share),
        };
        let (lateral, then, along) = advance(y, heading, mean, PERIOD_S);
        let state =
            PathState { lateral_m: lateral, heading_rad: then, curvature_1_m: 0.0, travelled_m: x + along, period_s: PERIOD_S };
        let next = law.twist(&state);
        for _ in 0..SUBSTEPS {
            true_twist.speed_m_s = approach(true_twist.speed_m_s, commanded.speed_m_s, decay);
            true_twist.yaw_rate_rad_s = approach(true_twist.yaw_rate_rad_s, commanded.yaw_rate_rad_s * turn_ratio, decay);
            let (lateral, then, along) = advance(y, heading, true_twist, PERIOD_S / SUBSTEPS as f64);
            (y, heading, x) = (lateral, then, x + along);
        }
        commanded = next;
        commands.push(next);
    }
    Run { trace, commands }
}

fn params(speed_m_s: f64) -> KohChoParams {
    KohChoParams { speed_m_s, ..KohChoParams::default() }
}

#[test]
fn from_60_mm_and_6_degrees_it_settles_without_overshoot() {
    for (lag_s, turn_ratio) in [(0.03, 1.0), (0.06, 1.0), (0.03, 0.85), (0.03, 1.15)] {
        let run = run(params(0.3), 0.06, 6.0_f64.to_radians(), lag_s, turn_ratio, 20.0);
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
    let run = run(params(0.8), 0.06, 6.0_f64.to_radians(), 0.03, 1.0, 10.0);
    let last = &run.trace[run.trace.len() / 2..];
    assert!(last.iter().all(|(_, y, _)| y.abs() < 5e-3), "{last:?}");
}

#[test]
fn left_and_right_are_mirror_images_to_the_bit() {
    let left = run(params(0.3), 0.04, -0.1, 0.03, 1.0, 10.0);
    let right = run(params(0.3), -0.04, 0.1, 0.03, 1.0, 10.0);
    for (a, b) in left.trace.iter().zip(&right.trace) {
        assert_eq!((a.0, a.1, a.2), (b.0, -b.1, -b.2));
    }
}

#[test]
fn accelerations_stay_within_what_the_wheels_can_do() {
    // A wheel that can give little: with the full yaw acceleration a fifth of it is left for the speed.
    let params = KohChoParams { max_wheel_acceleration_m_s2: 0.4, ..params(0.3) };
    let run = run(params, 0.1, -0.3, 0.03, 1.0, 10.0);
    let mut most: f64 = 0.0;
    for pair in run.commands.windows(2) {
        let a = (pair[1].speed_m_s - pair[0].speed_m_s) / PERIOD_S;
        let alpha = (pair[1].yaw_rate_rad_s - pair[0].yaw_rate_rad_s) / PERIOD_S;
        let rim = a.abs() + params.effective_track_m / 2.0 * alpha.abs();
        // Rounding only: both limits are clamps.
        assert!(alpha.abs() <= params.max_yaw_acceleration_rad_s2 * (1.0 + 1e-9), "{alpha}");
        assert!(rim <= params.max_wheel_acceleration_m_s2 * (1.0 + 1e-9), "{a} {alpha}");
        most = most.max(rim);
    }
    assert!(most > 0.99 * params.max_wheel_acceleration_m_s2, "the bound was never met: {most}");
}

#[test]
fn the_robot_catches_up_with_its_target() {
    let run = run(params(0.3), 0.0, 0.0, 0.03, 1.0, 20.0);
    let last = run.commands.last().expect("a command");
    assert!((last.speed_m_s - 0.3).abs() < 1e-4, "{last:?}");
    // The target ramps at half of a_max: it loses v^2 / a_max = 0.18 m on 20 s at full speed.
    let (x, ..) = run.trace.last().expect("a frame");
    assert!((x - (0.3 * 20.0 - 0.18)).abs() < 0.03, "{x}");
}
