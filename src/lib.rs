//! ductloop: a physics-simulated, closed-loop testbed for robots that inspect and clean rectangular air ducts.
//!
//! A [`scenario`] names a duct, a robot, a sensor and what the run must achieve. The [`closed_loop`] moves the robot's body,
//! renders what its camera would see, hands that to a [`pilot`], and drives the wheels as it says; [`metrics`] hold the run
//! against the truth and give the verdict.
//!
//! ```no_run
//! use ductloop::{Pilot, Scenario};
//!
//! let scenario = Scenario::read("scenarios/straight.toml".as_ref(), &Default::default())?;
//! let outcome = ductloop::run(&scenario, Pilot::of(&scenario))?;
//! println!("{:?}: {:?} m RMS beside the centreline", outcome.verdict, outcome.metrics.lateral_rms_m);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Any [`Navigator`], [`Perception`] or [`ControlLaw`] may take the place of the robot's own: see [`Pilot`].
#![forbid(unsafe_code)]

pub mod accuracy;
pub mod ahead_scores;
#[cfg(feature = "cli")]
pub mod bounded_file;
#[cfg(feature = "cli")]
pub mod calibrate;
#[cfg(feature = "cli")]
mod canvas;
pub mod closed_loop;
mod command_check;
pub mod consistency;
#[cfg(feature = "cli")]
pub mod contact_sheet;
mod controllers;
mod derived;
pub mod engine;
pub mod fault;
pub mod grey_image;
mod head;
pub mod library;
pub mod link;
pub mod metrics;
pub mod navigator_process;
#[cfg(feature = "cli")]
pub mod output;
#[cfg(feature = "cli")]
pub mod photograph;
#[cfg(feature = "cli")]
pub mod picture;
#[cfg(feature = "cli")]
mod picture_mark;
pub mod pilot;
pub mod reason_words;
pub mod record;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "cli")]
pub mod run_files;
pub mod run_hash;
pub mod scenario;
mod single_run;
#[cfg(feature = "cli")]
pub mod stage_picture;
pub mod stage_scores;
mod stream;
pub mod survey;
#[cfg(feature = "cli")]
pub mod sweep;
#[cfg(feature = "cli")]
pub mod truth_picture;
#[cfg(feature = "cli")]
pub mod tune;
pub mod viewpoint;

pub use ductloop_nav::control::{ControlLaw, PathState, Twist};
pub use ductloop_nav::messages::{Command, Counts, Frame, Pixels, Sides, Tick};
pub use ductloop_nav::navigator::Navigator;
pub use ductloop_nav::perception::{Measurement, Perception};
pub use ductloop_nav::rig::MountAngles;
pub use engine::Engine;
pub use grey_image::GreyImage;
pub use metrics::{Metrics, Reason, Verdict};
pub use navigator_process::{NavigatorCommand, NavigatorError};
pub use pilot::Pilot;
pub use scenario::Scenario;
pub use single_run::{Outcome, run, run_on};
