//! Whether a navigator's command is one that a body can be given: numbers that are none must not reach wheels, mount or camera.
//!
//! In the integer wheel loop NaN would pass for standstill, in `f64` for a duty that is none, and a run would go on, or end, without a
//! word of whose fault it is. Speeds beyond what the motors reach are no nonsense: the wheel controller limits them.

use ductloop_nav::messages::Command;

/// Faster than any wheel of a robot here, in rad/s: beyond it a command is nonsense.
const MAX_WHEEL_SPEED_RAD_S: f64 = 1e4;
/// Exposures, in seconds: wider than what scenarios let automatic exposure choose, so that rounding does not matter.
const EXPOSURE_S: [f64; 2] = [1e-6, 10.0];
/// Laser power, as a share of the nominal one: the same.
const LASER_POWER: [f64; 2] = [0.0, 100.0];

/// Says what of `command` is out of bounds.
///
/// # Errors
/// The first such number, named, with its bounds.
pub(crate) fn check(command: &Command) -> Result<(), String> {
    let turn = std::f64::consts::TAU;
    let Command { wheel_speed_rad_s: wheels, mount, sweep, exposure_s, laser_power } = command;
    within("the left wheels' speed", wheels.left, MAX_WHEEL_SPEED_RAD_S)?;
    within("the right wheels' speed", wheels.right, MAX_WHEEL_SPEED_RAD_S)?;
    within("pan", mount.pan_rad, turn)?;
    within("tilt", mount.tilt_rad, turn)?;
    if let Some(sweep) = sweep {
        within("the swing's pan", sweep.amplitude.pan_rad, turn)?;
        within("the swing's tilt", sweep.amplitude.tilt_rad, turn)?;
        between("the swing's period", Some(sweep.period_s), [1e-3, 1e6])?;
    }
    between("the exposure", *exposure_s, EXPOSURE_S)?;
    between("the laser power", *laser_power, LASER_POWER)
}

fn within(name: &str, value: f64, most: f64) -> Result<(), String> {
    // A comparison with NaN is false.
    if value.abs() <= most { Ok(()) } else { Err(format!("{name} is {value}, not within {most} of zero")) }
}

fn between(name: &str, value: Option<f64>, [least, most]: [f64; 2]) -> Result<(), String> {
    match value {
        Some(value) if !(least..=most).contains(&value) => Err(format!("{name} is {value}, not within {least} to {most}")),
        _ => Ok(()),
    }
}
