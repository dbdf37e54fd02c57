//! Physics of a skid-steer robot in a duct: duty of each motor in, encoder counts and ground truth out.
//!
//! In data-flow order:
//!
//! - [`spec`]: the numbers of the body, checked by [`spec_check`];
//! - [`drive`]: a side's DC motor, gear and the links to its two wheels: duty and wheel speeds in, wheel torques out
//!   (`links`: the springs to the wheels and their play);
//! - [`encoder`]: the motor shaft's angle as counts;
//! - [`mount`]: pan and tilt behind a rate limit, with play and encoders;
//! - [`outline`]: the convex parts of the robot, which collide and have a clearance;
//! - [`chassis`]: those parts as Rapier bodies and joints (`axle`: how a wheel is held, rigidly or with give);
//! - [`opening`], [`walls`], [`colliders`]: the duct's faces without their portals, as slabs, as colliders;
//! - [`floors`]: the planes that floors lie in, and which of them a wheel meets;
//! - [`seams`], [`contact_rules`]: no tripping where slabs meet, no floor where there is none;
//! - [`ground`]: how each surface grips;
//! - [`disturbance`]: a wheel's grip lost, a push, a weak or dead motor;
//! - [`settings`]: the engine's;
//! - [`collision`], [`clearance`], [`truth`]: what really happened, which no navigator sees;
//! - [`world`]: all of it, tick by tick.
//!
//! What it does not do: wheels meet the floor as points (they may give radially; no tyre slip, no load-dependent
//! friction), the ducts do not
//! move, and the lens of the physics is one fixed tick. How accurate it is, is measured in `tests/`: yaw rate within 3 % of
//! the four-point-contact theory, drift under 1 mm in 10 m, the same bits for the same inputs.
//!
//! Frames and units: SI, radians; base frame on the floor midway between the four wheels, x forward, y left, z up.
#![forbid(unsafe_code)]

mod axle;
pub mod chassis;
pub mod clearance;
pub mod colliders;
pub mod collision;
pub mod contact_rules;
mod convert;
pub mod disturbance;
pub mod drive;
pub mod encoder;
pub mod floors;
pub mod ground;
mod links;
pub mod mount;
pub mod opening;
pub mod outline;
pub mod seams;
pub mod settings;
pub mod spec;
pub mod spec_check;
pub mod truth;
pub mod walls;
pub mod world;

pub use collision::Collisions;
pub use disturbance::{Disturbance, Push, PushFrame};
pub use ground::Ground;
pub use spec::{DriveSpec, RobotSpec};
pub use spec_check::SpecError;
pub use truth::Truth;
pub use world::{SimError, World};
