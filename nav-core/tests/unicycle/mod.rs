//! A unicycle with what a real robot has: commands once a frame, one frame of latency, wheels that lag.

use ductloop_nav::control::{ControlLaw, PathState, Twist};
use ductloop_nav::odometry::advance;

pub(crate) const PERIOD_S: f64 = 1.0 / 30.0;

pub(crate) struct Run {
    /// (distance along the path, lateral, heading) at each frame.
    pub(crate) trace: Vec<(f64, f64, f64)>,
    pub(crate) commands: Vec<Twist>,
}

/// Where it starts, and how it differs from what is believed of it.
#[derive(Clone, Copy)]
pub(crate) struct Unicycle {
    pub(crate) lateral_m: f64,
    pub(crate) heading_rad: f64,
    /// Curvature of the path, in 1/m.
    pub(crate) curvature_1_m: f64,
    /// The wheels' time constant.
    pub(crate) lag_s: f64,
    /// True over believed yaw rate.
    pub(crate) turn_ratio: f64,
}

impl Unicycle {
    pub(crate) fn at(lateral_m: f64, heading_rad: f64) -> Self {
        Self { lateral_m, heading_rad, curvature_1_m: 0.0, lag_s: 0.03, turn_ratio: 1.0 }
    }

    /// (lateral, heading, distance along the path) after a while, relative to a path of this curvature: the path's nearest point
    /// moves by cos(heading) / (1 - c d), and turns.
    fn advance(&self, lateral: f64, heading: f64, twist: Twist, period_s: f64) -> (f64, f64, f64) {
        let (lateral_after, heading_after, chord) = advance(lateral, heading, twist, period_s);
        let along = chord / (1.0 - self.curvature_1_m * lateral);
        (lateral_after, heading_after - self.curvature_1_m * along, along)
    }

    /// Drives it for a while. The law is told where the robot will stand when its command takes effect, as the navigator tells it.
    pub(crate) fn drive(&self, law: &mut dyn ControlLaw, duration_s: f64) -> Run {
        const SUBSTEPS: usize = 40;
        let (mut y, mut heading, mut x) = (self.lateral_m, self.heading_rad, 0.0);
        let (mut true_twist, mut commanded, mut measured) = (Twist::default(), Twist::default(), Twist::default());
        let (mut trace, mut commands) = (Vec::new(), Vec::new());
        let decay = libm::exp(-PERIOD_S / SUBSTEPS as f64 / self.lag_s);
        let approach = |now: f64, to: f64, keep: f64| to + (now - to) * keep;
        for _ in 0..(duration_s / PERIOD_S) as usize {
            trace.push((x, y, heading));
            // Prediction over the latency with the believed lag and turn ratio of the nominal robot.
            let share = 0.03 / PERIOD_S * (1.0 - libm::exp(-PERIOD_S / 0.03));
            let mean = Twist {
                speed_m_s: approach(true_twist.speed_m_s, commanded.speed_m_s, share),
                yaw_rate_rad_s: approach(true_twist.yaw_rate_rad_s / self.turn_ratio, commanded.yaw_rate_rad_s, share),
            };
            let (lateral, then, along) = self.advance(y, heading, mean, PERIOD_S);
            let state = PathState {
                lateral_m: lateral,
                heading_rad: then,
                curvature_1_m: self.curvature_1_m,
                slowing: 0.0,
                travelled_m: x + along,
                measured,
                period_s: PERIOD_S,
            };
            let next = law.twist(&state);
            let mut sum = Twist::default();
            for _ in 0..SUBSTEPS {
                true_twist.speed_m_s = approach(true_twist.speed_m_s, commanded.speed_m_s, decay);
                true_twist.yaw_rate_rad_s =
                    approach(true_twist.yaw_rate_rad_s, commanded.yaw_rate_rad_s * self.turn_ratio, decay);
                sum.speed_m_s += true_twist.speed_m_s / SUBSTEPS as f64;
                sum.yaw_rate_rad_s += true_twist.yaw_rate_rad_s / self.turn_ratio / SUBSTEPS as f64;
                let (lateral, then, along) = self.advance(y, heading, true_twist, PERIOD_S / SUBSTEPS as f64);
                (y, heading, x) = (lateral, then, x + along);
            }
            // What the encoders show: wheels, not the base.
            measured = sum;
            commanded = next;
            commands.push(next);
        }
        Run { trace, commands }
    }
}
