//! The presets: partial scenarios that come with the program, laid beneath what a file says.

/// Words for `robot.preset`.
pub(super) const ROBOTS: &[&str] = &["incra1", "none"];

/// Words for `sensor.preset`.
pub(super) const SENSORS: &[&str] = &["incra1", "wide", "none"];

/// Surfaces that every scenario knows.
pub(super) const SURFACES: &[(&str, &str)] = &[
    ("galvanised", include_str!("../../presets/surface/galvanised.toml")),
    ("galvanised-dusty", include_str!("../../presets/surface/galvanised-dusty.toml")),
    ("galvanised-spangled", include_str!("../../presets/surface/galvanised-spangled.toml")),
    ("greasy", include_str!("../../presets/surface/greasy.toml")),
    ("mirror", include_str!("../../presets/surface/mirror.toml")),
    ("painted", include_str!("../../presets/surface/painted.toml")),
    ("rubber", include_str!("../../presets/surface/rubber.toml")),
];

/// The robot of this name.
pub(super) fn robot(name: &str) -> Option<&'static str> {
    (name == "incra1").then_some(include_str!("../../presets/robot/incra1.toml"))
}

/// The sensor of this name.
pub(super) fn sensor(name: &str) -> Option<&'static str> {
    match name {
        "incra1" => Some(include_str!("../../presets/sensor/incra1.toml")),
        "wide" => Some(include_str!("../../presets/sensor/wide.toml")),
        _ => None,
    }
}
