//! What `[pass]` of an accuracy file may bound.

use crate::scenario::Pipeline;

/// A key of `[pass.PIPELINE]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The key; one that ends in `_min` is a least value, every other a largest.
    pub key: &'static str,
    /// The figure's name in the document, a path with points.
    pub figure: &'static str,
    /// What one of the key's units is in the figure's.
    pub scale: f64,
    /// What it is, in one sentence.
    pub about: &'static str,
}

/// A bound of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassBound {
    /// Whose figure.
    pub pipeline: Pipeline,
    /// Which figure.
    pub bound: &'static Bound,
    /// The bound, in the key's unit.
    pub value: f64,
}

impl Bound {
    /// Whether the figure must be at least this large.
    pub fn is_least(&self) -> bool {
        self.key.ends_with("_min")
    }
}

const fn bound(key: &'static str, figure: &'static str, scale: f64, about: &'static str) -> Bound {
    Bound { key, figure, scale, about }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Every bound that there is.
pub const BOUNDS: &[Bound] = &[
    bound("wall_distance_rms_mm", "wall_distance_rms_m", 1e-3, "RMS error of the distances of walls, in mm"),
    bound("heading_rms_deg", "heading_rms_rad", DEGREE, "RMS error of the heading, in degrees"),
    bound("lateral_rms_mm", "lateral_rms_m", 1e-3, "RMS error of the lateral offset, in mm"),
    bound("centres_rms_px", "centres_rms_px", 1.0, "RMS error of the stripe centres, in pixels"),
    bound("nees", "nees", 1.0, "mean square of error over stated deviation"),
    bound("beyond_6_sigma", "beyond_6_sigma", 1.0, "poses with an error beyond six stated deviations"),
    bound("bound_ratio_wall_distance", "bound_ratio.wall_distance", 1.0, "RMS error of the distances of walls over its bound"),
    bound("bound_ratio_heading", "bound_ratio.heading", 1.0, "RMS error of the heading over its bound"),
    bound("bound_ratio_lateral", "bound_ratio.lateral", 1.0, "RMS error of the lateral offset over its bound"),
    bound("detection_min", "detection", 1.0, "share of the poses with an answer"),
    bound("within_3_sigma_min", "within_3_sigma", 1.0, "share of the poses with an answer right within three stated deviations"),
];
