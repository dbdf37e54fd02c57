//! The survey: what a run makes known of the duct, from what the robot believed, and how far that is from the truth.
//!
//! - [`notes`]: what a run notes for it while it goes on;
//! - [`cloud`]: the lit points in the world, thinned out by voxels; [`ply`] writes them as `survey.ply`;
//! - [`path`]: the straights of the reference path, which the ducts of the log are held against, and the junctions that were passed;
//! - [`deposits`]: what lies on the floor, against what the scenario laid there;
//! - [`drift`]: how far the believed place is from the true one;
//! - [`document`]: `survey.json`, and the figures that metrics take from it.
//!
//! Cloud and log come from *estimated* poses alone: nothing of the truth is in them but where the run began, which whoever puts a robot into
//! a duct knows.

pub mod cloud;
pub mod deposits;
pub mod document;
pub mod drift;
pub mod notes;
pub mod path;
pub mod ply;

pub use cloud::Cloud;
pub use document::Survey;
pub use notes::Notes;
