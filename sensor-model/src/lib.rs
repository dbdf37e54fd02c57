//! What the camera would see.
#![forbid(unsafe_code)]
pub mod optics;
