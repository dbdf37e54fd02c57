//! The mount controller (MC): turns commanded mount angles and swings into the angle that each of the mount's motors is to have now.
//!
//! Holding without an acceleration limit, that is the commanded angle at once: the motor goes there as fast as it can. With one, the
//! angle runs a trapezoid of speed: it speeds up and slows down by the limit, no faster than the rate limit, and ends at rest where
//! it was to go. A swing is amplitude times sin(2 pi t / period) about the commanded angles, in time t since it began; the same
//! trapezoid bounds it, so that a swing which asks for too much comes out smaller.

use std::f64::consts::TAU;

use crate::messages::MountSweep;
use crate::rig::MountAngles;

/// What the mount's motors are driven with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountParams {
    /// Time between calls, in seconds.
    pub period_s: f64,
    /// Fastest turn, pan and tilt each, in rad/s.
    pub rate_rad_s: f64,
    /// Largest angular acceleration, pan and tilt each, in rad/s2; `None`: what the motors can.
    pub acceleration_rad_s2: Option<f64>,
}

/// Where pan and tilt are to go, and where they are to be now.
#[derive(Clone, Debug, PartialEq)]
pub struct MountController {
    params: MountParams,
    about: MountAngles,
    sweep: Option<MountSweep>,
    /// Calls since the swing began.
    ticks: u64,
    pan: Axis,
    tilt: Axis,
}

/// One axis' reference.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    angle_rad: f64,
    rate_rad_s: f64,
}

impl MountController {
    /// At rest at `rest`, to be held.
    pub fn new(params: MountParams, rest: MountAngles) -> Self {
        let axis = |angle_rad| Axis { angle_rad, rate_rad_s: 0.0 };
        Self { params, about: rest, sweep: None, ticks: 0, pan: axis(rest.pan_rad), tilt: axis(rest.tilt_rad) }
    }

    /// A command has come: the angles to go to, and how to swing about them. The swing that it is in already goes on.
    pub fn command(&mut self, about: MountAngles, sweep: Option<MountSweep>) {
        self.about = about;
        if sweep != self.sweep {
            self.sweep = sweep;
            self.ticks = 0;
        }
    }

    /// The angles that the motors are to have until the next call.
    pub fn tick(&mut self) -> MountAngles {
        let MountAngles { pan_rad, tilt_rad } = self.due();
        self.ticks = self.ticks.saturating_add(1);
        MountAngles { pan_rad: self.pan.step(&self.params, pan_rad), tilt_rad: self.tilt.step(&self.params, tilt_rad) }
    }

    /// What is commanded for now.
    fn due(&self) -> MountAngles {
        let Some(MountSweep { amplitude, period_s }) = self.sweep else { return self.about };
        let swings = self.ticks as f64 * self.params.period_s / period_s;
        let share = libm::sin(TAU * (swings - swings.floor()));
        MountAngles {
            pan_rad: self.about.pan_rad + amplitude.pan_rad * share,
            tilt_rad: self.about.tilt_rad + amplitude.tilt_rad * share,
        }
    }
}

