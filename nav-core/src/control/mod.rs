//! Control laws: from the errors to a twist. One file each behind one interface, one set of limits for all of them.
//!
//! `docs/control.md` compares them. The signs are those of the robot: `lateral_m` and `heading_rad` are where the robot is
//! relative to the path, so that the errors of the sources, path less robot, are their negatives.

mod cruise;
pub mod kanayama;
pub mod koh_cho;
pub mod koh_cho_printed;
pub mod limits;
pub mod lqr;
pub mod pure_pursuit;
pub mod samson;
pub mod stanley;
mod target;

/// Where the robot will stand relative to its path when the command takes effect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathState {
    /// Offset from the path, left positive, in metres.
    pub lateral_m: f64,
    /// Heading relative to the path, anticlockwise positive, in radians.
    pub heading_rad: f64,
    /// Curvature of the path there, in 1/m, positive to the left.
    pub curvature_1_m: f64,
    /// By which share the robot is to be slower than its usual speed, from 0 to 1: before bends and ends.
    pub slowing: f64,
    /// Distance travelled along the path since the start, by odometry, in metres.
    pub travelled_m: f64,
    /// Motion that the encoders show: the mean over the frame before the exposure. What was commanded since is not in it.
    pub measured: Twist,
    /// Time from the last command to this one, in seconds: a frame period, more where frames were lost.
    pub period_s: f64,
}

/// Motion of the base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed, in m/s.
    pub speed_m_s: f64,
    /// Yaw rate, anticlockwise positive, in rad/s.
    pub yaw_rate_rad_s: f64,
}

/// Steers the base along its path.
pub trait ControlLaw: Send {
    /// The twist to command now.
    fn twist(&mut self, state: &PathState) -> Twist;

    /// Forgets all motion: the robot has been stopped and starts anew from here.
    fn reset(&mut self, travelled_m: f64);
}

impl<L: ControlLaw + ?Sized> ControlLaw for Box<L> {
    fn twist(&mut self, state: &PathState) -> Twist {
        (**self).twist(state)
    }

    fn reset(&mut self, travelled_m: f64) {
        (**self).reset(travelled_m);
    }
}

/// 1 - c d, by which speed along the path differs from speed along its parallel through the robot; kept off zero, where the robot
/// stands in the path's centre of curvature and every law's feed-forward is infinite.
fn lane_factor(curvature_1_m: f64, lateral_m: f64) -> f64 {
    (1.0 - curvature_1_m * lateral_m).max(0.1)
}
