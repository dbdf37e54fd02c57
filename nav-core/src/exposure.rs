//! Automatic exposure: the next frame's exposure and laser power, from how bright the stripes of this one are.
//!
//! What counts is the dose x = ln(exposure x laser power), to which a stripe's light is proportional. With y = ln(brightness seen)
//! and t = ln(brightness wanted), each frame k moves it by
//!
//! ```text
//! x[k+1] = x[k] + g (t - y[k]),   |x[k+1] - x[k]| <= ln 2,   g = 1/4
//! ```
//!
//! Frame k+1 is exposed as frame k asks, so the error shrinks by 1 - g a frame: stable for 0 < g < 2, without overshoot for
//! g <= 1. A camera that takes one frame longer to obey has z^2 - z + g = 0: stable for g < 1, without oscillation for g <= 1/4.
//! So g = 1/4 does not oscillate either way, and from ten times too dark 15 % remain after ten frames.
//!
//! The brightness is that of the columns in which a stripe shows; when it gets darker the dimmest are lost, so it falls a little less
//! than the dose. That makes the answer slower, not livelier.
//!
//! A stripe that saturates shows less light than there is; it is taken for twice the largest grey value, which is far enough from
//! any target to keep on going and near enough not to fall below it.
//!
//! A frame without stripes changes nothing: it may be a dropped one. Fifteen in a row mean that the dose is wrong, and a search
//! begins: the dose is doubled every other frame up to its limit; if that shows nothing, it starts over from where it was and is
//! halved down to its other limit. Where many pixels are full it is halved first and doubled after that. In either order every dose
//! is met to a factor of two, so stripes that can be seen at all are. Every other frame, so that also with a camera that obeys one
//! frame late it is the present dose that shows them. The first frame with stripes ends the search, and the law takes over; a search
//! in vain goes back to where it began, and begins again after another fifteen frames.
//!
//! The dose is met with the exposure as long as that stays in its range, laser power at its nominal value (or what is nearest to
//! it); beyond the range the power gives way. A long exposure smears what moves, hence the upper limit.

use crate::messages::{Frame, Pixels};
use crate::perception::scan::Across;
use crate::rig::Rig;

/// g of the law.
const GAIN: f64 = 0.25;
/// Largest step of ln(dose) from one frame to the next.
const STEP_MAX: f64 = std::f64::consts::LN_2;
/// Every so many columns (of the scan) one is looked at.
const COLUMN_STRIDE: usize = 4;
/// Least height above its background of a stripe's peak, in DN of 8 bits: what perception asks of it too.
const STRIPE_DN: f64 = 6.0;
/// Share of the columns looked at that must show a stripe before anything is made of it.
const SEEN_SHARE: f64 = 0.05;
/// The peak that counts is the one that this share of the stripe's columns stays below: near walls are bright, and a few of them
/// may saturate rather than that far ones get lost.
const QUANTILE: f64 = 0.9;
/// Depth of the nearest wall, in metres: a stripe is thickest there, and its background is taken from beyond that.
const NEAREST_WALL_M: f64 = 0.25;
/// Pixels of background on either side.
const BACKGROUND_PX: usize = 6;
/// So many frames in a row without stripes begin a search. Half a second at 30 frames a second: a navigator that lost the walls has
/// coasted that long and stands, so that a long exposure smears nothing, and no estimate that could be had is put at risk.
const PATIENCE_FRAMES: u32 = 15;
/// Factor from one dose of a search to the next. The meter reads stripes from 6 DN on and takes saturated ones for stripes too, so
/// wide steps cannot jump over them; two is what the law allows itself in one frame.
const SEARCH_STEP: f64 = 2.0;
/// Each dose of a search is held for so many frames: one, and one more for a camera that obeys late.
const SEARCH_HOLD_FRAMES: u32 = 2;
/// Share of full pixels from which a frame without stripes counts as too bright: far above any share of hot pixels, and a few rows
/// of the image.
const GLARE_SHARE: f64 = 0.01;

/// What automatic exposure aims at and may choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExposureParams {
    /// Brightness wanted: height of the stripes' peaks above their background, in DN of 8 bits ([`Brightness::peak_dn`]).
    pub target_dn: f64,
    /// Shortest and longest exposure, in seconds.
    pub exposure_s: [f64; 2],
    /// Least and most laser power, as shares of nominal.
    pub laser_power: [f64; 2],
    /// Exposure of the first frame, whose laser power is nominal, in seconds.
    pub first_exposure_s: f64,
}

