//! Which dimensions a fitting can have.

use super::{Fitting, Shape, elbow, transition};

/// Why a fitting cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FittingError {
    /// A length that must be positive is not.
    #[error("{what} is {value_m} m; it must be positive and finite")]
    NotPositive {
        /// Which length.
        what: &'static str,
        /// Its value.
        value_m: f64,
    },
    /// An angle outside what the fitting can turn.
    #[error("a turn of {angle_deg} degrees; it must be between 1 and {max_deg} degrees either way")]
    Angle {
        /// The angle asked for.
        angle_deg: f64,
        /// The largest that this fitting can have.
        max_deg: f64,
    },
    /// An angle that is no turn of the way through, outside what the fitting can have.
    #[error("{what} is {angle_deg} degrees; it must be between {low_deg} and {high_deg} degrees")]
    OutOfRange {
        /// Which angle.
        what: &'static str,
        /// The angle asked for.
        angle_deg: f64,
        /// The least.
        low_deg: f64,
        /// The most.
        high_deg: f64,
    },
    /// A length that is too large beside another.
    #[error("{what} is {value_m} m; it must be at most {limit_m} m, {reason}")]
    TooLarge {
        /// Which length.
        what: &'static str,
        /// Its value.
        value_m: f64,
        /// The most that it can be.
        limit_m: f64,
        /// What limits it.
        reason: &'static str,
    },
}

/// Rounding of dimensions that are just at a limit, in metres or as a share of an angle.
const ROUNDING: f64 = 1e-9;

fn positive(what: &'static str, value_m: f64) -> Result<(), FittingError> {
    if value_m > 0.0 && value_m.is_finite() { Ok(()) } else { Err(FittingError::NotPositive { what, value_m }) }
}

fn turn(angle_rad: f64, max_deg: f64) -> Result<(), FittingError> {
    let angle_deg = angle_rad.to_degrees();
    if (1.0 - ROUNDING..=max_deg + ROUNDING).contains(&angle_deg.abs()) {
        Ok(())
    } else {
        Err(FittingError::Angle { angle_deg, max_deg })
    }
}

fn within(what: &'static str, angle_rad: f64, [low_deg, high_deg]: [f64; 2]) -> Result<(), FittingError> {
    let angle_deg = angle_rad.to_degrees();
    if (low_deg - ROUNDING..=high_deg + ROUNDING).contains(&angle_deg) {
        Ok(())
    } else {
        Err(FittingError::OutOfRange { what, angle_deg, low_deg, high_deg })
    }
}

/// A positive length up to a limit.
fn up_to(what: &'static str, value_m: f64, limit_m: f64, reason: &'static str) -> Result<(), FittingError> {
    positive(what, value_m)?;
    at_most(what, value_m, limit_m, reason)
}

fn at_most(what: &'static str, value_m: f64, limit_m: f64, reason: &'static str) -> Result<(), FittingError> {
    // A value that is no number is above every limit.
    if value_m <= limit_m + ROUNDING { Ok(()) } else { Err(FittingError::TooLarge { what, value_m, limit_m, reason }) }
}

impl Fitting {
    /// Checks that the fitting can be made.
    ///
    /// # Errors
    /// The first dimension that is impossible.
    pub fn validate(&self) -> Result<(), FittingError> {
        positive("the width", self.width_m)?;
        positive("the height", self.height_m)?;
        match self.shape {
            Shape::Straight { length_m } | Shape::Damper { length_m, .. } => positive("the length", length_m),
            Shape::RadiusElbow { angle_rad, throat_radius_m } => {
                positive("the throat radius", throat_radius_m)?;
                turn(angle_rad, 180.0)
            }
            Shape::MitredElbow { angle_rad } | Shape::VanedElbow { angle_rad } => turn(angle_rad, 120.0),
            Shape::Transition { length_m, to_width_m, to_height_m, .. } => {
                positive("the length", length_m)?;
                positive("the width at the end", to_width_m)?;
                positive("the height at the end", to_height_m)?;
                let drawn_in_m = transition::most_drawn_in_m(self);
                at_most("what one side draws in by", drawn_in_m, length_m, "the length: 45 degrees")
            }
            Shape::Offset { length_m, aside_m } => {
                positive("the length", length_m)?;
                up_to("the offset", aside_m.abs(), length_m, "the length")?;
                let radius_m = elbow::offset_radius_m(length_m, aside_m);
                at_most("half the width", self.width_m / 2.0, radius_m - 1e-3, "the radius of the offset's arcs less 1 mm")
            }
            Shape::Slope { length_m, angle_rad } => {
                positive("the length", length_m)?;
                within("the slope", angle_rad, [-10.0, 10.0])
            }
            Shape::Tee { branch_width_m, .. } | Shape::BullheadTee { branch_width_m } | Shape::Cross { branch_width_m } => {
                positive("the branch's width", branch_width_m)
            }
            Shape::SideBranch { branch_width_m, shoe_m, .. } => {
                positive("the branch's width", branch_width_m)?;
                positive("the shoe", shoe_m)
            }
            Shape::Wye { half_angle_rad, branch_width_m } => {
                positive("the branches' width", branch_width_m)?;
                within("the angle of each branch", half_angle_rad, [30.0, 60.0])
            }
            Shape::Grille { length_m, side, opening_length_m, opening_height_m } => {
                positive("the length", length_m)?;
                up_to("the opening's length", opening_length_m, length_m, "the length of the duct")?;
                match side {
                    super::GrilleSide::Ceiling => {
                        up_to("the opening's width", opening_height_m, self.width_m, "the width of the duct")
                    }
                    _ => up_to("the opening's height", opening_height_m, self.height_m, "the height of the duct"),
                }
            }
            Shape::Drop { length_m, hole_length_m, hole_width_m, depth_m } => {
                positive("the length", length_m)?;
                up_to("the hole's length", hole_length_m, length_m, "the length of the duct")?;
                up_to("the hole's width", hole_width_m, self.width_m, "the width of the duct")?;
                positive("the depth", depth_m)
            }
        }
    }
}
