//! From pixels whose position in space is known to the sensor's geometry: what INCRA I's makers did with a block gauge.
//!
//! - [`pairs`]: pixel and position together, and what is wrong with a set of them;
//! - [`scaling`]: pixels and positions moved and scaled to the size of one, so that their squares stay comparable;
//! - [`triangle`]: least squares with fixed memory: rows rotated into a triangle one by one; [`singular`]: its rank and condition;
//! - [`linear`]: the paper's matrix T of one laser (equation 14), no physics in it;
//! - [`levenberg`]: nonlinear least squares with a robust loss, and covariance;
//! - [`model`]: the rig itself, one camera and several planes, from the same pairs of all lasers together; `first_guess`: where its
//!   fit starts;
//! - [`boards`]: a laser's plane from stripes on boards of known pose.
//!
//! Mathematics only. Positions are in millimetres here, as the paper's tables have them.

pub mod boards;
mod first_guess;
pub mod levenberg;
pub mod linear;
pub mod model;
pub mod pairs;
pub mod scaling;
pub mod singular;
pub mod triangle;
