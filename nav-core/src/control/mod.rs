//! Control laws: from the errors to a twist. One file each behind one interface.

pub mod koh_cho;

/// Where the robot will stand relative to its path when the command takes effect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathState {
    /// Offset from the path, left positive, in metres.
    pub lateral_m: f64,
    /// Heading relative to the path, anticlockwise positive, in radians.
    pub heading_rad: f64,
    /// Curvature of the path there, in 1/m, positive to the left.
    pub curvature_1_m: f64,
    /// Distance travelled along the path since the start, by odometry, in metres.
    pub travelled_m: f64,
    /// Time until the next command, in seconds.
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
