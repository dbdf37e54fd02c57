//! Frames that do not arrive as they were exposed.
//!
//! What dirt and gain do, they do to the grey values: to light and its noise alike, where real dirt would leave the camera's own noise as
//! it is. Dirt on a front lens is far out of focus: blotches with soft edges, dark in their middle.

use std::collections::VecDeque;
use std::ops::Range;

use ductloop_nav::messages::{Counts, Tick};
use ductloop_nav::rig::MountAngles;

use super::ActiveFaults;
use crate::grey_image::GreyImage;
use crate::scenario::FaultKind;
use crate::stream::uniform;

/// A frame as it was exposed, with what was read at its exposure.
#[derive(Clone, Debug)]
pub struct Exposed {
    /// The image.
    pub image: GreyImage,
    /// The true errors and the duct's width, for a navigator that steers by the truth.
    pub truth: [f64; 3],
    /// Encoder counts.
    pub counts: Counts,
    /// Mount angles.
    pub mount: MountAngles,
    /// When.
    pub tick: Tick,
}

/// What becomes of a frame on its way to the navigator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// It arrives.
    Fresh,
    /// It does not.
    Dropped,
    /// In its place the image that arrived last does.
    Repeated,
    /// In its place one of so many frames ago arrives, with what was read then.
    Late(usize),
}

/// Streams of what happens to frames, and of where dirt is.
const STREAM: [u64; 2] = [0x6672_616d, 0x6469_7274];
/// Dirt is in blotches of this radius, as a share of the image's height; it lets this much through in their middle.
const BLOTCH: f64 = 0.12;
const LET_THROUGH: f64 = 0.15;

/// What becomes of frame `frame`.
pub fn delivery(active: &ActiveFaults<'_>, seed: u64, frame: u64) -> Delivery {
    let mut delivery = Delivery::Fresh;
    for fault in active.iter() {
        let happens = |share: f64| uniform(seed, frame, STREAM[0] + ((fault.index as u64) << 32)) < share;
        match fault.kind {
            FaultKind::FrameDropped { share } if happens(share) => return Delivery::Dropped,
            FaultKind::FrameRepeated { share } if happens(share) => delivery = Delivery::Repeated,
            FaultKind::FrameLate { frames } if delivery == Delivery::Fresh => delivery = Delivery::Late(frames),
            _ => {}
        }
    }
    delivery
}

/// Frames under way: those that a late one may be taken from.
#[derive(Clone, Debug, Default)]
pub struct UnderWay(VecDeque<Exposed>);

