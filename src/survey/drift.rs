//! How far the place in which the robot believes to be is from the one in which it is.

use ductloop_duct::Transform;
use ductloop_nav::mapping::Closure;

use super::cloud::world_from_believed;
use super::notes::Notes;
use crate::record::FrameRecord;

/// Distance between believed and true place of the base at the last frame that has a believed one, seen from above, in metres: with
/// the loops closed as `closure` has them.
pub fn drift_m(world_from_first: &Transform, frames: &[FrameRecord], notes: &Notes, closure: &Closure) -> Option<f64> {
    let (frame, pose) = frames.iter().rev().find_map(|frame| Some((frame, frame.believed_pose?)))?;
    let pose = notes.moved(closure, frame.ducts.saturating_sub(1), pose);
    let believed = world_from_believed(world_from_first, pose).translation.vector;
    Some((believed - frame.truth.world_from_base.translation.vector).xy().norm())
}

/// Way of the base from frame to frame, in metres.
pub fn path_m(frames: &[FrameRecord]) -> f64 {
    let place = |frame: &FrameRecord| frame.truth.world_from_base.translation.vector;
    frames.windows(2).map(|pair| (place(&pair[1]) - place(&pair[0])).norm()).sum()
}
