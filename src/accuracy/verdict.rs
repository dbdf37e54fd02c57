//! The figures as a document, and what `[pass]` says of them.

use serde_json::{Value, json};

use super::figures::{Figures, Spread};
use crate::scenario::accuracy_file::PassBound;

/// A bound that does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Miss {
    /// Which bound.
    pub bound: PassBound,
    /// The figure in the bound's unit; `None` where there is none.
    pub value: Option<f64>,
}

/// The document of one pipeline's figures.
pub fn document(figures: &Figures) -> Value {
    let at = |(cell, pose): (usize, u64)| json!({"cell": cell, "pose": pose});
    let spread = |spread: &Spread| {
        json!({
            "there": spread.there, "measured": spread.count, "bias": spread.bias(), "rms": spread.rms(), "worst": spread.worst(),
            "worst_at": spread.worst_at().map(at),
            "nees": spread.nees(), "bound": spread.bound(), "bound_ratio": spread.bound_ratio(),
        })
    };
    let centres = &figures.centres;
    json!({
        "poses": figures.poses,
        "detected": figures.detected,
        "wall_distance_rms_m": figures.wall_distance.rms(),
        "heading_rms_rad": figures.heading.rms(),
        "lateral_rms_m": figures.lateral.rms(),
        "nees": figures.nees(),
        "bound_ratio": {
            "wall_distance": figures.wall_distance.bound_ratio(),
            "heading": figures.heading.bound_ratio(),
            "lateral": figures.lateral.bound_ratio(),
        },
        "shown": figures.shown,
        "detection": figures.detection(),
        "within_3_sigma": figures.within_3_sigma(),
        "beyond_6_sigma": figures.beyond_6_sigma(),
        "beyond_6_sigma_poses": figures.beyond_6_sigma.iter().copied().map(at).collect::<Vec<_>>(),
        "centres_rms_px": centres.rms_px(),
        "centres": {
            "precision": centres.precision(), "recall": centres.recall(), "rms_px": centres.rms_px(), "nees": centres.mean_nees(),
        },
        "lines_rms_px": figures.lines.rms_px(),
        "wall_distance_m": spread(&figures.wall_distance),
        "wall_heading_rad": spread(&figures.wall_heading),
        "wall_normal_rad": spread(&figures.wall_normal),
        "heading_rad": spread(&figures.heading),
        "lateral_m": spread(&figures.lateral),
    })
}

/// The bounds that do not hold. `figures` gives the document of a pipeline. A figure that was not measured holds no bound.
pub fn misses<'a>(bounds: &[PassBound], figures: impl Fn(&PassBound) -> Option<&'a Value>) -> Vec<Miss> {
    let missed = |bound: &PassBound| {
        let mut value = figures(bound);
        for step in bound.bound.figure.split('.') {
            value = value.and_then(|value| value.get(step));
        }
        let value = value.and_then(Value::as_f64).map(|value| value / bound.bound.scale);
        let holds = value.is_some_and(|value| if bound.bound.is_least() { value >= bound.value } else { value <= bound.value });
        (!holds).then_some(Miss { bound: *bound, value })
    };
    bounds.iter().filter_map(missed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Pipeline;
    use crate::scenario::accuracy_file::BOUNDS;

    #[test]
    fn every_bound_has_a_figure_and_what_was_not_measured_holds_none() {
        let empty = document(&Figures::default());
        for bound in BOUNDS {
            let mut value = Some(&empty);
            for step in bound.figure.split('.') {
                value = value.and_then(|value| value.get(step));
            }
            assert!(value.is_some(), "{}", bound.figure);
        }
        let bound = |key: &str, value: f64| {
            let bound = BOUNDS.iter().find(|bound| bound.key == key).unwrap();
            PassBound { pipeline: Pipeline::Robust, bound, value }
        };
        let measured = json!({"wall_distance_rms_m": 0.000_29, "detection": 0.98, "nees": null});
        let of = |bounds: &[PassBound]| misses(bounds, |_| Some(&measured)).len();
        assert_eq!(of(&[bound("wall_distance_rms_mm", 0.3), bound("detection_min", 0.98)]), 0);
        assert_eq!(of(&[bound("wall_distance_rms_mm", 0.28), bound("detection_min", 0.99)]), 2);
        assert_eq!(of(&[bound("nees", 100.0)]), 1);
    }
}
