//! Where in a profile a stripe may be: a matched filter of several widths.
//!
//! The filter of width w takes the mean of w values less the higher one of the means of w values on either side, beyond a gap of half a
//! width: a bar answers, a step from dark to bright does not. All means come from one running sum, whatever their widths.
//!
//! In white noise the best filter would be the one of the most contrast over its noise, which goes with the square root of the width. But
//! stripes stand in halos, and images have structure: wide filters find both. So the contrast times the fourth root of the width decides,
//! which takes a stripe's core, and the noise only has to be far below it.

use std::ops::Range;

/// A place where a stripe may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak {
    /// The value in the middle.
    pub(super) y: usize,
    /// The filter's width, in pixels.
    pub(super) width: usize,
    /// Mean over the filter's width less that of the brighter side, in grey values.
    pub(super) contrast: f64,
    /// Contrast times the fourth root of the width.
    score: f64,
}

/// The filters, with their buffers.
#[derive(Clone, Debug)]
pub(super) struct Filters {
    widths: Vec<usize>,
    sums: Vec<u32>,
    best: Vec<f32>,
    /// Which filter answered best; as wide as the answers, so that both are worked on together.
    width_of: Vec<u32>,
}

/// A filter of this many times a Gaussian's full width at half maximum answers it best, nearly.
pub(super) const WIDTH_TO_FWHM: f64 = 0.9;
/// From one filter to the next wider one.
const RATIO: f64 = 1.5;
const MOST_FILTERS: usize = 16;

impl Filters {
    /// Filters for stripes from the first to the second full width at half maximum, in pixels.
    pub(super) fn new([least_px, most_px]: [f64; 2]) -> Self {
        let mut widths: Vec<usize> = Vec::new();
        let mut fwhm_px = least_px.max(1.0);
        while fwhm_px < RATIO * most_px && widths.len() < MOST_FILTERS {
            // Odd, so that it has a middle.
            let width = (((WIDTH_TO_FWHM * fwhm_px - 1.0) / 2.0).round() as usize).max(1) * 2 + 1;
            if widths.last() != Some(&width) {
                widths.push(width);
            }
            fwhm_px *= RATIO;
        }
        Self { widths, sums: Vec::new(), best: Vec::new(), width_of: Vec::new() }
    }

    /// The `most` best places of a profile within `span`, in the order of the profile: those of at least so much contrast, and of at least
    /// so much of it over what noise of one grey value makes of it.
    pub(super) fn peaks(
        &mut self,
        profile: &[u16],
        span: Range<usize>,
        [least_snr, least_contrast]: [f64; 2],
        most: usize,
        found: &mut Vec<Peak>,
    ) {
        found.clear();
        self.answer(&profile[span.clone()]);
        let n = span.len();
        for y in 1..n.saturating_sub(1) {
            let score = self.best[y];
            if f64::from(score) < least_contrast || score <= self.best[y - 1] || score < self.best[y + 1] {
                continue;
            }
            // A full stripe answers evenly over some values: their middle, where what follows them is not better still.
            let level = self.best[y..].iter().take_while(|other| **other == score).count();
            let y = y + (level - 1) / 2;
            let width = self.widths[self.width_of[y] as usize];
            let reach = width / 2 + 1;
            if self.best[y.saturating_sub(reach)..(y + reach + 1).min(n)].iter().any(|other| *other > score) {
                continue;
            }
            let score = f64::from(score);
            let contrast = score / gain(width);
            // Both means are of `width` values.
            let snr = contrast * (width as f64 / 2.0).sqrt();
            if contrast < least_contrast || snr < least_snr {
                continue;
            }
            let peak = Peak { y: span.start + y, width, contrast, score };
            if found.len() == most {
                // The weakest makes room.
                let weakest = (0..most).min_by(|a, b| found[*a].score.total_cmp(&found[*b].score));
                match weakest {
                    Some(weakest) if found[weakest].score < score => drop(found.remove(weakest)),
                    _ => continue,
                }
            }
            found.push(peak);
        }
    }

    /// The best answer of any filter at each value, and which one gave it.
    fn answer(&mut self, profile: &[u16]) {
        let n = profile.len();
        self.sums.clear();
        self.sums.push(0);
        // Wraps in images of more than 65 537 pixels a column; differences are right all the same.
        let mut total = 0_u32;
        self.sums.extend(profile.iter().map(|value| {
            total = total.wrapping_add(u32::from(*value));
            total
        }));
        self.best.clear();
        self.best.resize(n, 0.0);
        self.width_of.clear();
        self.width_of.resize(n, 0);
        for (index, &width) in self.widths.iter().enumerate() {
            let gap = width.div_ceil(2);
            // From the first value of the one side to one past the last of the other.
            let reach = 3 * width + 2 * gap;
            if n < reach {
                break;
            }
            let scale = (gain(width) / width as f64) as f32;
            let sums = &self.sums[..];
            let sum =
                |from: usize| sums[from..].iter().zip(&sums[from + width..]).map(|(start, end)| end.wrapping_sub(*start) as i32);
            let (left, inner, right) = (sum(0), sum(width + gap), sum(2 * (width + gap)));
            let middle = width + gap + width / 2;
            let slots = self.best[middle..].iter_mut().zip(&mut self.width_of[middle..]);
            for (((left, inner), right), (best, width_of)) in left.zip(inner).zip(right).zip(slots) {
                let score = (inner - left.max(right)) as f32 * scale;
                let better = score > *best;
                *best = if better { score } else { *best };
                *width_of = if better { index as u32 } else { *width_of };
            }
        }
    }
}

/// What a filter's contrast is multiplied by to be held against others': see the module. It is 1 or more.
fn gain(width: usize) -> f64 {
    (width as f64).sqrt().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peaks(profile: &[u16]) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        Filters::new([2.0, 20.0]).peaks(profile, 0..profile.len(), [10.0, 5.0], 3, &mut found);
        found.iter().map(|peak| (peak.y, peak.width)).collect()
    }

    #[test]
    fn bars_answer_to_filters_of_their_width_and_steps_to_none() {
        for width in [3, 5, 7, 11, 17] {
            let mut profile = vec![20_u16; 200];
            profile[100 - width / 2..=100 + width / 2].fill(120);
            let found = peaks(&profile);
            assert_eq!(found.len(), 1, "{width}: {found:?}");
            let (y, by) = found[0];
            assert!(
                y.abs_diff(100) <= 1 && by as f64 <= 1.6 * width as f64 && width as f64 <= 1.6 * by as f64,
                "{width}: {found:?}"
            );
        }
        let step: Vec<u16> = (0..200).map(|y| if y < 100 { 20 } else { 220 }).collect();
        assert_eq!(peaks(&step), []);
    }

    #[test]
    fn the_best_are_kept_in_their_order() {
        let mut profile = vec![20_u16; 400];
        for (i, height) in [30, 90, 20, 80, 70].iter().enumerate() {
            let at = 50 + 70 * i;
            profile[at - 2..=at + 2].fill(20 + height);
        }
        assert_eq!(peaks(&profile).iter().map(|(y, _)| *y).collect::<Vec<_>>(), [120, 260, 330]);
    }

    #[test]
    fn short_profiles_and_bright_ones_do_no_harm() {
        for length in 0..40 {
            assert_eq!(peaks(&vec![u16::MAX; length]), []);
        }
        // A running sum of 8192 full values fits.
        let mut longest = vec![u16::MAX; 8192];
        longest[..4000].fill(0);
        longest[4005..].fill(0);
        assert_eq!(peaks(&longest).len(), 1);
    }
}
