//! How accurate the perception is: many poses, each rendered, read and held against the truth. Open loop.
//!
//! In data-flow order:
//!
//! - [`crate::scenario::accuracy_file`]: the file: a grid of scenarios, what is drawn for each pose, what the figures must be;
//! - [`pose`]: where the robot stands in each frame;
//! - [`standing`]: whether all of these places are inside the duct, before anything is rendered;
//! - [`trial`]: one frame: rendered, read by each pipeline, scored ([`crate::stage_scores`]);
//! - [`bound`]: how accurate a reading of it could be at best;
//! - [`all`]: all frames, on all threads, with the same result to the bit whatever their number;
//! - [`figures`]: bias, RMS, worst, detection, consistency, of each cell of the grid and of all; [`verdict`]: what `[pass]` says of them.

pub mod all;
pub mod bound;
pub mod figures;
pub mod pose;
pub mod standing;
pub mod trial;
pub mod verdict;

pub use all::{Trials, carry_out};
pub use figures::{Figures, Spread};
pub use standing::all_stand;
pub use trial::{Again, Trial, TrialError, again};
