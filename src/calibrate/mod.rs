//! Calibration from files: tables of pixels and positions in, matrices and rigs out.
//!
//! - [`table`]: comma-separated files, with the place of everything that is wrong in them;
//! - [`points`]: pixel/position pairs of one laser (equation 14), with the lines they stand in;
//! - [`matrix`]: matrices T in table 1's form;
//! - [`linear`]: what comes of a table of points, by a T of its own or by a given one, as text and as JSON.
//!
//! The mathematics is [`ductloop_nav::calibration`]'s.

pub mod linear;
pub mod matrix;
pub mod points;
pub mod table;
