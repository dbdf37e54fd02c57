//! The robot's own code: what INCRA I's command controller (CC), wheel controller (WC) and mount controller (MC)
//! would run.
//!
//! In data-flow order:
//!
//! - [`messages`]: what comes in (frames, encoder counts, mount angles, time) and what goes out (commands);
//! - [`rig`]: the camera, the mount and the laser planes, as parameters;
//! - [`perception`]: a frame to lateral and heading error;
//! - [`odometry`]: encoder counts to motion;
//! - [`estimation`]: both together, each weighed by how sure it is: where the robot stands;
//! - [`control`]: errors to a twist;
//! - [`frozen`]: whether the camera still exposes;
//! - [`swapped_wheels`]: whether the wheels turn the way they are told;
//! - [`exposure`]: how bright the stripes are, to the next frame's exposure and laser power;
//! - [`navigator`]: all of these, once a frame;
//! - [`wheel_controller`]: wheel speeds to motor duty, at its own rate;
//! - [`mount_controller`]: mount angles and swings to where the mount's motors are to turn, at its own rate.
//!
//! [`planar`] has poses seen from above. Beside the loop: [`calibration`], pixels of known position to the rig; [`mapping`], ranges to what an inspection is for.
//!
//! Mathematics only: no clock, no files, no threads, no randomness. Time is an argument.
#![forbid(unsafe_code)]

pub mod ahead;
pub mod angle;
pub mod calibration;
pub mod control;
pub mod course;
pub mod estimation;
pub mod exposure;
pub mod frozen;
pub mod mapping;
pub mod messages;
pub mod mount_controller;
pub mod navigator;
pub mod odometry;
pub mod perception;
pub mod planar;
pub mod rig;
pub mod swapped_wheels;
pub mod wheel_controller;
