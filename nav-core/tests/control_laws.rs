//! Every control law on a unicycle with what a real robot has: signs, equilibrium, limits, convergence.

mod unicycle;

use ductloop_nav::control::kanayama::Kanayama;
use ductloop_nav::control::koh_cho::{KohCho, KohChoParams};
use ductloop_nav::control::koh_cho_printed::KohChoPrinted;
use ductloop_nav::control::limits::Limits;
use ductloop_nav::control::lqr::Lqr;
use ductloop_nav::control::pure_pursuit::PurePursuit;
use ductloop_nav::control::samson::Samson;
use ductloop_nav::control::stanley::Stanley;
use ductloop_nav::control::{ControlLaw, PathState, Twist};
use unicycle::{PERIOD_S, Run, Unicycle};

/// Every law with its defaults; the printed one last.
fn laws(speed_m_s: f64, limits: Limits) -> [(&'static str, Box<dyn ControlLaw>); 7] {
    [
        ("koh-cho", Box::new(KohCho::new(speed_m_s, limits, KohChoParams::default()))),
        ("pure-pursuit", Box::new(PurePursuit::new(speed_m_s, limits, Default::default()))),
        ("stanley", Box::new(Stanley::new(speed_m_s, limits, Default::default()))),
        ("kanayama", Box::new(Kanayama::new(speed_m_s, limits, Default::default()))),
        ("samson", Box::new(Samson::new(speed_m_s, limits, Default::default()))),
        ("lqr", Box::new(Lqr::new(speed_m_s, limits, Default::default()))),
        ("koh-cho-printed", Box::new(KohChoPrinted::new(speed_m_s, limits, KohChoParams::default().landing))),
    ]
}

/// (settling distance to 5 mm, overshoot) from a start on the left.
fn landing(run: &Run) -> (f64, f64) {
    let settled = run.trace.iter().rev().find(|(_, y, _)| y.abs() > 5e-3).map_or(0.0, |(x, ..)| *x);
    let overshoot = run.trace.iter().map(|(_, y, _)| -y).fold(0.0, f64::max);
    (settled, overshoot)
}

fn worst_of_second_half(run: &Run) -> f64 {
    run.trace[run.trace.len() / 2..].iter().map(|(_, y, _)| y.abs()).fold(0.0, f64::max)
}

/// At 0.3 m/s, from 60 mm and 6 degrees: (law, settled within m, overshoot within mm). The figures are those found, rounded up by a
/// tenth or so; the law as printed is left to the next test.
#[test]
fn from_60_mm_and_6_degrees_they_settle() {
    let bounds = [
        ("koh-cho", 0.8, 1.0),
        ("pure-pursuit", 1.2, 5.0),
        ("stanley", 1.2, 1.0),
        ("kanayama", 1.2, 1.0),
        ("samson", 1.2, 1.0),
        ("lqr", 1.2, 1.0),
    ];
    for (lag_s, turn_ratio) in [(0.03, 1.0), (0.06, 1.0), (0.03, 0.85), (0.03, 1.15)] {
        for ((name, mut law), (of, settled_m, overshoot_mm)) in laws(0.3, Limits::default()).into_iter().zip(bounds) {
            assert_eq!(name, of);
            let start = Unicycle { lag_s, turn_ratio, ..Unicycle::at(0.06, 6.0_f64.to_radians()) };
            let run = start.drive(law.as_mut(), 20.0);
            let (settled, overshoot) = landing(&run);
            println!("{name} lag {lag_s} turns {turn_ratio}: {settled:.2} m, {:.2} mm", overshoot * 1e3);
            assert!(settled <= settled_m && overshoot * 1e3 <= overshoot_mm, "{name}: {settled} m, {overshoot} m");
            assert!(worst_of_second_half(&run) < 2e-4, "{name}: {}", worst_of_second_half(&run));
        }
    }
}

/// The faster, the farther: the yaw acceleration is bounded.
#[test]
fn at_0_8_m_s_they_still_settle() {
    for (name, mut law) in laws(0.8, Limits::default()).into_iter().take(6) {
        let run = Unicycle::at(0.06, 6.0_f64.to_radians()).drive(law.as_mut(), 10.0);
        let (settled, overshoot) = landing(&run);
        println!("{name}: {settled:.2} m, {:.2} mm, {:.3} mm", overshoot * 1e3, worst_of_second_half(&run) * 1e3);
        assert!(worst_of_second_half(&run) < 5e-3, "{name}: {}", worst_of_second_half(&run));
    }
}

/// What is printed has unbounded gain at zero error, and starts from a motion that is old: it never comes to rest.
#[test]
fn as_printed_koh_and_chos_law_does_not_settle() {
    let printed = |speed_m_s: f64| {
        let (_, mut law) = laws(speed_m_s, Limits::default()).into_iter().next_back().expect("a law");
        Unicycle::at(0.06, 6.0_f64.to_radians()).drive(law.as_mut(), 20.0)
    };
    let run = printed(0.3);
    let headings = run.trace[run.trace.len() / 2..].iter().map(|(.., th)| th.abs()).fold(0.0, f64::max);
    println!("{} m, {} degrees", worst_of_second_half(&run), headings.to_degrees());
    assert!(headings.to_degrees() > 2.0, "{} degrees", headings.to_degrees());
}

#[test]
fn left_and_right_are_mirror_images_to_the_bit() {
    for ((name, mut left), (_, mut right)) in laws(0.3, Limits::default()).into_iter().zip(laws(0.3, Limits::default())) {
        let start = |side: f64| Unicycle { curvature_1_m: 0.5 * side, ..Unicycle::at(0.04 * side, -0.1 * side) };
        let (a, b) = (start(1.0).drive(left.as_mut(), 10.0), start(-1.0).drive(right.as_mut(), 10.0));
        for (a, b) in a.trace.iter().zip(&b.trace) {
            assert_eq!((a.0, a.1, a.2), (b.0, -b.1, -b.2), "{name}");
        }
    }
}

/// A robot to the left of its path, or turned to the left of it, is turned to the right.
#[test]
fn errors_to_the_left_are_steered_to_the_right() {
    for (lateral_m, heading_rad) in [(0.05, 0.0), (0.0, 0.1)] {
        for (name, mut law) in laws(0.3, Limits::default()) {
            let moving = Twist { speed_m_s: 0.3, yaw_rate_rad_s: 0.0 };
            let state = PathState { lateral_m, heading_rad, measured: moving, period_s: PERIOD_S, ..PathState::default() };
            // The second: the first of some goes without a turn, as they are at rest.
            law.twist(&state);
            let turn = law.twist(&state).yaw_rate_rad_s;
            assert!(turn < 0.0, "{name} at {lateral_m} m, {heading_rad} rad: {turn}");
        }
    }
}

/// On the path, at speed, in bends and on straights, a law turns as the path does, and goes on doing so. The printed law does so on
/// the path exactly.
#[test]
fn on_the_path_they_stay_on_it() {
    for c in [0.0, 1.2, -0.6] {
        for (name, mut law) in laws(0.3, Limits::default()) {
            let mut travelled_m = 0.0;
            let mut measured = Twist::default();
            for step in 0..300 {
                let state = PathState { curvature_1_m: c, travelled_m, measured, period_s: PERIOD_S, ..PathState::default() };
                let twist = law.twist(&state);
                // Ideal wheels: the robot does at once what it is told, and stays on the path.
                travelled_m += 0.5 * (measured.speed_m_s + twist.speed_m_s) * PERIOD_S;
                measured = twist;
                // After 5 s every law has come to speed.
                let tolerance = if name == "koh-cho-printed" { 0.05 } else { 1e-3 };
                let off = (twist.speed_m_s - 0.3).abs().max((twist.yaw_rate_rad_s - 0.3 * c).abs());
                assert!(step < 150 || off < tolerance, "{name} at {c} / m, step {step}: {twist:?}");
            }
        }
    }
}

/// From 40 mm beside a bend of 1 m radius every law but the printed one lands on it; what is left is the discretisation's.
#[test]
fn they_converge_in_a_bend() {
    for (name, mut law) in laws(0.3, Limits::default()).into_iter().take(6) {
        let run = Unicycle { curvature_1_m: 1.0, ..Unicycle::at(0.04, 0.0) }.drive(law.as_mut(), 20.0);
        println!("{name}: {:.3} mm", worst_of_second_half(&run) * 1e3);
        assert!(worst_of_second_half(&run) < 1e-3, "{name}: {}", worst_of_second_half(&run));
    }
}

#[test]
fn the_same_limits_hold_for_all() {
    let limits = Limits { max_wheel_acceleration_m_s2: 0.3, max_speed_m_s: 0.25, ..Limits::default() };
    for (name, mut law) in laws(0.3, limits) {
        if name == "koh-cho-printed" {
            // It steps from the measured motion: its own commands may jump.
            continue;
        }
        let run = Unicycle::at(0.1, -0.3).drive(law.as_mut(), 10.0);
        let mut most: f64 = 0.0;
        for pair in run.commands.windows(2) {
            let a = (pair[1].speed_m_s - pair[0].speed_m_s) / PERIOD_S;
            let alpha = (pair[1].yaw_rate_rad_s - pair[0].yaw_rate_rad_s) / PERIOD_S;
            let rim = a.abs() + limits.effective_track_m / 2.0 * alpha.abs();
            // Rounding only.
            assert!(alpha.abs() <= limits.max_yaw_acceleration_rad_s2 * (1.0 + 1e-9), "{name}: {alpha}");
            assert!(rim <= limits.max_wheel_acceleration_m_s2 * (1.0 + 1e-9), "{name}: {a} {alpha}");
            assert!(pair[1].speed_m_s.abs() <= 0.25, "{name}");
            most = most.max(rim);
        }
        assert!(most > 0.99 * limits.max_wheel_acceleration_m_s2, "{name}: the bound was never met: {most}");
    }
}

#[test]
fn after_a_reset_they_start_from_rest() {
    for (name, mut law) in laws(0.3, Limits::default()).into_iter().take(6) {
        Unicycle::at(0.1, -0.3).drive(law.as_mut(), 3.0);
        law.reset(7.0);
        let twist = law.twist(&PathState { travelled_m: 7.0, period_s: PERIOD_S, ..PathState::default() });
        // One period at the largest acceleration.
        assert!(twist.speed_m_s.abs() <= 0.5 * PERIOD_S + 1e-12 && twist.yaw_rate_rad_s == 0.0, "{name}: {twist:?}");
    }
}
