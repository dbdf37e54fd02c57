//! Calibration from files: tables of pixels and positions in, matrices and rigs out.
//!
//! - [`table`]: comma-separated files, with the place of everything that is wrong in them;
//! - [`points`]: pixel/position pairs of one laser (equation 14), with the lines they stand in;
//! - [`matrix`]: matrices T in table 1's form;
//! - [`linear`]: what comes of a table of points, by a T of its own or by a given one, as text and as JSON;
//! - [`camera`]: a camera out of a file; [`model`]: the rig itself from the points of several lasers;
//! - [`boards`]: a laser's plane from its stripe on boards of known pose; [`pictures`]: the stripe out of their pictures;
//! - [`gauge`]: the paper's experiment with a block gauge, from rendered images.
//!
//! The mathematics is [`ductloop_nav::calibration`]'s.

pub mod boards;
pub mod camera;
pub mod gauge;
pub mod linear;
pub mod matrix;
pub mod model;
pub mod pictures;
mod places;
pub mod points;
pub mod table;