/// How a frame is to be exposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Exposure, in seconds.
    pub exposure_s: f64,
    /// Laser power as a share of nominal.
    pub laser_power: f64,
}

/// How bright the stripes of a frame are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brightness {
    /// Nine tenths of the columns with a stripe have a peak of this height above its background or less, in DN of 8 bits.
    pub peak_dn: f64,
    /// Share of these columns in which the stripe saturates.
    pub saturated: f64,
}

/// What a frame shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// Stripes.
    Stripes(Brightness),
    /// No stripes.
    Nothing {
        /// Share of the frame's pixels that are full.
        full: f64,
    },
}

/// Reads how bright a frame's stripes are, by itself: also of frames in which perception finds no wall.
#[derive(Clone, Debug)]
pub struct Meter {
    across: Across,
    gap_px: usize,
    column: Vec<u16>,
    /// Sums of the column's first values.
    sums: Vec<u32>,
    peaks: Vec<f64>,
}

/// The controller.
#[derive(Clone, Debug)]
pub struct AutoExposure {
    params: ExposureParams,
    meter: Meter,
    /// Of the frame that comes next: exposure times power, in seconds.
    dose_s: f64,
    /// Frames in a row without stripes.
    blind_frames: u32,
    search: Option<Search>,
}

/// A search for stripes through the whole range of doses.
#[derive(Clone, Copy, Debug)]
struct Search {
    /// The dose that it began with, in seconds.
    from_s: f64,
    /// Towards more light.
    up: bool,
    /// The other way was in vain.
    second_way: bool,
}

impl Meter {
    /// For the stripes of a rig.
    pub fn new(rig: &Rig) -> Self {
        let focal_px = rig.camera.focal_px[0].max(rig.camera.focal_px[1]);
        let thickest_px = focal_px * rig.line.at(NEAREST_WALL_M) / NEAREST_WALL_M;
        // 1.25 widths at half maximum either side of the middle hold a Gaussian to its third standard deviation.
        let gap_px = (1.25 * thickest_px).ceil() as usize;
        Self { across: Across::of(rig), gap_px, column: Vec::new(), sums: Vec::new(), peaks: Vec::new() }
    }

    /// How bright the stripes are; `None` where hardly a column shows one.
    pub fn read(&mut self, frame: &Frame<'_>) -> Option<Brightness> {
        let width = match self.across {
            Across::V => frame.width_px,
            Across::U => frame.height_px,
        };
        self.peaks.clear();
        let (mut looked_at, mut saturated) = (0_usize, 0_usize);
        for x in (COLUMN_STRIDE / 2..width).step_by(COLUMN_STRIDE) {
            self.load(frame, x);
            looked_at += 1;
            match self.peak(frame.max_dn) {
                Some(peak) => self.peaks.push(peak / frame.dn_per_dn8()),
                None => {
                    saturated += 1;
                    self.peaks.push(f64::INFINITY);
                }
            }
        }
        self.peaks.retain(|peak| *peak >= STRIPE_DN);
        if (self.peaks.len() as f64) < SEEN_SHARE * looked_at as f64 || self.peaks.is_empty() {
            return None;
        }
        self.peaks.sort_unstable_by(f64::total_cmp);
        let at = (QUANTILE * (self.peaks.len() - 1) as f64) as usize;
        Some(Brightness { peak_dn: self.peaks[at], saturated: saturated as f64 / self.peaks.len() as f64 })
    }

    /// What the frame shows.
    pub fn look(&mut self, frame: &Frame<'_>) -> Seen {
        self.read(frame).map_or_else(|| Seen::Nothing { full: full_share(frame) }, Seen::Stripes)
    }

    /// Takes a column of the scan over.
    fn load(&mut self, frame: &Frame<'_>, x: usize) {
        let width = frame.width_px;
        self.column.clear();
        match (self.across, frame.pixels) {
            (Across::V, Pixels::Grey8(p)) => self.column.extend(p[x..].iter().step_by(width).map(|v| u16::from(*v))),
            (Across::V, Pixels::Grey16(p)) => self.column.extend(p[x..].iter().step_by(width)),
            (Across::U, Pixels::Grey8(p)) => self.column.extend(p[x * width..][..width].iter().map(|v| u16::from(*v))),
            (Across::U, Pixels::Grey16(p)) => self.column.extend_from_slice(&p[x * width..][..width]),
        }
        self.sums.clear();
        self.sums.push(0);
        let mut sum = 0;
        self.sums.extend(self.column.iter().map(|value| {
            sum += u32::from(*value);
            sum
        }));
    }

