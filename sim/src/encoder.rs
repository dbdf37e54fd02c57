//! Incremental encoder on the motor shaft.

use std::f64::consts::TAU;

use crate::spec::DriveSpec;

/// Counts since power-on of an ideal quadrature encoder: the shaft's angle, quantised downward, so that the same angle gives
/// the same count from either direction. `wheel_angle_rad` is the shaft's angle divided by the gear ratio.
pub fn counts(drive: &DriveSpec, wheel_angle_rad: f64) -> i64 {
    let turns = wheel_angle_rad * drive.gear_ratio / TAU;
    // A run of 2^53 counts is longer than any robot lasts; the cast saturates beyond i64.
    (turns * f64::from(drive.counts_per_motor_turn)).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::RobotSpec;

    #[test]
    fn counts_step_down_at_the_same_angles_as_up() {
        let drive = RobotSpec::incra1().drive;
        let count_rad = TAU / (drive.gear_ratio * f64::from(drive.counts_per_motor_turn));
        for n in [-3_i64, -1, 0, 1, 66_000] {
            assert_eq!(counts(&drive, (n as f64 + 0.25) * count_rad), n);
            assert_eq!(counts(&drive, (n as f64 + 0.75) * count_rad), n);
        }
    }
}
