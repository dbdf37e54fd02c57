//! Side walls that leave their line without ending: where the duct becomes wider or narrower.
//!
//! Behind an opening nothing is seen but the far side of what opens there, all at one place along the duct. A wall that leaves its line is
//! seen bin after bin, each a little farther off it, until it runs along the duct again.

use super::strip::{BIN_M, Strip};

/// A wall farther off its line than this has left it, in metres; more than a bead.
const OFF_M: f64 = 0.02;
/// Points of one bin of a wall lie within this across the duct, in metres, and this much more per metre of distance from the robot.
const THIN_M: f64 = 0.04;
const THIN_SHARE: f64 = 0.02;
/// Bins without points that a wall may go over, in metres: far ahead a wall is met by few rays.
const GAP_M: f64 = 0.1;
/// Shortest piece of a wall off its line, in metres.
const SHORTEST_M: f64 = 0.2;
/// It runs along the duct again where it keeps its offset within this for so long, in metres.
const KEEPS_M: f64 = 0.008;
const KEEPS_FOR_M: f64 = 0.12;

/// A slope less than this says nothing of where it began, and none began farther back than this, in metres.
const LEAST_SLOPE: f64 = 0.05;
const MOST_BACK_M: f64 = 0.3;

/// A wall that leaves its line and runs along the duct again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallChange {
    /// Where it leaves its line, in metres along the duct.
    pub from_m: f64,
    /// Where it runs along the duct again.
    pub to_m: f64,
    /// Its offset from the middle of the duct from there on, in metres.
    pub offset_m: f64,
}

impl Strip {
    /// Where the wall on a side of a duct that is twice `half_m` wide leaves its line without ending, up to `until`.
    /// `run` is room to work in.
    pub(super) fn change(
        &self,
        side: usize,
        along_m: f64,
        half_m: f64,
        until: i64,
        run: &mut Vec<(i64, f64)>,
    ) -> Option<WallChange> {
        let bins = self.ahead_of(along_m);
        let gap = (GAP_M / BIN_M) as i64;
        // Offsets of the wall, bin by bin.
        run.clear();
        let mut last = i64::MIN;
        for number in bins.start..bins.end.min(until) {
            let Some(flank) = self.bin(number).map(|bin| bin.flanks[side]).filter(|flank| flank.points >= 2.0) else { continue };
            let offset_m = flank.sum_m / flank.points;
            let thin_m = THIN_M + THIN_SHARE * (number as f64 * BIN_M - along_m);
            let is_off = (offset_m - half_m).abs() > OFF_M && flank.reach_m[1] - flank.reach_m[0] < thin_m;
            if !run.is_empty() && number - last > gap {
                if Self::length_m(run) >= SHORTEST_M {
                    break;
                }
                run.clear();
            }
            // It leaves its line by little at first: what jumps is another surface.
            let before = run.last().map_or(half_m, |(_, offset)| *offset);
            let step_m = if run.is_empty() { 3.0 * OFF_M } else { OFF_M * (number - last) as f64 + KEEPS_M };
            if is_off && (offset_m - before).abs() <= step_m {
                run.push((number, offset_m));
                last = number;
            } else if run.is_empty() {
                last = number;
            }
        }
        if Self::length_m(run) < SHORTEST_M {
            return None;
        }
        let place = |number: i64| (number as f64 + 0.5) * BIN_M;
        // The first bin from which on it keeps its offset long enough.
        let keeps = |from: usize| {
            let rest = &run[from..];
            let own = || rest.iter().take_while(|(n, _)| (n - rest[0].0) as f64 * BIN_M <= KEEPS_FOR_M).map(|r| r.1);
            let mean = own().sum::<f64>() / own().count() as f64;
            let spans = Self::length_m(rest) >= KEEPS_FOR_M;
            (spans && own().all(|offset| (offset - mean).abs() <= KEEPS_M)).then_some(mean)
        };
        let (index, offset_m) = (0..run.len()).find_map(|index| Some((index, keeps(index)?)))?;
        // Where it is seen to be off its line it has left it before: back along its slope, which is straight.
        let ((first, off_m), to_m) = (run[0], place(run[index].0));
        let slope = (offset_m - off_m) / (to_m - place(first)).max(BIN_M);
        let back_m = if slope.abs() > LEAST_SLOPE { ((off_m - half_m) / slope).clamp(0.0, MOST_BACK_M) } else { 0.0 };
        Some(WallChange { from_m: place(first) - back_m, to_m, offset_m })
    }

    fn length_m(run: &[(i64, f64)]) -> f64 {
        match (run.first(), run.last()) {
            (Some(first), Some(last)) => (last.0 - first.0 + 1) as f64 * BIN_M,
            _ => 0.0,
        }
    }
}