impl Axis {
    fn step(&mut self, params: &MountParams, to_rad: f64) -> f64 {
        let Some(limit) = params.acceleration_rad_s2 else {
            self.angle_rad = to_rad;
            return to_rad;
        };
        let dt = params.period_s;
        let left_rad = to_rad - self.angle_rad;
        let most = limit * dt;
        if left_rad.abs() <= most * dt && self.rate_rad_s.abs() <= most {
            *self = Self { angle_rad: to_rad, rate_rad_s: 0.0 };
            return to_rad;
        }
        // Slowed by `most` a tick from v on, it covers v^2 / (2 limit) + v dt / 2: the v at which that is what is left.
        let stopping = 0.5 * most * ((1.0 + 8.0 * left_rad.abs() / (most * dt)).sqrt() - 1.0);
        let wanted = stopping.min(params.rate_rad_s).copysign(left_rad);
        self.rate_rad_s += (wanted - self.rate_rad_s).clamp(-most, most);
        self.angle_rad += self.rate_rad_s * dt;
        self.angle_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: MountParams = MountParams { period_s: 1.0 / 1200.0, rate_rad_s: 2.0, acceleration_rad_s2: None };

    fn pan(pan_rad: f64) -> MountAngles {
        MountAngles { pan_rad, tilt_rad: 0.0 }
    }

    #[test]
    fn what_is_to_be_held_is_due_at_once() {
        let mut mount = MountController::new(PARAMS, pan(0.1));
        assert_eq!(mount.tick(), pan(0.1));
        mount.command(pan(0.7), None);
        assert_eq!(mount.tick(), pan(0.7));
    }

    /// Closed form: 1 rad at 2 rad/s and 10 rad/s2 is 0.2 s up, 0.3 s at rate, 0.2 s down; a short way, 0.1 rad, 2 sqrt(0.1/10) s.
    #[test]
    fn with_an_acceleration_limit_it_runs_a_trapezoid() {
        let limit = 10.0;
        let params = MountParams { acceleration_rad_s2: Some(limit), ..PARAMS };
        for (way, takes_s) in [(1.0, 0.7), (0.1, 0.2), (-1.0, 0.7)] {
            let mut mount = MountController::new(params, pan(0.0));
            mount.command(pan(way), None);
            let (mut before, mut rate, mut ticks) = (0.0, 0.0, 0);
            while before != way {
                let now = mount.tick().pan_rad;
                let (moved, most) = ((now - before) / params.period_s, limit * params.period_s);
                // Ends as it began, so the last snap stays within one step of rate too: two steps, rounding aside.
                assert!((moved - rate).abs() <= 2.0 * most + 1e-9, "{way}: {moved} after {rate}");
                assert!(moved.abs() <= params.rate_rad_s + 1e-9, "{way}: {moved}");
                // A speed between two multiples of limit times period covers up to an eighth of limit period^2 more than the law says.
                let past = limit * params.period_s * params.period_s;
                assert!(now.abs() <= way.abs() + past, "{way}: {now}");
                (before, rate, ticks) = (now, moved, ticks + 1);
                assert!(ticks < 2000, "{way}: it does not arrive");
            }
            // Sampling costs a tick at each of the trapezoid's corners.
            assert!((f64::from(ticks) * params.period_s - takes_s).abs() < 4.0 * params.period_s, "{way}: {ticks}");
        }
    }

    #[test]
    fn a_swing_is_a_sine_that_the_same_command_does_not_begin_anew() {
        let sweep = MountSweep { amplitude: MountAngles { pan_rad: 0.3, tilt_rad: -0.1 }, period_s: 2.0 };
        let mut mount = MountController::new(PARAMS, pan(0.0));
        for tick in 0..4800 {
            mount.command(pan(0.05), Some(sweep));
            let sine = libm::sin(TAU * f64::from(tick) / 2400.0);
            let MountAngles { pan_rad, tilt_rad } = mount.tick();
            // Rounding of the phase.
            assert!((pan_rad - 0.05 - 0.3 * sine).abs() < 1e-12 && (tilt_rad + 0.1 * sine).abs() < 1e-12, "{tick}");
        }
        mount.command(pan(0.05), None);
        assert_eq!(mount.tick(), pan(0.05));
        // Another swing begins at its beginning.
        mount.command(pan(0.05), Some(sweep));
        assert_eq!(mount.tick(), pan(0.05));
    }

    /// A swing of 0.3 rad in 0.5 s asks for 47 rad/s2 where 10 are allowed: what comes out keeps to the limit.
    #[test]
    fn a_swing_that_asks_too_much_comes_out_smaller() {
        let params = MountParams { acceleration_rad_s2: Some(10.0), ..PARAMS };
        let mut mount = MountController::new(params, pan(0.0));
        mount.command(pan(0.0), Some(MountSweep { amplitude: pan(0.3), period_s: 0.5 }));
        let angles: Vec<f64> = (0..6000).map(|_| mount.tick().pan_rad).collect();
        let most = angles[1200..].iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
        assert!((0.02..0.25).contains(&most), "{most}");
        for three in angles.windows(3) {
            let acceleration = (three[2] - 2.0 * three[1] + three[0]) / (params.period_s * params.period_s);
            // Twice, where it snaps onto what is due.
            assert!(acceleration.abs() <= 20.0 + 1e-6, "{acceleration}");
        }
    }
}
