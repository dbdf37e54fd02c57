//! How far each stage of a perception is from what was truly the case.
//!
//! - [`truth`]: where the stripes truly are in the image, and on which planes they lie, from geometry alone;
//! - [`mod@score`]: stripe centres, lines, planes and the answer, held against that.
//!
//! Nothing of the perception is shared: the truth comes from the duct's cells, the true rig and the lens' projection of the sensor
//! model. It takes about a millisecond, so every frame of a run is scored.

pub mod score;
mod station;
pub mod truth;

pub use score::{CentreScore, LineScore, Score, WallScore, score};
pub use truth::{Scan, StageTruth, TrueCentre, TruePlane, TruthScene};