impl UnderWay {
    /// Puts a frame in and takes out the one of `late` frames ago; `None` as long as there is none.
    pub fn pass(&mut self, exposed: Exposed, late: usize) -> Option<Exposed> {
        self.0.push_back(exposed);
        while self.0.len() > late + 1 {
            self.0.pop_front();
        }
        if self.0.len() == late + 1 { self.0.pop_front() } else { None }
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

/// Does to the grey values of `image` what dirt and gain do; `black_dn` is that of black, in DN of 8 bits.
pub fn spoil(image: &mut GreyImage, active: &ActiveFaults<'_>, seed: u64, black_dn: f64) {
    for fault in active.iter() {
        match fault.kind {
            FaultKind::LensDirt { share } => {
                for blotch in blotches(seed, fault.index, share, image.size_px()) {
                    image.scale_light(black_dn, blotch.extent(), |u, v| blotch.transmits(u, v));
                }
            }
            FaultKind::GainDrift { rate_1_s } => {
                let gain = libm::exp(rate_1_s * fault.since_s);
                image.scale_light(black_dn, image.size_px().map(|size| 0..size), |_, _| gain);
            }
            _ => {}
        }
    }
}

/// A blotch of dirt.
#[derive(Clone, Copy, Debug)]
struct Blotch {
    centre_px: [f64; 2],
    radius_px: f64,
}

impl Blotch {
    /// The columns and rows that it reaches into.
    fn extent(&self) -> [Range<usize>; 2] {
        self.centre_px.map(|centre| (centre - self.radius_px).max(0.0) as usize..(centre + self.radius_px).ceil() as usize + 1)
    }

    /// What it lets through at a pixel: a smooth step from its middle to its rim.
    fn transmits(&self, u: usize, v: usize) -> f64 {
        let (du, dv) = (u as f64 - self.centre_px[0], v as f64 - self.centre_px[1]);
        let r2 = (du * du + dv * dv) / (self.radius_px * self.radius_px);
        if r2 >= 1.0 {
            return 1.0;
        }
        let soft = (1.0 - r2) * (1.0 - r2);
        1.0 - (1.0 - LET_THROUGH) * soft
    }
}

/// Blotches whose areas add up to `share` of the image; where they overlap less is covered.
fn blotches(seed: u64, index: usize, share: f64, [width, height]: [usize; 2]) -> Vec<Blotch> {
    let radius_px = BLOTCH * height as f64;
    let count = (share * (width * height) as f64 / (std::f64::consts::PI * radius_px * radius_px)).round() as u64;
    let stream = STREAM[1] + ((index as u64) << 32);
    let at = |i: u64, size: usize| uniform(seed, i, stream) * size as f64;
    (0..count).map(|i| Blotch { centre_px: [at(2 * i, width), at(2 * i + 1, height)], radius_px }).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Faults;
    use super::*;
    use crate::scenario::Fault;
    use ductloop_nav::messages::Pixels;
    use ductloop_sensor::optics::Bits;

    fn always(kind: FaultKind) -> Faults {
        Faults(vec![Fault { at_s: 0.0, for_s: None, kind }])
    }

    fn exposed(tick: Tick) -> Exposed {
        let image = GreyImage::of([1, 1], Bits::Eight, &[tick as u16]).expect("a pixel");
        Exposed { image, truth: [0.0; 3], counts: Counts::default(), mount: MountAngles::default(), tick }
    }

    #[test]
    fn frames_are_dropped_by_the_share_and_the_same_ones_for_the_same_seed() {
        let faults = always(FaultKind::FrameDropped { share: 0.3 });
        let dropped =
            |seed: u64| (0..10_000).filter(|i| delivery(&faults.at(1.0), seed, *i) == Delivery::Dropped).collect::<Vec<_>>();
        // 3000 with a deviation of 46.
        assert!((dropped(1).len() as f64 - 3000.0).abs() < 200.0, "{}", dropped(1).len());
        assert_eq!(dropped(1), dropped(1));
        assert_ne!(dropped(1), dropped(2));
    }

    #[test]
    fn a_late_frame_is_that_of_so_many_frames_ago() {
        let mut under_way = UnderWay::default();
        let got: Vec<_> = (0..6).map(|tick| under_way.pass(exposed(tick), 2).map(|exposed| exposed.tick)).collect();
        assert_eq!(got, [None, None, Some(0), Some(1), Some(2), Some(3)]);
    }

    #[test]
    fn gain_scales_what_is_above_black_and_is_cut_off_at_full() {
        let mut image = GreyImage::of([3, 1], Bits::Eight, &[8, 108, 250]).expect("three pixels");
        // exp(0.5 x ln 4) = 2 after half a second.
        spoil(&mut image, &always(FaultKind::GainDrift { rate_1_s: 2.0 * std::f64::consts::LN_2 }).at(0.5), 1, 8.0);
        assert_eq!(image.pixels(), Pixels::Grey8(&[8, 208, 255]));
    }

    #[test]
    fn dirt_darkens_about_its_share_of_the_image() {
        let mut image = GreyImage::of([640, 480], Bits::Eight, &vec![200; 640 * 480]).expect("an image");
        spoil(&mut image, &always(FaultKind::LensDirt { share: 0.3 }).at(1.0), 5, 8.0);
        let Pixels::Grey8(pixels) = image.pixels() else { panic!("8 bits") };
        let darker = pixels.iter().filter(|value| **value < 199).count() as f64 / pixels.len() as f64;
        // Blotches overlap and hang over the border: less than a third, more than a tenth.
        assert!((0.1..0.3).contains(&darker), "{darker}");
        assert!(pixels.iter().all(|value| *value >= 8));
    }
}
