//! The sensor as a whole: its preset, exposure, and how the true rig differs from the nominal one.

use super::field::Slot;
use super::{Field, Kind, Scale, TableRow};
use crate::scenario::presets;

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("sensor", "The structured-light sensor: a preset, and what differs from it."),
    TableRow::new("sensor.auto_exposure", "What automatic exposure (`exposure = \"auto\"`) aims at and may choose."),
    TableRow::new("sensor.error", "How the true rig, which makes the images, differs from the nominal one, which reads them."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::new("sensor.preset", Kind::Word(presets::SENSORS), Slot::Fixed("\"none\""))
        .default("\"wide\"")
        .about("Where the rig's numbers come from; with \"none\" camera, mount, lasers and line must be given."),
    Field::new(
        "sensor.exposure",
        Kind::NumberOr { min: 0.01, max: 1000.0, word: "auto" },
        Slot::NumberOr(|s| &mut s.exposure_s, Scale::Si),
    )
    .milli("ms")
    .default("4.0")
    .about("Exposure of every frame; or \"auto\": the navigator chooses it and the laser power, from sensor.light.at_exposure_ms on."),
    Field::new("sensor.noise", Kind::Flag, Slot::Flag(|s| &mut s.optics.noise))
        .default("true")
        .about("Whether anything random is applied: shot, dark and read noise, unequal and hot pixels, speckle."),
    Field::number("sensor.auto_exposure.target_dn", 10.0, 240.0, |s| &mut s.auto_exposure.target_dn)
        .unit("DN")
        .default("100.0")
        .about("Height above its background that nine tenths of a stripe's columns peak at or below, in grey values of 8 bits."),
    Field::number("sensor.auto_exposure.min_ms", 0.01, 1000.0, |s| &mut s.auto_exposure.exposure_s[0])
        .milli("ms")
        .default("0.1")
        .about("Shortest exposure; if it is still too bright, the laser power goes down."),
    Field::number("sensor.auto_exposure.max_ms", 0.01, 1000.0, |s| &mut s.auto_exposure.exposure_s[1])
        .milli("ms")
        .default("15.0")
        .about("Longest exposure, for the sake of motion blur; if it is still too dark, the laser power goes up."),
    Field::number("sensor.auto_exposure.min_power", 0.001, 1.0, |s| &mut s.auto_exposure.laser_power[0])
        .default("0.1")
        .about("Least laser power as a share of nominal."),
    Field::number("sensor.auto_exposure.max_power", 0.001, 10.0, |s| &mut s.auto_exposure.laser_power[1])
        .default("4.0")
        .about("Most laser power as a share of nominal, which is the one that sensor.light.stripe_peak_dn holds for."),
    Field::number("sensor.error.pan_deg", -45.0, 45.0, |s| &mut s.rig_error.pan_rad)
        .degrees()
        .default("0.0")
        .about("True pan less the pan that the mount reports."),
    Field::number("sensor.error.tilt_deg", -45.0, 45.0, |s| &mut s.rig_error.tilt_rad)
        .degrees()
        .default("0.0")
        .about("True tilt less the tilt that the mount reports."),
    Field::number("sensor.error.roll_deg", -45.0, 45.0, |s| &mut s.rig_error.roll_rad)
        .degrees()
        .default("0.0")
        .about("True roll of the camera less its nominal roll."),
    Field::new(
        "sensor.error.laser_plane_deg",
        Kind::List { min: -45.0, max: 45.0 },
        Slot::List(|s| &mut s.rig_error.laser_plane_rad, Scale::Degrees),
    )
    .degrees()
    .or(super::Default::Computed("a zero for each laser"))
    .about("How far each laser's plane is turned about the camera's x axis through its source, in the lasers' order."),
];
