//! What the robot says lies ahead, held against the truth (`docs/navigation.md`, "Scores").
//!
//! In data-flow order:
//!
//! - `entrance`: what a fitting is to eyes that come to it by one of its ports;
//! - `obstacles`: objects that stand in the way;
//! - `reach`: how far the sensor sees;
//! - [`way`]: all of these along the path, and what is ahead of a place on it;
//! - [`glance`]: a frame: the truth, and what was named;
//! - `approach`: the frames before a fitting: named what, since when, how exactly;
//! - [`confusion`]: counts of what was true against what was named;
//! - [`document`]: a run's scores.
//!
//! The truth is that of the path of the scenario's route. A robot that has left it sees what no one expected it to see: its frames count
//! nowhere.

mod approach;
pub mod confusion;
pub mod document;
mod entrance;
pub mod glance;
mod obstacles;
mod reach;
pub mod way;

pub use approach::FittingScore;
pub use confusion::{Confusion, Pair};
pub use document::AheadScores;
pub use glance::{Glance, Named};
pub use way::{Thing, TrueAhead, Way};
