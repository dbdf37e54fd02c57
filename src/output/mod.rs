//! What a run writes: its folder, and the JUnit file of a call.
//!
//! - [`summary`]: verdict and figures, `summary.json`;
//! - [`manifest`]: what made them and where, `manifest.json`;
//! - [`frames`]: a row a frame, `frames.parquet`;
//! - [`key_frames`]: some frames as pictures, `frames/*.png`;
//! - [`accuracy`]: a row a pose and pipeline, `accuracy.parquet`;
//! - [`npy`], [`centres`]: arrays and stripe centres, for `ductloop render --truth`;
//! - [`words`]: figures, bounds and reasons as people read them;
//! - [`folder`]: the run's folder, whole or not at all, and the one that all are put into;
//! - [`junit`]: all runs of a call for a CI server.
//!
//! The report's page is [`crate::report`]'s; [`crate::run_files`] puts it all together.

pub mod accuracy;
pub mod centres;
pub mod folder;
pub mod frames;
pub mod junit;
pub mod key_frames;
pub mod manifest;
pub mod npy;
mod stage_name;
pub mod summary;
mod whole_file;
pub mod words;

pub use folder::{FolderError, OutFolder, RunFolder, folder_name};
pub use junit::write_junit;
pub use manifest::Manifest;
pub use summary::Summary;
pub use whole_file::{FileError, try_out as try_whole, write as write_whole};
