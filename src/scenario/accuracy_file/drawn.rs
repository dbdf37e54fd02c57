//! What `[poses]` may draw: its keys, with what each lies between.

/// A key of `[poses]` that is drawn between two ends.
pub(in crate::scenario) struct Drawn {
    pub(super) key: &'static str,
    /// Within which both ends must lie, in the key's unit.
    pub(super) bounds: [f64; 2],
    pub(super) unit: &'static str,
    pub(super) about: &'static str,
}

const fn drawn(key: &'static str, bounds: [f64; 2], unit: &'static str, about: &'static str) -> Drawn {
    Drawn { key, bounds, unit, about }
}

/// All of them.
pub(in crate::scenario) const DRAWN: [Drawn; 5] = [
    drawn("wall_m", [0.01, 5.0], "m", "Distance of either wall from the camera: gives lateral offset and width."),
    drawn("width_m", [0.05, 10.0], "m", "Width of the duct."),
    drawn("lateral_m", [-5.0, 5.0], "m", "Lateral offset of the base, left positive."),
    drawn("heading_deg", [-90.0, 90.0], "deg", "Heading, anticlockwise positive."),
    drawn("distance_m", [0.0, 1e5], "m", "Distance along the centreline."),
];
