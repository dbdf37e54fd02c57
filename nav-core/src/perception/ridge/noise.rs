//! How much neighbouring grey values scatter: the sensor's noise, as far as an image shows it.

use crate::perception::scan::ScanImage;

/// Measures the scatter; its histogram is kept.
#[derive(Clone, Debug)]
pub(super) struct NoiseMeter {
    /// Of second differences, up to their median and well beyond.
    histogram: Vec<u32>,
}

/// Differences of this size or more count as one: no noise is so large, relative to the largest value of 16 bits.
const BINS: usize = 8192;
/// Every so many values one difference is taken.
const EVERY: usize = 3;
/// Rounding to whole values alone scatters by this.
const ROUNDING: f64 = 0.288_675_134_594_812_9;
/// Median of the magnitude of a normal variable of standard deviation 1.
const MEDIAN_TO_SIGMA: f64 = 0.674_489_750_196_081_7;

impl Default for NoiseMeter {
    fn default() -> Self {
        Self { histogram: vec![0; BINS] }
    }
}

impl NoiseMeter {
    /// Standard deviation of a value, in grey values: by the median of second differences along the profiles, which edges and stripes
    /// hardly move.
    pub(super) fn measure(&mut self, image: &ScanImage) -> f64 {
        self.histogram.fill(0);
        let mut taken = 0_u32;
        for y in 0..image.height {
            for at in image.row(y).windows(3).step_by(EVERY) {
                let second = i64::from(at[0]) - 2 * i64::from(at[1]) + i64::from(at[2]);
                let bin = usize::try_from(second.unsigned_abs()).unwrap_or(BINS).min(BINS - 1);
                self.histogram[bin] += 1;
                taken += 1;
            }
        }
        let mut below = 0;
        let mut median = 0.0;
        for (bin, count) in self.histogram.iter().enumerate() {
            if 2 * (below + count) >= taken && *count > 0 {
                // Within the bin, which reaches half a value either way, as many are below as are missing from the half.
                let share = (f64::from(taken) / 2.0 - f64::from(below)) / f64::from(*count);
                median = if bin == 0 { 0.5 * share } else { bin as f64 - 0.5 + share };
                break;
            }
            below += count;
        }
        (median / (MEDIAN_TO_SIGMA * 6.0_f64.sqrt())).max(ROUNDING)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_known_size_is_measured_beside_edges_and_stripes() {
        let mut state = 1_u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for sigma in [0.0, 1.0, 4.0, 40.0] {
            let mut pixels = Vec::new();
            for i in 0..200 * 150 {
                let normal = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
                let stripe = if i % 200 > 100 && i % 200 < 106 { 500.0 } else { 0.0 };
                let step = if i % 200 > 150 { 300.0 } else { 0.0 };
                pixels.push((1000.0 + stripe + step + sigma * normal).round() as u16);
            }
            let image = ScanImage { width: 200, height: 150, pixels };
            let measured = NoiseMeter::default().measure(&image);
            let expected = (sigma * sigma + ROUNDING * ROUNDING).sqrt();
            // A tenth of the differences is next to an edge, which lifts the median by a tenth or so.
            assert!(measured > 0.95 * expected && measured < 1.25 * expected, "{sigma}: {measured}");
        }
    }

    #[test]
    fn nothing_has_no_noise() {
        assert_eq!(NoiseMeter::default().measure(&ScanImage::default()), ROUNDING);
    }
}
