//! The mount: how it is driven, its play and its encoders.

use super::field::Slot;
use super::{Field, Kind, Scale, TableRow};

pub(super) const TABLES: &[TableRow] =
    &[TableRow::new("mount_control", "The mount and its controller: acceleration, play, encoders, a swing to keep up.")];

pub(super) const FIELDS: &[Field] = &[
    Field::new(
        "mount_control.acceleration_rad_s2",
        Kind::NumberOr { min: 0.01, max: 1e5, word: "unlimited" },
        Slot::NumberOr(|s| &mut s.mount_control.acceleration_rad_s2, Scale::Si),
    )
    .unit("rad/s2")
    .default("\"unlimited\"")
    .about("Largest angular acceleration, pan and tilt each."),
    Field::number("mount_control.backlash_deg", 0.0, 20.0, |s| &mut s.mount_control.backlash_rad)
        .degrees()
        .default("0.0")
        .about("Play between each motor, where the encoder is, and the camera."),
    Field::number("mount_control.encoder_step_deg", 0.0, 10.0, |s| &mut s.mount_control.encoder_step_rad)
        .degrees()
        .default("0.0")
        .about("Angle of one encoder count, by which the navigator is told the mount's angles; 0 tells them as they are."),
    Field::number("mount_control.sweep_pan_deg", -90.0, 90.0, |s| &mut s.mount_control.sweep.amplitude.pan_rad)
        .degrees()
        .default("0.0")
        .about("Amplitude of the swing in pan that the mount keeps up about the commanded angles; 0 holds them."),
    Field::number("mount_control.sweep_tilt_deg", -90.0, 90.0, |s| &mut s.mount_control.sweep.amplitude.tilt_rad)
        .degrees()
        .default("0.0")
        .about("The same in tilt."),
    Field::number("mount_control.sweep_period_s", 0.05, 600.0, |s| &mut s.mount_control.sweep.period_s)
        .unit("s")
        .default("4.0")
        .about("Time from one swing to the next."),
];
