//! A whole navigator and a control law of one's own, in a crate outside ductloop's workspace, on a scenario of its library.
//!
//! ```text
//! cargo run --release --manifest-path examples/own-navigator/Cargo.toml -- scenarios/straight.toml
//! ```
//!
//! The navigator uses the library's perception, which it might as well bring along, and nothing else of the robot's own navigator:
//! it knows neither encoders nor prediction. The law takes the place of Koh and Cho's in the robot's own navigator, which predicts
//! for it. The exit code is 0 if both come through without touching anything.

use std::process::ExitCode;

use ductloop::{
    Command, ControlLaw, Counts, Frame, MountAngles, Navigator, PathState, Perception, Pilot, Scenario, Sides, Tick, Twist,
    Verdict,
};

/// Steers by what a frame shows, and goes straight on where it shows nothing.
struct FrameByFrame<P> {
    perception: P,
    law: Proportional,
    period_s: f64,
    wheel_radius_m: f64,
    effective_track_m: f64,
}

impl<P: Perception> Navigator for FrameByFrame<P> {
    fn on_frame(&mut self, frame: &Frame<'_>, _counts: Counts, mount: MountAngles, _tick: Tick) -> Command {
        let seen = self.perception.perceive(frame, mount);
        let state = PathState {
            lateral_m: seen.lateral_m.unwrap_or_default(),
            heading_rad: seen.heading_rad.unwrap_or_default(),
            period_s: self.period_s,
            ..PathState::default()
        };
        let Twist { speed_m_s, yaw_rate_rad_s } = self.law.twist(&state);
        let difference_m_s = yaw_rate_rad_s * self.effective_track_m / 2.0;
        let wheel_speed_rad_s = Sides {
            left: (speed_m_s - difference_m_s) / self.wheel_radius_m,
            right: (speed_m_s + difference_m_s) / self.wheel_radius_m,
        };
        Command { wheel_speed_rad_s, ..Command::stop(mount) }
    }
}

/// Yaw rate proportional to speed and to both errors; the speed ramps up.
struct Proportional {
    speed_m_s: f64,
    commanded_m_s: f64,
}

impl ControlLaw for Proportional {
    fn twist(&mut self, state: &PathState) -> Twist {
        const ACCELERATION_M_S2: f64 = 0.25;
        self.commanded_m_s = self.speed_m_s.min(self.commanded_m_s + ACCELERATION_M_S2 * state.period_s);
        let wanted = -self.commanded_m_s * (16.0 * state.lateral_m + 8.0 * state.heading_rad);
        Twist { speed_m_s: self.commanded_m_s, yaw_rate_rad_s: wanted.clamp(-1.0, 1.0) }
    }

    fn reset(&mut self, _travelled_m: f64) {
        self.commanded_m_s = 0.0;
    }
}

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "scenarios/straight.toml".into());
    let mut scenario = Scenario::read(file.as_ref(), &Default::default())?;
    // The library's other bounds are the robot's own navigator's.
    scenario.pass.list.retain(|criterion| ["completed", "collisions"].contains(&criterion.key));
    let law = || Proportional { speed_m_s: scenario.speed_m_s, commanded_m_s: 0.0 };
    let navigator = FrameByFrame {
        perception: ductloop::pilot::perception(&scenario),
        law: law(),
        period_s: 1.0 / f64::from(scenario.rates.camera_hz),
        wheel_radius_m: scenario.robot.wheel_radius_m,
        effective_track_m: scenario.robot.chi() * scenario.robot.track_m,
    };
    let pilots = [("own navigator", Pilot::from(navigator)), ("own law", Pilot::with_law(&scenario, law()))];
    let mut all_passed = true;
    println!("{:<16}{:>10}{:>18}{:>20}", "", "verdict", "lateral RMS, mm", "lateral worst, mm");
    for (name, pilot) in pilots {
        let outcome = ductloop::run(&scenario, pilot)?;
        let mm = |metres: Option<f64>| metres.map_or(f64::NAN, |m| m * 1e3);
        let (rms, worst) = (mm(outcome.metrics.lateral_rms_m), mm(outcome.metrics.lateral_max_m));
        println!("{name:<16}{:>10}{rms:>18.2}{worst:>20.2}", outcome.verdict.word());
        all_passed &= outcome.verdict == Verdict::Pass;
    }
    Ok(if all_passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
