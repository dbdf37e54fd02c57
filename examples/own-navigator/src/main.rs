//! A whole navigator and a control law of one's own, in a crate outside ductloop's workspace, on a scenario of its library.
//!
//! ```text
//! cargo run --release --manifest-path examples/own-navigator/Cargo.toml -- scenarios/straight.toml
//! ```
//!
//! The navigator needs no rig: in the middle of a straight duct the stripes in the left and right halves of the image mirror each
//! other, and how the two differ tells on which side of the middle the robot is. It reads the brightest row of each column and
//! steers by the mean difference of height between the halves: rough, but it stays in the middle. The exit code is 0 if every run
//! passes its scenario's verdict on completion.

use ductloop::{
    Command, ControlLaw, Counts, Frame, MountAngles, Navigator, PathState, Pilot, Pixels, Scenario, Sides, Tick, Twist, Verdict,
};

/// Steers by the asymmetry of the image.
struct Symmetry {
    speed_m_s: f64,
    commanded_m_s: f64,
    step_m_s: f64,
    wheel_radius_m: f64,
    half_track_m: f64,
    before: f64,
}

impl Symmetry {
    /// Mean column of the light, from -1 at the left edge to 1 at the right one, weighted by brightness squared.
    fn asymmetry(frame: &Frame<'_>) -> f64 {
        let value = |index: usize| match frame.pixels {
            Pixels::Grey8(pixels) => f64::from(pixels[index]),
            Pixels::Grey16(pixels) => f64::from(pixels[index]),
        };
        let (width, height) = (frame.width_px, frame.height_px);
        // Height of the stripe over each half: the nearer a wall, the farther apart the two stripes are on it.
        let spread = |columns: std::ops::Range<usize>| {
            let (mut sum, mut squares, mut weights) = (0.0, 0.0, 0.0);
            for row in 0..height {
                for column in columns.clone() {
                    let light = value(row * width + column);
                    if light > f64::from(frame.max_dn) * 0.2 {
                        let y = row as f64 / height as f64 - 0.5;
                        sum += light * y;
                        squares += light * y * y;
                        weights += light;
                    }
                }
            }
            if weights == 0.0 { 0.0 } else { (squares / weights - (sum / weights) * (sum / weights)).max(0.0).sqrt() }
        };
        spread(0..width / 2) - spread(width / 2..width)
    }
}

impl Navigator for Symmetry {
    fn on_frame(&mut self, frame: &Frame<'_>, _counts: Counts, mount: MountAngles, _tick: Tick) -> Command {
        self.commanded_m_s = self.speed_m_s.min(self.commanded_m_s + self.step_m_s);
        let asymmetry = Self::asymmetry(frame);
        let rate = asymmetry - self.before;
        self.before = asymmetry;
        let yaw_rate = (LEAN * asymmetry + DAMP * rate).clamp(-0.5, 0.5);
        let difference = yaw_rate * self.half_track_m;
        Command {
            wheel_speed_rad_s: Sides {
                left: (self.commanded_m_s - difference) / self.wheel_radius_m,
                right: (self.commanded_m_s + difference) / self.wheel_radius_m,
            },
            ..Command::stop(mount)
        }
    }
}

/// Yaw rate for the whole image's height of asymmetry, in rad/s; positive turns left, away from a near right wall.
const LEAN: f64 = -4.0;
/// The same for its change from frame to frame.
const DAMP: f64 = -40.0;

/// A law of one's own: yaw rate proportional to both errors, with the robot's own perception before it.
struct Proportional {
    speed_m_s: f64,
    commanded_m_s: f64,
}

impl ControlLaw for Proportional {
    fn twist(&mut self, state: &PathState) -> Twist {
        self.commanded_m_s = self.speed_m_s.min(self.commanded_m_s + 0.25 * state.period_s);
        let wanted = -self.commanded_m_s * (16.0 * state.lateral_m + 8.0 * state.heading_rad);
        Twist { speed_m_s: self.commanded_m_s, yaw_rate_rad_s: wanted.clamp(-1.0, 1.0) }
    }

    fn reset(&mut self, _travelled_m: f64) {
        self.commanded_m_s = 0.0;
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "scenarios/straight.toml".into());
    let mut scenario = Scenario::read(file.as_ref(), &Default::default())?;
    // Of the verdict, only what a rough navigator can be held to: it gets through, and touches nothing.
    scenario.pass.list.retain(|criterion| ["completed", "collisions"].contains(&criterion.key));
    let robot = &scenario.robot;
    let symmetry = Symmetry {
        speed_m_s: scenario.speed_m_s,
        commanded_m_s: 0.0,
        step_m_s: 0.25 / f64::from(scenario.rates.camera_hz),
        wheel_radius_m: robot.wheel_radius_m,
        half_track_m: robot.chi() * robot.track_m / 2.0,
        before: 0.0,
    };
    let law = Proportional { speed_m_s: scenario.speed_m_s, commanded_m_s: 0.0 };
    let pilots = [("symmetry", Pilot::from(symmetry)), ("proportional", Pilot::with_law(&scenario, law))];
    let mut all_passed = true;
    println!("{:<14}{:>10}{:>18}{:>18}", "navigator", "verdict", "lateral RMS, mm", "lateral worst, mm");
    for (name, pilot) in pilots {
        let outcome = ductloop::run(&scenario, pilot)?;
        let mm = |metres: Option<f64>| metres.map_or(f64::NAN, |m| m * 1e3);
        let (rms, worst) = (mm(outcome.metrics.lateral_rms_m), mm(outcome.metrics.lateral_max_m));
        println!("{name:<14}{:>10}{rms:>18.2}{worst:>18.2}", outcome.verdict.word());
        all_passed &= outcome.verdict == Verdict::Pass;
    }
    if all_passed { Ok(()) } else { Err("a run has failed".into()) }
}
