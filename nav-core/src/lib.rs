//! The robot's own code.
#![forbid(unsafe_code)]

pub mod angle;
pub mod messages;
pub mod rig;
