//! Parameters of the filter. Deviations are standard deviations.

/// Parameters of [`super::Estimator`].
///
/// What grows with the way is a random walk: its variance is proportional to the way, and the deviation is that after one metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimationParams {
    /// Deviation of what a side's rims travel against what its wheels turn, after one metre, in metres.
    pub wheel_slip_m: f64,
    /// Deviation of the base's drift sideways, after one metre, in metres.
    pub side_slip_m: f64,
    /// Deviation of the heading after turning by one radian, in radians: what W_eff does not explain.
    pub turn_slip_rad: f64,
    /// Deviation of the duct's width as it is told, in metres.
    pub width_m: f64,
    /// Deviation by which the width changes in one metre, in metres.
    pub width_walk_m: f64,
    /// Deviation of the effective track as it is told, as a share of it.
    pub track_ratio: f64,
    /// Deviation by which the effective track changes in one metre, as a share of what is told.
    pub track_walk_ratio: f64,
    /// Deviation of x_ICR from the base's origin, in metres.
    pub icr_m: f64,
    /// Deviation by which x_ICR changes in one metre, in metres.
    pub icr_walk_m: f64,
    /// Way over which the walls' errors persist: after it their correlation is 1/e, in metres.
    pub correlation_m: f64,
    /// Share of the variance of the walls' errors that persists so; the rest is new in every frame.
    pub correlated_share: f64,
    /// Factor on the deviations that a perception states.
    pub stated_ratio: f64,
    /// Deviation of a wall's distance from a perception that states none, in metres.
    pub unstated_distance_m: f64,
    /// Deviation of the heading from a perception that states none, in radians.
    pub unstated_heading_rad: f64,
    /// Probability with which the gate lets through what is no outlier.
    pub gate_probability: f64,
    /// So many frames refused in succession make the filter begin anew from the next one.
    pub gate_run: usize,
    /// Deviation of the estimated lateral offset beyond which the navigator calls itself degraded, in metres.
    pub uncertain_lateral_m: f64,
    /// The same of the heading, in radians.
    pub uncertain_heading_rad: f64,
}

impl Default for EstimationParams {
    fn default() -> Self {
        Self {
            wheel_slip_m: 0.05e-3,
            side_slip_m: 0.03e-3,
            turn_slip_rad: 0.25_f64.to_radians(),
            width_m: 0.02,
            width_walk_m: 0.01e-3,
            track_ratio: 0.05,
            track_walk_ratio: 0.01,
            icr_m: 0.02,
            icr_walk_m: 1e-3,
            correlation_m: 10.0,
            correlated_share: 0.25,
            stated_ratio: 1.0,
            unstated_distance_m: 0.5e-3,
            unstated_heading_rad: 0.1_f64.to_radians(),
            gate_probability: 0.999,
            gate_run: 5,
            uncertain_lateral_m: 0.02,
            uncertain_heading_rad: 3.0_f64.to_radians(),
        }
    }
}
