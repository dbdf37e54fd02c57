//! Where the robot stands, out of what its wheels turned and what its walls looked like.
//!
//! In data-flow order:
//!
//! - [`motion`]: the wheels' travels to a motion of the base, by effective track and centre of rotation;
//! - `belief`: mean and covariance; a step of the wheels, a look at the walls;
//! - [`chi_square`]: which looks are outliers;
//! - [`Estimator`]: an extended Kalman filter of these, with looks that come late put where they belong;
//! - [`localiser`]: what the navigator asks: the filter, or, as the paper had none, the last measurement carried on by the wheels.
//!
//! `docs/estimation.md` has the model, its figures and how consistent it is.

mod belief;
pub mod chi_square;
mod estimator;
pub mod localiser;
pub mod motion;
mod params;

pub use estimator::{Estimate, Estimator, Outcome};
pub use motion::Travel;
pub use params::EstimationParams;
