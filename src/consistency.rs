//! Whether the estimator errs as much as it says: normalised squares over many seeds, held against chi-square.
//!
//! At each frame the normalised estimation error squared (NEES: lateral offset, heading, width; three degrees of freedom) is averaged
//! over the seeds, and so is the normalised innovation squared (NIS) a degree of freedom. If errors are as large as the covariance
//! says, the mean lies in its 95 % band in 95 % of the frames (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to
//! Tracking and Navigation", 2001, section 5.4). Above the band the filter is overconfident, below it too modest.

use ductloop_nav::estimation::Outcome;
use ductloop_nav::estimation::chi_square::mean_band;

use crate::record::{FrameRecord, RunRecord};

/// Degrees of freedom of the NEES.
pub const FREEDOM: usize = 3;

/// Mean normalised squares over frames and seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Consistency {
    /// Mean over all frames and seeds, a degree of freedom: 1 where deviations are true.
    pub mean: f64,
    /// Band of a frame's mean over the seeds, a degree of freedom.
    pub band: [f64; 2],
    /// Share of the frames whose mean over the seeds lies below the band, in it, above it.
    pub shares: [f64; 3],
    /// Frames that count: those that every seed has.
    pub frames: usize,
}

/// The estimation errors of these runs of one scenario, one a seed; `None` if no frame of all of them has an estimate.
pub fn nees(runs: &[RunRecord]) -> Option<Consistency> {
    over(runs, |frame| {
        let nees = frame.estimate?.nees(frame.truth.lateral_m, frame.truth.heading_rad, frame.width_m)?;
        Some((nees, FREEDOM))
    })
}

/// The innovations of these runs: how far walls were from where they were expected. Refused ones count.
pub fn nis(runs: &[RunRecord]) -> Option<Consistency> {
    over(runs, |frame| match frame.estimate?.outcome {
        Outcome::Taken { nis, freedom } | Outcome::Refused { nis, freedom } => Some((nis, freedom)),
        Outcome::None | Outcome::Begun | Outcome::Useless => None,
    })
}

fn over(runs: &[RunRecord], square: impl Fn(&FrameRecord) -> Option<(f64, usize)>) -> Option<Consistency> {
    let frames = runs.iter().map(|run| run.frames.len()).min()?;
    let (mut all, mut counted, mut shares, mut widest) = (0.0, 0usize, [0usize; 3], None);
    for at in 0..frames {
        let here: Option<Vec<(f64, usize)>> = runs.iter().map(|run| square(&run.frames[at])).collect();
        let Some(here) = here else { continue };
        let freedom: usize = here.iter().map(|(_, freedom)| freedom).sum();
        let mean = here.iter().map(|(square, _)| square).sum::<f64>() / freedom as f64;
        // Frames of other degrees of freedom have bands of their own; the one that is told is the widest.
        let band = mean_band(1, freedom, 0.95);
        let place = if mean < band[0] { 0 } else { 1 + usize::from(mean > band[1]) };
        shares[place] += 1;
        all += mean;
        counted += 1;
        if widest.is_none_or(|[low, high]: [f64; 2]| band[1] - band[0] > high - low) {
            widest = Some(band);
        }
    }
    let share = |count: usize| count as f64 / counted as f64;
    Some(Consistency { mean: all / counted as f64, band: widest?, shares: shares.map(share), frames: counted })
}

/// Effective track and centre of rotation at the end of a run, in metres: what the filter believes, its deviation, and what the robot
/// truly did, fitted by least squares to its turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turning {
    /// Effective track: believed, deviation, true.
    pub track_m: [f64; 3],
    /// Centre of rotation ahead of the base's origin: believed, deviation, true.
    pub icr_m: [f64; 3],
}

/// How the robot turned in a run on one straight; `count_m` is the way of an encoder count. `None` without an estimator or turns.
pub fn turning(run: &RunRecord, count_m: f64) -> Option<Turning> {
    let estimate = run.frames.last()?.estimate?;
    let (mut turned2, mut sides, mut across) = (0.0, 0.0, 0.0);
    for pair in run.frames.windows(2) {
        let [a, b] = [&pair[0], &pair[1]];
        let travel = |from: i64, to: i64| (to - from) as f64 * count_m;
        let (left, right) = (travel(a.counts.left, b.counts.left), travel(a.counts.right, b.counts.right));
        let turn = b.truth.heading_rad - a.truth.heading_rad;
        let middle = 0.5 * (a.truth.heading_rad + b.truth.heading_rad);
        // What the base moved sideways, in its own frame: -x_ICR times its turn.
        let way = 0.5 * (left + right);
        let sideways = (b.truth.lateral_m - a.truth.lateral_m - way * libm::sin(middle)) / libm::cos(middle);
        turned2 += turn * turn;
        sides += (right - left) * turn;
        across -= sideways * turn;
    }
    (turned2 > 0.0).then(|| Turning {
        track_m: [estimate.effective_track_m, estimate.deviation(3), sides / turned2],
        icr_m: [estimate.icr_m, estimate.deviation(4), across / turned2],
    })
}
