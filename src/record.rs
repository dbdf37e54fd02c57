//! What a run leaves behind: a record a frame, a few frames' images, and how it ended.

use ductloop_nav::ahead::Outlook;
use ductloop_nav::estimation::Estimate;
use ductloop_nav::messages::{Command, Counts, Sides, Tick};
use ductloop_nav::navigator::{Reason, State};
use ductloop_nav::perception::{Measurement, StripeLine};
use ductloop_nav::rig::MountAngles;
use ductloop_nav::wheel_controller::silence::Hearing;
use ductloop_sensor::renderer::View;
use ductloop_sim::collision::Collisions;
use ductloop_sim::truth::Truth;

use crate::ahead_scores::TrueAhead;
use crate::grey_image::GreyImage;
use crate::link::LinkCounts;
use crate::stage_scores::Score;
use crate::survey::Notes;

/// What the controllers on the body were at, and what became of what they were told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyRecord {
    /// What the wheel controller does about its commands.
    pub hearing: Hearing,
    /// Duty of each motor, -1 to 1.
    pub duty: Sides,
    /// Where the camera points on its mount, as its encoders cannot tell for the play; miscalibration left out.
    pub mount: MountAngles,
    /// Commands to wheel and mount controller that did not get through.
    pub link: LinkCounts,
}

/// One frame: the truth at its exposure, and what the navigator made of it.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRecord {
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Physics tick of its exposure.
    pub tick: Tick,
    /// The same in simulated seconds.
    pub time_s: f64,
    /// What was really the case at the exposure.
    pub truth: Truth,
    /// True width of the duct there, in metres.
    pub width_m: f64,
    /// Collisions up to the exposure.
    pub collisions: Collisions,
    /// Encoder counts handed to the navigator.
    pub counts: Counts,
    /// Mount angles handed to the navigator, as the encoders read them.
    pub mount: MountAngles,
    /// The controllers on the body.
    pub body: BodyRecord,
    /// What the navigator says the frame shows.
    pub measurement: Measurement,
    /// How far each stage of its perception was from what was the case.
    pub score: Score,
    /// How sure it says it is.
    pub state: State,
    /// Why it is no surer.
    pub reason: Option<Reason>,
    /// What its estimator believes, if it has one.
    pub estimate: Option<Estimate>,
    /// What it sees of the duct ahead.
    pub outlook: Option<Outlook>,
    /// What is truly there; `None` where it is off the path.
    pub true_ahead: Option<TrueAhead>,
    /// Where it believes the base is, in the frame of the duct in which it began: along it from there, to the left, heading.
    pub believed_pose: Option<[f64; 3]>,
    /// How many ducts it has been in, the present one included, by its own count.
    pub ducts: usize,
    /// How many lines it found.
    pub lines: usize,
    /// What it commanded; takes effect at the next frame.
    pub command: Command,
    /// What the camera was to see: its pose and motion, exposure, and the light that faults leave.
    pub view: View,
    /// Laser power at the exposure as a share of nominal, faults left out.
    pub laser_power: f64,
    /// Bits of `crate::scenario::Fault`s at work: bit i is fault i.
    pub faults: u32,
}

/// A frame kept with its image.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyFrame {
    /// Number of the frame.
    pub frame: u64,
    /// Its grey values.
    pub image: GreyImage,
    /// The lines that the navigator found in it.
    pub lines: Vec<StripeLine>,
}

/// A few frames spread evenly over a run whose length is not known beforehand.
///
/// Every `stride`-th frame is kept; when there are too many, every other one is dropped and the stride doubled. The last frame
/// is always kept.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyFrames {
    kept: Vec<KeyFrame>,
    last: Option<KeyFrame>,
    stride: u64,
}

impl Default for KeyFrames {
    fn default() -> Self {
        Self { kept: Vec::new(), last: None, stride: 1 }
    }
}

impl KeyFrames {
    /// How many frames [`KeyFrames::spread`] gives at most.
    pub const COUNT: usize = 6;
    const ROOM: usize = 24;

