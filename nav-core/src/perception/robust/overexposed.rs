//! The middle of a stripe whose top is cut off, in one column: midway between its flanks.
//!
//! Where most of a stripe is full, little of its Gaussian is left to fit, and that little is its far flanks, which blooming, stray
//! light and uneven reflectance shape more than the stripe does. Still the two places where the light falls through one grey value L
//! lie alike on both sides of the middle, at c - T and c + T. Each is as sure as the noise there over the slope of a Gaussian,
//! L' T / s^2 with L' = L - background; the half width T needs no knowledge of the height that is cut off.

use super::centre::Noise;
use super::view::View;

/// A middle between two flanks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Middle {
    /// In scan coordinates.
    pub(super) y_px: f64,
    /// Its standard deviation, in pixels.
    pub(super) sigma_px: f64,
    /// Half the distance of the flanks, T, in standard deviations of the light.
    pub(super) half_width: f64,
}

/// How far the flanks are sought: so many standard deviations of the light and pixels on either side of where it is expected.
const REACH: [f64; 2] = [4.5, 4.0];
/// Fewest full pixels, in standard deviations of the light: with fewer the fit does better.
const LEAST_FULL: f64 = 0.5;
/// Full pixels are one run over gaps of so many.
const MOST_GAP: usize = 2;
/// By how much flanks may reflect unlike, as a share: spangles, dirt.
const UNEVEN: f64 = 0.1;
/// Between the background and full: where on the flanks the light is taken.
const LEVEL: f64 = 0.5;

/// The middle of the overexposed stripe of width `sigma_px` expected at `guess_px` of column `x`; `values` is room to work in. `None`
/// where nothing is full, or a flank is not in the window.
pub(super) fn middle(
    view: &View<'_>,
    x: usize,
    guess_px: f64,
    sigma_px: f64,
    noise: &Noise,
    values: &mut Vec<f64>,
) -> Option<Middle> {
    let reach = REACH[0] * sigma_px + REACH[1];
    let from = (guess_px - reach).ceil().max(0.0) as usize;
    let to = ((guess_px + reach).floor() + 1.0).clamp(0.0, view.size[1] as f64) as usize;
    let mut least = f64::INFINITY;
    values.clear();
    view.column(x, from, to.max(from), |_, value| {
        values.push(value);
        least = least.min(value);
    });
    let (first, last) = longest_run(values, view.full)?;
    let level = least + LEVEL * (view.full - least);
    // Where the light falls through the level, outward from the run.
    let upper = (0..first).rev().find(|i| values[*i] < level)?;
    let lower = (last + 1..values.len()).find(|i| values[*i] < level)?;
    let crossing = |outside: usize, inside: usize| {
        let share = (level - values[outside]) / (values[inside] - values[outside]);
        outside as f64 + share * (inside as f64 - outside as f64)
    };
    let (upper, lower) = (crossing(upper, upper + 1), crossing(lower, lower - 1));
    let half_width = (lower - upper) / 2.0 / sigma_px;
    if ((last - first) as f64) < LEAST_FULL * sigma_px || half_width > REACH[0] {
        return None;
    }
    let light = level - least;
    let variance = noise.floor + noise.gain * (level - noise.black).max(0.0) + (noise.speckle + UNEVEN * UNEVEN) * light * light;
    let slope = light * half_width / sigma_px;
    Some(Middle { y_px: from as f64 + (upper + lower) / 2.0, sigma_px: (variance / 2.0).sqrt() / slope, half_width })
}

/// First and last of the longest run of full pixels.
fn longest_run(values: &[f64], full: f64) -> Option<(usize, usize)> {
    let mut best: Option<(usize, usize)> = None;
    let mut run: Option<(usize, usize)> = None;
    for i in (0..values.len()).filter(|i| values[*i] >= full) {
        let from = run.filter(|(_, last)| i - last <= MOST_GAP + 1).map_or(i, |(from, _)| from);
        run = Some((from, i));
        if best.is_none_or(|(first, last)| i - from > last - first) {
            best = run;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::Frame;
    use crate::perception::scan::Across;

    const NOISE: Noise = Noise { floor: 1.0 / 12.0 + 0.015, gain: 247.0 / 30_000.0, black: 8.0, speckle: 0.12 * 0.12 };

    fn found(height: f64, sigma: f64, centre: f64, skew: f64) -> Option<Middle> {
        let value = |y: usize| {
            let t = (y as f64 - centre) / sigma;
            (200.0 + height * libm::exp(-t * t / 2.0 + skew * t)).round().min(4095.0) as u16
        };
        let pixels: Vec<u16> = (0..20 * 160).map(|i| value(i / 20)).collect();
        let frame = Frame::grey16(20, 160, &pixels, 4095);
        middle(&View::new(&frame, Across::V), 7, centre + 0.2 * sigma, sigma, &NOISE, &mut Vec::new())
    }

    /// Ten and fifty times overexposed, the middle is found to the interpolation of the flanks (half of what is stated as its deviation).
    #[test]
    fn the_middle_of_a_cut_off_gaussian_is_found() {
        for height in [4e4, 2e5] {
            for sigma in [3.0, 8.0, 14.0] {
                for centre in [80.0, 80.3, 80.71] {
                    let middle = found(height, sigma, centre, 0.0).unwrap_or_else(|| panic!("none at {centre}, sigma {sigma}"));
                    assert!((middle.y_px - centre).abs() < 0.06, "{middle:?} for {centre}, sigma {sigma}");
                    // Closed form: the Gaussian falls to half of full. The interpolation ends at a pixel that is cut off, a tenth of
                    // a pixel too far out at worst, on either side alike.
                    let half_width = (2.0 * libm::log(height / (0.5 * 3895.0))).sqrt();
                    assert!((middle.half_width - half_width).abs() * sigma < 0.12, "{middle:?}, T {half_width}");
                }
            }
        }
    }

    /// Light g (1 + a t / s) moves the middle of a Gaussian by a s, and the flanks of one that is cut off as well.
    #[test]
    fn uneven_light_moves_flanks_as_it_moves_the_middle() {
        let middle = found(8e4, 8.0, 80.0, 0.04).expect("flanks");
        assert!((middle.y_px - 80.0 - 0.04 * 8.0).abs() < 0.03, "{middle:?}");
    }

    #[test]
    fn without_two_flanks_there_is_no_middle() {
        assert_eq!(found(2000.0, 8.0, 80.0, 0.0), None, "nothing full");
        assert_eq!(found(4e4, 40.0, 80.0, 0.0), None, "flanks beyond the image");
        assert_eq!(found(4e4, 8.0, 8.0, 0.0), None, "one flank beyond the image");
    }
}