    /// Height of the column's highest peak above its background, the brighter of the two sides; `None` where it saturates. The
    /// middle one of three neighbours counts, so that a hot pixel is no stripe.
    fn peak(&self, max_dn: u16) -> Option<f64> {
        let margin = self.gap_px + BACKGROUND_PX;
        let (column, sums) = (&self.column, &self.sums);
        let mut highest = 0;
        for y in margin..column.len().saturating_sub(margin) {
            let [a, b, c] = [column[y - 1], column[y], column[y + 1]];
            let middle = a.min(b).max(a.max(b).min(c));
            if middle >= max_dn {
                return None;
            }
            let over = sums[y - self.gap_px] - sums[y - margin];
            let under = sums[y + 1 + margin] - sums[y + 1 + self.gap_px];
            highest = highest.max((u32::from(middle) * BACKGROUND_PX as u32).saturating_sub(over.max(under)));
        }
        Some(f64::from(highest) / BACKGROUND_PX as f64)
    }
}

/// Share of the frame's pixels that are full.
fn full_share(frame: &Frame<'_>) -> f64 {
    let (full, all) = match frame.pixels {
        Pixels::Grey8(p) => (p.iter().filter(|v| u16::from(**v) >= frame.max_dn).count(), p.len()),
        Pixels::Grey16(p) => (p.iter().filter(|v| **v >= frame.max_dn).count(), p.len()),
    };
    full as f64 / all.max(1) as f64
}

impl ExposureParams {
    /// The dose as exposure and laser power: the exposure first.
    pub fn light(&self, dose_s: f64) -> Light {
        let [[shortest_s, longest_s], [least, most]] = [self.exposure_s, self.laser_power];
        let exposure_s = (dose_s / 1.0_f64.clamp(least, most)).clamp(shortest_s, longest_s);
        Light { exposure_s, laser_power: (dose_s / exposure_s).clamp(least, most) }
    }

    /// The nearest dose that can be had, in seconds.
    fn within_reach(&self, dose_s: f64) -> f64 {
        let [[shortest_s, longest_s], [least, most]] = [self.exposure_s, self.laser_power];
        dose_s.clamp(shortest_s * least, longest_s * most)
    }
}

impl AutoExposure {
    /// For the stripes of a rig.
    pub fn new(params: ExposureParams, rig: &Rig) -> Self {
        Self { params, meter: Meter::new(rig), dose_s: params.first_exposure_s, blind_frames: 0, search: None }
    }

    /// How the frame after this one is to be exposed.
    pub fn on_frame(&mut self, frame: &Frame<'_>) -> Light {
        let seen = self.meter.look(frame);
        self.follow(seen)
    }

    /// The law: how the frame is to be exposed that comes after one that shows this.
    pub fn follow(&mut self, seen: Seen) -> Light {
        const LARGEST_DN: f64 = 255.0;
        match seen {
            Seen::Stripes(Brightness { peak_dn, .. }) => {
                (self.blind_frames, self.search) = (0, None);
                let error = libm::log(self.params.target_dn / peak_dn.min(2.0 * LARGEST_DN));
                let factor = libm::exp((GAIN * error).clamp(-STEP_MAX, STEP_MAX));
                self.dose_s = self.params.within_reach(self.dose_s * factor);
            }
            Seen::Nothing { full } => {
                self.blind_frames += 1;
                let searched = self.blind_frames.checked_sub(PATIENCE_FRAMES);
                if searched.is_some_and(|frames| frames % SEARCH_HOLD_FRAMES == 0) {
                    self.search_on(full);
                }
            }
        }
        self.params.light(self.dose_s)
    }

    /// The next dose of a search, or the first after the frame that makes it one.
    fn search_on(&mut self, full: f64) {
        let begin = Search { from_s: self.dose_s, up: full < GLARE_SHARE, second_way: false };
        let mut search = self.search.unwrap_or(begin);
        let next_s = |dose_s: f64, up| self.params.within_reach(if up { dose_s * SEARCH_STEP } else { dose_s / SEARCH_STEP });
        let mut dose_s = next_s(self.dose_s, search.up);
        // At a limit, which this frame was exposed with: there is nothing that way.
        if dose_s == self.dose_s && !search.second_way {
            search = Search { up: !search.up, second_way: true, ..search };
            dose_s = next_s(search.from_s, search.up);
        }
        if dose_s == self.dose_s && search.second_way {
            // All in vain.
            (self.dose_s, self.blind_frames, self.search) = (search.from_s, 0, None);
        } else {
            (self.dose_s, self.search) = (dose_s, Some(search));
        }
    }
}
