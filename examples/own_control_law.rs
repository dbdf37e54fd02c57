//! A control law of one's own in the robot's place: a plain PD on lateral and heading error, held against Koh and Cho's on the
//! same scenario and seed.
//!
//! ```text
//! cargo run --release --example own_control_law -- scenarios/straight-offset.toml
//! ```

use ductloop::{ControlLaw, PathState, Pilot, Scenario, Twist};

/// Constant speed; yaw rate proportional to both errors, with the speed ramped up so that the wheels do not slip.
struct ProportionalLaw {
    speed_m_s: f64,
    commanded_m_s: f64,
    /// Yaw rate for a metre beside the path, in rad/s.
    lateral_gain: f64,
    /// Yaw rate for a radian of heading error, in rad/s.
    heading_gain: f64,
}

impl ControlLaw for ProportionalLaw {
    fn twist(&mut self, state: &PathState) -> Twist {
        const ACCELERATION_M_S2: f64 = 0.5;
        self.commanded_m_s = self.speed_m_s.min(self.commanded_m_s + ACCELERATION_M_S2 * state.period_s);
        let feedback = -self.lateral_gain * state.lateral_m - self.heading_gain * state.heading_rad;
        Twist {
            speed_m_s: self.commanded_m_s,
            yaw_rate_rad_s: self.commanded_m_s * state.curvature_1_m + feedback.clamp(-1.0, 1.0),
        }
    }

    fn reset(&mut self, _travelled_m: f64) {
        self.commanded_m_s = 0.0;
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "scenarios/straight-offset.toml".into());
    let scenario = Scenario::read(file.as_ref(), &Default::default())?;
    let own = ProportionalLaw { speed_m_s: scenario.speed_m_s, commanded_m_s: 0.0, lateral_gain: 3.0, heading_gain: 2.0 };
    let runs = [("koh-cho", Pilot::of(&scenario)), ("proportional", Pilot::with_law(&scenario, own))];
    println!("{:<14}{:>10}{:>18}{:>18}", "law", "verdict", "lateral RMS, mm", "heading RMS, deg");
    for (name, pilot) in runs {
        let outcome = ductloop::run(&scenario, pilot)?;
        let lateral_mm = outcome.metrics.lateral_rms_m.map_or(f64::NAN, |m| m * 1e3);
        let heading_deg = outcome.metrics.heading_rms_rad.map_or(f64::NAN, f64::to_degrees);
        println!("{name:<14}{:>10}{lateral_mm:>18.2}{heading_deg:>18.3}", outcome.verdict.word());
    }
    Ok(())
}