    /// Offers a frame.
    pub fn offer(&mut self, frame: u64, image: &GreyImage, lines: &[StripeLine]) {
        // The buffers of the frame before are used again, so that a steady run allocates nothing here.
        let mut next = self.last.take().unwrap_or_else(|| KeyFrame { frame, image: image.clone(), lines: Vec::new() });
        next.frame = frame;
        next.image.clone_from(image);
        next.lines.clear();
        next.lines.extend_from_slice(lines);
        if frame.is_multiple_of(self.stride) {
            if self.kept.len() == Self::ROOM {
                self.stride *= 2;
                let stride = self.stride;
                self.kept.retain(|kept| kept.frame.is_multiple_of(stride));
            }
            if frame.is_multiple_of(self.stride) {
                self.kept.push(next.clone());
            }
        }
        self.last = Some(next);
    }

    /// Up to [`KeyFrames::COUNT`] frames, evenly spread, the last one among them.
    pub fn spread(&self) -> Vec<&KeyFrame> {
        let Some(last) = &self.last else { return Vec::new() };
        let mut all: Vec<&KeyFrame> = self.kept.iter().filter(|kept| kept.frame != last.frame).collect();
        all.push(last);
        if all.len() <= Self::COUNT {
            return all;
        }
        let step = |i: usize| i * (all.len() - 1) / (Self::COUNT - 1);
        (0..Self::COUNT).map(|i| all[step(i)]).collect()
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndState {
    /// The base passed the finish line.
    Finished,
    /// The simulated time was up.
    TimeLimit,
    /// The navigator stopped for want of sight, or the wheel controller for want of commands, and the robot stood still.
    Stopped,
    /// The base left the duct through an open end, or through a wall.
    Outside,
    /// The caller broke it off: an interrupt, or the limit on wall-clock time.
    BrokenOff,
    /// It could not go on.
    Failed,
}

impl EndState {
    /// Every way a run can end that a scenario may ask for.
    pub const WORDS: [&str; 4] = ["finished", "time-limit", "stopped", "outside"];

    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::TimeLimit => "time-limit",
            Self::Stopped => "stopped",
            Self::Outside => "outside",
            Self::BrokenOff => "broken-off",
            Self::Failed => "failed",
        }
    }
}

/// A whole run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunRecord {
    /// Its frames, in order.
    pub frames: Vec<FrameRecord>,
    /// A few of them with their images.
    pub key_frames: KeyFrames,
    /// How it ended.
    pub end: EndState,
    /// Simulated time at the end, in seconds.
    pub sim_time_s: f64,
    /// Collisions over the whole run.
    pub collisions: Collisions,
    /// Distance along the centreline from start to end, in metres.
    pub distance_m: f64,
    /// What the navigator made known of the duct.
    pub notes: Notes,
    /// XXH3-128 over each frame's tick, pose, image, counts and command.
    pub run_hash: u128,
}

#[cfg(test)]
mod tests {
    use ductloop_sensor::optics::Bits;

    use super::*;

    #[test]
    fn key_frames_are_spread_over_a_run_of_any_length() {
        let image = |frame: u64| GreyImage::of([1, 1], Bits::Eight, &[frame as u16 % 256]).expect("one value");
        for length in [1, 5, 6, 7, 100, 1000, 12_345] {
            let mut keys = KeyFrames::default();
            (0..length).for_each(|frame| keys.offer(frame, &image(frame), &[]));
            let frames: Vec<u64> = keys.spread().iter().map(|k| k.frame).collect();
            assert_eq!(frames.len() as u64, length.min(KeyFrames::COUNT as u64), "{length}: {frames:?}");
            assert_eq!((frames[0], frames[frames.len() - 1]), (0, length - 1), "{length}: {frames:?}");
            let gaps = frames.windows(2).map(|w| w[1] - w[0]);
            let (least, most) = (gaps.clone().min().unwrap_or(0), gaps.max().unwrap_or(0));
            assert!(most <= 2 * least + 1, "{length}: {frames:?}");
            assert!(keys.spread().iter().all(|k| k.image == image(k.frame)));
        }
    }
}
